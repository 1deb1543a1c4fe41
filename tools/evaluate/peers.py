#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Compares ORB detectors that pip installs, on the same images. scripts/measure.sh peers runs it.

peers.py features DATA FOLDER METHOD   the features of all images, in FOLDER/METHOD.npz
peers.py time DATA FOLDER METHOD       the time on one image after the other, in FOLDER/METHOD-THREADS.txt
peers.py report DATA FOLDER METHOD...  prints a table of the methods

DATA is the folder images_datasets of opencv_extra's testdata.
"""

import os
import sys
import time

import cv2
import numpy as np

import images

COUNT = 1000
KORNIA_COUNT = 640  # asked for so many, kornia-rs finds about 1000 in the mean over these images
SEEDS = 7


def detector(method):
    """Two functions: from a grey image to what the detector returns, and from that to the positions, as an array of
    shape (n, 2), and the descriptors. The time of the first one is measured."""
    if method == 'aqorb-arrays':
        import aqorb
        return (aqorb.AdaptiveQuadtreeORB_create(COUNT).detectAndComputeArrays,
                lambda found: (found[0]['pt'], found[1]))
    if method == 'aqorb' or method.startswith('cv2'):
        if method == 'aqorb':
            import aqorb
            orb = aqorb.AdaptiveQuadtreeORB_create(COUNT)
        else:
            orb = cv2.ORB_create(COUNT)
        return (lambda image: orb.detectAndCompute(image, None),
                lambda found: (np.array([k.pt for k in found[0]], np.float32), found[1]))
    if method.startswith('kornia'):
        from kornia_rs.features import orb_detect_and_compute
        count = COUNT if method == 'kornia' else KORNIA_COUNT
        return (lambda image: orb_detect_and_compute(image, count),
                lambda found: (found.keypoints_xy, found.descriptors))
    if method == 'scikit':
        import skimage.feature

        def detect(image):
            orb = skimage.feature.ORB(n_keypoints=COUNT)
            orb.detect_and_extract(image)
            return orb
        return (detect,
                lambda orb: (orb.keypoints[:, ::-1].astype(np.float32), np.packbits(orb.descriptors, axis=1)))
    return sys.exit('peers.py: there is no method ' + method)


def version(method):
    from importlib import metadata
    names = {'aqorb': 'aqorb', 'cv2': 'opencv-python-headless', 'kornia': 'kornia-rs', 'scikit': 'scikit-image'}
    name = names[method.split('-')[0]]
    shown = '{} {}'.format('`cv2.ORB`, ' + name if method.startswith('cv2') else name, metadata.version(name))
    return shown + {'aqorb-arrays': ', `detectAndComputeArrays`', 'aqorb': ', `detectAndCompute`',
                    'kornia-fewer': ', asked for {}'.format(KORNIA_COUNT)}.get(method, '')


def features(data, folder, method):
    detect, converted = detector(method)
    found = {'version': version(method)}
    for name in images.SETS:
        for i, image in enumerate(images.read_set(data, name)[0]):
            points, descriptors = converted(detect(image))
            found['{}{}points'.format(name, i)] = points
            found['{}{}descriptors'.format(name, i)] = descriptors
    np.savez(os.path.join(folder, method + '.npz'), **found)


def measure_time(data, folder, method):
    """The mean over the first images of the sets of the median time of a call, in ms. The number of threads is that of
    the processors that the process may use."""
    detect = detector(method)[0]
    medians = []
    for name in images.SETS:
        image = images.read_set(data, name)[0][0]
        times = []
        end = time.perf_counter() + 2
        while len(times) < 5 or (time.perf_counter() < end and len(times) < 200):
            start = time.perf_counter()
            detect(image)
            times.append(time.perf_counter() - start)
        medians.append(1000 * np.median(times))
    threads = len(os.sched_getaffinity(0))
    with open(os.path.join(folder, '{}-{}.txt'.format(method, threads)), 'w') as file:
        file.write('{:.3f}\n'.format(np.mean(medians)))


def row(data, folder, method):
    """A method's line of the table."""
    import aqorb
    import measures
    found = np.load(os.path.join(folder, method + '.npz'))
    of_images, of_pairs = [], []
    for name in images.SETS:
        pictures, homographies = images.read_set(data, name)
        features_of = []
        for i, image in enumerate(pictures):
            keypoints = np.zeros(len(found['{}{}points'.format(name, i)]), aqorb.keypoint_dtype)
            keypoints['pt'] = found['{}{}points'.format(name, i)]
            features_of.append(measures.Features(keypoints, found['{}{}descriptors'.format(name, i)]))
            of_images.append((len(keypoints), measures.uniformity(features_of[-1], image)))
        for other, homography in zip(features_of[1:], homographies[1:]):
            points = measures.matched(features_of[0], other, cv2.NORM_HAMMING)
            counts = measures.counts(*points, measures.agree_with_homography(*points, homography), pictures[0])
            of_pairs.append((counts['distinct'], counts['places'],
                             measures.area_under_curve(*points, homography, pictures[0], SEEDS)))
    times = []
    for threads in 1, 2:
        with open(os.path.join(folder, '{}-{}.txt'.format(method, threads))) as file:
            times.append(float(file.read()))
    return '| {} | {:.2f} | {:.2f} | {:.0f} | {:.1f} | {:.1f} | {:.1f} | {:.3f} |'.format(
        found['version'], *times, *np.mean(of_images, 0), *np.mean(of_pairs, 0))


def report(data, folder, *methods):
    print('| detector | ms, 1 thread | ms, 2 threads | keypoints | u | distinct matches | places | AUC at 5 px |')
    print('|---|---|---|---|---|---|---|---|')
    for method in methods:
        print(row(data, folder, method))


if __name__ == '__main__':
    commands = {'features': features, 'time': measure_time, 'report': report}
    if len(sys.argv) < 4 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
