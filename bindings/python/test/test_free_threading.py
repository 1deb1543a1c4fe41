# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests under load that need no cv2, so that they also run in a Python without a global lock (GIL), for which there may be
none. The wheels workflow runs them there."""

import os
import pickle
import sys
import sysconfig
import threading
import time

import numpy as np
import pytest

import aqorb
from conftest import LINUX

SECONDS = float(os.environ.get('AQORB_LOAD_SECONDS', 0.5))
THREADS = 4
random = np.random.RandomState(5)
IMAGES = [np.repeat(np.repeat(random.randint(0, 256, (12 + i, 16), np.uint8), 8, 0), 8, 1) for i in range(6)]


def run_together(*bodies):
    """Calls each body again and again in a thread of its own, for SECONDS. Raises what they raise, and returns how often
    each of them ran."""
    begin, errors, counts = threading.Barrier(len(bodies)), [], [0] * len(bodies)

    def repeat(index):
        try:
            begin.wait()
            end = time.monotonic() + SECONDS
            while time.monotonic() < end and not errors:
                bodies[index]()
                counts[index] += 1
        except BaseException as error:  # an assertion, too
            errors.append(error)

    threads = [threading.Thread(target=repeat, args=(index,)) for index in range(len(bodies))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]
    return counts


def bytes_of(orb, image):
    return b''.join(array.tobytes() for array in orb.detectAndComputeArrays(image))


@pytest.mark.skipif(not sysconfig.get_config_var('Py_GIL_DISABLED'), reason='this Python has a GIL')
def test_the_module_does_not_bring_back_the_gil():
    assert not sys._is_gil_enabled()


@pytest.mark.parametrize('number', [1, 3])
def test_threads_call_one_detector_and_many(number):
    shared = aqorb.AdaptiveQuadtreeORB_create(200)
    expected = [bytes_of(shared, image) for image in IMAGES]
    before = aqorb.getNumThreads()
    aqorb.setNumThreads(number)

    def one_by_one():
        assert [bytes_of(shared, image) for image in IMAGES] == expected

    def with_its_own():
        orb = aqorb.AdaptiveQuadtreeORB_create(200)
        assert [bytes_of(orb, image) for image in IMAGES] == expected
        orb.releaseMemory()

    def in_batches():
        batch = shared.detectAndComputeBatch(IMAGES)
        found = [batch.keypoints(i).tobytes() + batch.descriptors[batch.rows(i)].tobytes() for i in range(len(IMAGES))]
        assert found == expected

    try:
        counts = run_together(*[one_by_one] * 2, *[with_its_own] * 2, *[in_batches] * 2)
    finally:
        aqorb.setNumThreads(before)
    assert min(counts) > 0


def test_setters_and_files_during_calls(tmp_path):
    shared = aqorb.AdaptiveQuadtreeORB_create(200)
    expected = set()
    for cell_size in 20, 35:
        for depth in 2, -1:
            shared.setCellSize(cell_size)
            shared.setMaxDepth(depth)
            expected.add(bytes_of(shared, IMAGES[0]))
            shared.write(str(tmp_path / '{}{}.yml'.format(cell_size, depth)))
    files = [str(path) for path in tmp_path.iterdir()]

    def detect():
        assert bytes_of(shared, IMAGES[0]) in expected

    def change():
        for cell_size, depth in (20, -1), (35, 2):
            shared.setCellSize(cell_size)
            shared.setMaxDepth(depth)
            assert shared.getCellSize() in (20, 35) and shared.getMaxDepth() in (2, -1)

    def read():
        for file in files:
            shared.read(file)

    def copy():
        assert bytes_of(pickle.loads(pickle.dumps(shared)), IMAGES[0]) in expected

    run_together(detect, detect, change, change, read, copy)
    assert shared.getMaxFeatures() == 200


def test_threads_share_a_matcher():
    descriptors = [aqorb.AdaptiveQuadtreeORB_create(200).detectAndComputeArrays(image)[1] for image in IMAGES]
    shared = aqorb.HammingMatcher_create()
    expected = [array.tobytes() for array in shared.matchArrays(descriptors[0], descriptors[1])]

    def match():
        found = shared.matchArrays(descriptors[0], descriptors[1])
        assert [array.tobytes() for array in found] == expected

    def change():
        shared.add(descriptors)
        assert all(train.shape[1] == 32 for train in shared.getTrainDescriptors())
        shared.clone().empty()
        shared.clear()

    run_together(match, match, change, change)


def test_errors_in_threads():
    shared = aqorb.AdaptiveQuadtreeORB_create(200)

    def fail():
        with pytest.raises(aqorb.error, match=r'images\[1\]: mask'):
            shared.detectAndComputeBatch(IMAGES, [None] + [np.ones((3, 3), np.uint8)] * 5)
        with pytest.raises(TypeError, match='cellSize'):
            shared.setCellSize('35')

    run_together(*[fail] * THREADS)


def test_lists_and_arrays_that_change_while_they_are_read():
    shared = aqorb.AdaptiveQuadtreeORB_create(200)
    images = list(IMAGES)

    def change():
        taken = images[2:]
        del images[2:]
        images.extend(taken)

    def detect():
        batch = shared.detectAndComputeBatch(images)
        assert batch.offsets[-1] == len(batch.x)

    run_together(detect, detect, change)


def fork_and_detect(shared, expected):
    child = os.fork()
    if not child:
        os._exit(0 if bytes_of(shared, IMAGES[0]) == expected else 1)
    assert os.waitpid(child, 0)[1] == 0


# pybind11 guards what it knows of all classes by a mutex. Without the GIL another thread may hold it during a fork, and the
# child then waits for it forever; doc/installation.md says so.
@LINUX
@pytest.mark.skipif(bool(sysconfig.get_config_var('Py_GIL_DISABLED')), reason='a child may wait for a mutex of pybind11')
def test_forks_during_calls():
    shared = aqorb.AdaptiveQuadtreeORB_create(200)
    expected = bytes_of(shared, IMAGES[0])

    def change():
        shared.setCellSize(shared.getCellSize())

    run_together(lambda: shared.detectAndComputeBatch(IMAGES), lambda: bytes_of(shared, IMAGES[1]), change,
                 lambda: fork_and_detect(shared, expected))
