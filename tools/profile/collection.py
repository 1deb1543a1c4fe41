#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Measures how many images a second the Python package processes on one thread, on two, and in two processes.

The ways take turns, and each processes the same images in each turn. A process of two has half of them. Prints CSV. The
package is the one that Python finds. scripts/performance.sh collection runs this program.
"""

import argparse
import glob
import multiprocessing
import os
import threading
import time

import aqorb
import numpy as np

SIZE = 640, 480
FEATURES = 1000


def photographs(folder):
    """The sets of images of opencv_extra, and their names; or drawn images where there is no folder."""
    if not folder:
        random = np.random.RandomState(0)
        coarse = random.randint(0, 256, (36, SIZE[1] // 8, SIZE[0] // 8), np.uint8)
        return list(np.repeat(np.repeat(coarse, 8, 1), 8, 2) ^ random.randint(0, 8, (36, SIZE[1], SIZE[0]), np.uint8))
    import cv2 as cv
    files = glob.glob(os.path.join(folder, 'cv/detectors_descriptors_evaluation/images_datasets/*/img*.png'))
    if not files:
        raise SystemExit('collection.py: {} has no images_datasets'.format(folder))
    return [cv.resize(cv.imread(file, cv.IMREAD_GRAYSCALE), SIZE, interpolation=cv.INTER_AREA) for file in sorted(files)]


class Process:
    """A process that waits for its turns."""

    def __init__(self, folder, count, part):
        context = multiprocessing.get_context('spawn')
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=self.work, args=(other, folder, count, part), daemon=True)
        self.process.start()
        self.pipe.recv()

    @staticmethod
    def work(pipe, folder, count, part):
        aqorb.setNumThreads(1)
        images = (photographs(folder) * count)[:count][part::2]
        detector = aqorb.AdaptiveQuadtreeORB_create(FEATURES)
        pipe.send(True)
        while pipe.recv():
            pipe.send((len(images), *timed(lambda: len(detector.detectAndComputeBatch(images).x))))


def timed(work):
    """What the work returns, and the seconds that it takes."""
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def in_processes(processes):
    """The rate is the sum of the rates of both, so that neither waits for the other."""
    for process in processes:
        process.pipe.send(True)
    counts, found, seconds = zip(*[process.pipe.recv() for process in processes])
    return sum(found), sum(counts) / sum(count / second for count, second in zip(counts, seconds))


def in_batch(images, detector, threads):
    aqorb.setNumThreads(threads)
    return len(detector.detectAndComputeBatch(images).x)


def one_by_one(images, detector, threads):
    aqorb.setNumThreads(threads)
    return sum(len(detector.detectAndComputeArrays(image)[0]) for image in images)


def in_threads_of_python(images, detector):
    """Each thread of Python calls the same detector for one image after the other."""
    aqorb.setNumThreads(1)
    found = []

    def work(part):
        found.extend([len(detector.detectAndComputeArrays(image)[0]) for image in part])

    threads = [threading.Thread(target=work, args=(images[i::2],)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sum(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--images', type=int, default=200, help='how many are processed in a turn')
    parser.add_argument('--repeats', type=int, default=21)
    arguments = parser.parse_args()
    folder = os.environ.get('OPENCV_TEST_DATA_PATH', '')
    images = (photographs(folder) * arguments.images)[:arguments.images]
    detector = aqorb.AdaptiveQuadtreeORB_create(FEATURES)
    processes = [Process(folder, arguments.images, part) for part in range(2)]
    ways = [('1 thread', lambda: in_batch(images, detector, 1)),
            ('2 threads', lambda: in_batch(images, detector, 2)),
            ('2 processes', None),
            ('2 threads of Python', lambda: in_threads_of_python(images, detector)),
            ('2 threads for each image', lambda: one_by_one(images, detector, 2))]
    expected = in_batch(images, detector, 1)
    print('way,repeat,images,seconds')
    for repeat in range(-1, arguments.repeats):
        for i in range(len(ways)):
            name, work = ways[(i + repeat) % len(ways)]
            found, seconds = timed(work) if work else in_processes(processes)
            if found != expected:
                raise SystemExit('collection.py: {} found {} features, not {}'.format(name, found, expected))
            if repeat >= 0:  # one is for caches and memory
                print('{},{},{},{:.6f}'.format(name, repeat, arguments.images, seconds), flush=True)


if __name__ == '__main__':
    main()
