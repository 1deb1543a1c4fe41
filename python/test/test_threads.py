# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of detectAndComputeBatch, and of what the package does while several threads use it, and after a fork. They need
no cv2 but where they ask for it, so that they also run in a Python without a global lock (GIL), for which there may be
none. scripts/python.sh asan repeats them where no wrong access to memory, and no touch of a Python object without the
GIL, goes unseen."""

import concurrent.futures
import multiprocessing
import os
import pickle
import sys
import sysconfig
import threading
import time

import numpy as np
import pytest

import aqorb
from conftest import LINUX, noise, python, values_of

SECONDS = float(os.environ.get('AQORB_LOAD_SECONDS', 0.5))
IMAGES = [noise(i, 96 + 8 * i, 128) for i in range(6)]
KEYPOINTS = np.zeros(3, aqorb.keypoint_dtype)
KEYPOINTS['pt'], KEYPOINTS['size'] = 20, 31


def run_together(*bodies):
    """Calls each body again and again in a thread of its own, for SECONDS. Raises what one of them raises."""
    begin = threading.Barrier(len(bodies))

    def repeat(body):
        begin.wait()
        end = time.monotonic() + SECONDS
        body()
        while time.monotonic() < end:
            body()

    with concurrent.futures.ThreadPoolExecutor(len(bodies)) as pool:
        for done in [pool.submit(repeat, body) for body in bodies]:
            done.result()


def bytes_of(orb, image):
    return b''.join(array.tobytes() for array in orb.detectAndComputeArrays(image))


@pytest.mark.skipif(not sysconfig.get_config_var('Py_GIL_DISABLED'), reason='this Python has a GIL')
def test_the_module_does_not_bring_back_the_gil():
    assert not sys._is_gil_enabled()


CALLS = {
    'compute': lambda orb, image, mask: orb.compute([image] * 50, [KEYPOINTS] * 50),
    'arrays': lambda orb, image, mask: orb.detectAndComputeArrays(image[::-1], mask[::-1]),
    'batch': lambda orb, image, mask: orb.detectAndComputeBatch([image, image[::-1]] * 25, [mask, None] * 25),
    'pyramid': lambda orb, image, mask: orb.buildPyramid(image),
    'threshold': lambda orb, image, mask: aqorb.adaptiveFastThreshold(image, mask)}


@pytest.mark.parametrize('call', CALLS.values(), ids=CALLS.keys())
def test_threads_keep_references(call, orb):
    # The images are small, so that the calls begin and end often.
    image, mask, wrong = np.zeros((40, 40), np.uint8), np.ones((40, 40), np.uint8), np.ones((39, 40), np.uint8)

    def fail():
        with pytest.raises(aqorb.error, match=r'images\[8\]: mask'):
            orb.detectAndComputeBatch([image] * 10, [mask] * 8 + [wrong] * 2)

    before = [sys.getrefcount(item) for item in (image, mask, wrong, KEYPOINTS)]
    run_together(*[lambda: call(orb, image, mask)] * 3, fail, lambda: [[mask, image] * 100 for _ in range(100)])
    assert [sys.getrefcount(item) for item in (image, mask, wrong, KEYPOINTS)] == before


@pytest.mark.parametrize('number', [1, 3])
def test_threads_call_one_detector_and_many(orb, threads, number):
    expected = [bytes_of(orb, image) for image in IMAGES]
    aqorb.setNumThreads(number)

    def with_its_own():
        own = aqorb.AdaptiveQuadtreeORB_create(300)
        assert [bytes_of(own, image) for image in IMAGES] == expected
        own.releaseMemory()

    def in_batches():
        batch = orb.detectAndComputeBatch(IMAGES)
        found = [batch.keypoints(i).tobytes() + batch.descriptors[batch.rows(i)].tobytes() for i in range(len(IMAGES))]
        assert found == expected

    def one_by_one():
        assert [bytes_of(orb, image) for image in IMAGES] == expected

    run_together(*[one_by_one, with_its_own, in_batches] * 2)


def test_setters_and_files_during_calls(tmp_path, orb):
    # A call keeps the parameters that it began with, so that its result is that of one of the settings.
    expected = set()
    for patch_size in 20, 31:
        for radius in 1, 3:
            orb.setPatchSize(patch_size)
            orb.setRankRadius(radius)
            expected.add(bytes_of(orb, IMAGES[0]))
            orb.write(str(tmp_path / '{}{}.yml'.format(patch_size, radius)))
    files = [str(path) for path in tmp_path.iterdir()]

    def detect():
        assert bytes_of(orb, IMAGES[0]) in expected

    def change():
        for patch_size, radius in (20, 3), (31, 1):
            orb.setPatchSize(patch_size)
            orb.setRankRadius(radius)

    def copy():
        assert bytes_of(pickle.loads(pickle.dumps(orb)), IMAGES[0]) in expected

    run_together(detect, detect, change, change, lambda: [orb.read(file) for file in files], copy)
    assert orb.getMaxFeatures() == 300


def test_a_setter_during_a_call_changes_its_own_property_only(unusual):
    # A setter goes on with a copy of the detector while another thread uses it.
    orb, values = unusual

    def change():
        orb.setPatchSize(60)
        orb.setPatchSize(values['PatchSize'])
        assert values_of(orb, values) == values

    run_together(*[lambda: orb.detectAndComputeArrays(IMAGES[0])] * 2, change)


def test_threads_share_a_matcher(orb):
    pytest.importorskip('cv2')
    descriptors = [orb.detectAndComputeArrays(image)[1] for image in IMAGES]
    matcher = aqorb.HammingMatcher_create()

    def found():
        return [match.trainIdx for match in matcher.match(descriptors[0], descriptors[1])]

    expected = found()

    def match():
        assert found() == expected

    def change():
        matcher.add(descriptors)
        assert all(train.shape[1] == 32 for train in matcher.getTrainDescriptors())
        matcher.clone().empty()
        matcher.clear()

    run_together(match, match, change, change)


def test_a_list_that_changes_while_it_is_read(orb):
    images, lists = list(IMAGES), [KEYPOINTS] * 6

    def change():
        for items in images, lists:
            taken = items[2:]
            del items[2:]
            items.extend(taken)

    def compute():
        try:
            orb.compute(images, lists)
        except aqorb.error as error:  # the two are read one after the other
            assert 'one sequence for each image' in str(error)

    run_together(lambda: orb.detectAndComputeBatch(images), compute, change)


EXIT = '''
import threading, time
import numpy as np
import aqorb
image = np.random.RandomState(0).randint(0, 256, (480, 640)).astype(np.uint8)
orb = aqorb.AdaptiveQuadtreeORB_create()
def run():
    while True:
        {}
for _ in range(3):
    threading.Thread(target=run, daemon=True).start()
time.sleep(0.2)
'''


@pytest.mark.parametrize('call', ['orb.detectAndComputeArrays(image)', 'orb.detectAndComputeBatch([image] * 20)'])
def test_the_interpreter_exits_during_a_call(call):
    # With detectAndCompute, cv2.KeyPoint aborts the process here, as cv2's own functions do.
    run = python('-c', EXIT.format(call))
    assert run.returncode == 0, run.stdout


@pytest.mark.skipif(bool(sysconfig.get_config_var('Py_GIL_DISABLED')), reason='this Python has no GIL')
@pytest.mark.parametrize('call', CALLS.values(), ids=CALLS.keys())
def test_the_gil_is_released(orb, call):
    # Within the switch interval another thread runs only if this one lets it.
    image = np.zeros((2000, 2000), np.uint8)
    gate, ran = threading.Semaphore(0), []
    thread = threading.Thread(target=lambda: gate.acquire() and ran.append(True))
    thread.start()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(600)
    try:
        gate.release()
        for _ in range(100):
            if ran:
                break
            call(orb, image, image)
        released = bool(ran)
    finally:
        sys.setswitchinterval(interval)
        thread.join()
    assert released


def test_the_number_of_threads(orb, threads):
    expected = bytes_of(orb, IMAGES[0])
    for number in 1, 2, 5, 3, 1:
        aqorb.setNumThreads(number)
        assert aqorb.getNumThreads() == number and bytes_of(orb, IMAGES[0]) == expected
    aqorb.setNumThreads(-1)
    assert aqorb.getNumThreads() == threads >= 1
    with pytest.raises(aqorb.error, match='nthreads must be at most 8192, got 1000000'):
        aqorb.setNumThreads(10 ** 6)
    aqorb.setNumThreads(8192)
    assert bytes_of(orb, IMAGES[0]) == expected
    for wrong in '2', 2.5, None:
        with pytest.raises(TypeError, match='nthreads'):
            aqorb.setNumThreads(wrong)
    run_together(lambda: bytes_of(orb, IMAGES[0]) == expected or pytest.fail('other features'),
                 lambda: orb.detectAndComputeBatch(IMAGES), lambda: [aqorb.setNumThreads(n) for n in (1, 4, 2)])


def describe(number, threads=3):
    aqorb.setNumThreads(threads)  # of which a child has one nevertheless
    image = np.random.RandomState(number).randint(0, 256, (240, 320)).astype(np.uint8)
    batch = aqorb.AdaptiveQuadtreeORB_create(200).detectAndComputeBatch([image] * 3)
    return batch.descriptors.tobytes(), aqorb.getNumThreads(), len(os.listdir('/proc/self/task'))


@LINUX
def test_processes_that_are_forked(threads):
    # The loops of OpenCV have threads, which the children have not.
    aqorb.setNumThreads(3)
    expected = [describe(number)[0] for number in range(8)]
    children = [multiprocessing.get_context('fork').Process(target=describe, args=(0, number)) for number in (1, 2)]
    for child in children:
        child.start()
    for child in children:
        child.join(60)
        assert child.exitcode == 0
    with multiprocessing.get_context('fork').Pool(3) as pool:
        found = pool.map_async(describe, range(8)).get(60)
        assert [descriptors for descriptors, _, _ in found] == expected
        assert {(number, running) for _, number, running in found} == {(1, 1)}
    assert [describe(number)[0] for number in range(8)] == expected and aqorb.getNumThreads() == 3


# Batches

FIELDS = {'x': np.float32, 'y': np.float32, 'size': np.float32, 'angle': np.float32, 'response': np.float32,
          'octave': np.int32, 'descriptors': np.uint8, 'offsets': np.int64}


@pytest.fixture
def collection(image):
    """Images of all kinds that a single call takes, and masks for some of them."""
    color = np.stack([image, image[::-1], image[:, ::-1]], axis=2)
    images = [image, color[:300], None, np.zeros((90, 80), np.uint8), image[::2, ::3], image[:5, :5], color[..., :1]]
    masks = [None, np.arange(640) % 100 < 60 * np.ones((300, 1)), None, None, image[::2, ::3], None, None]
    return images, masks


@pytest.fixture(params=[1, 2, 3, 4])
def any_number_of_threads(request, threads):
    aqorb.setNumThreads(request.param)


def check(batch, orb, images, masks):
    assert type(batch) is aqorb.FeatureBatch and batch._fields == tuple(FIELDS)
    for name, array in zip(batch._fields, batch):
        assert array.dtype == FIELDS[name] and array.flags.c_contiguous, name
    assert batch.offsets[0] == 0 and len(batch.offsets) == len(images) + 1
    assert batch.descriptors.shape == (batch.offsets[-1], 32)
    assert {len(getattr(batch, name)) for name in batch._fields[:-1]} == {batch.offsets[-1]}
    for i, (image, mask) in enumerate(zip(images, masks)):
        keypoints, descriptors = orb.detectAndComputeArrays(image, mask)
        rows = batch.rows(i)
        assert (rows.start, rows.stop) == (batch.offsets[i], batch.offsets[i + 1])
        assert np.array_equal(batch.descriptors[rows], descriptors)
        assert batch.keypoints(i).dtype == aqorb.keypoint_dtype
        assert np.array_equal(batch.keypoints(i), keypoints)


@pytest.mark.parametrize('count', [0, 1, 2, 7])
def test_a_batch_equals_a_call_for_each_image(orb, collection, count, any_number_of_threads):
    images, masks = [items[:count] for items in collection]
    check(orb.detectAndComputeBatch(images, masks), orb, images, masks)
    check(orb.detectAndComputeBatch(tuple(images)), orb, images, [None] * count)
    check(orb.detectAndComputeBatch(images=images, masks=[]), orb, images, [None] * count)


def test_the_rows_of_an_image(orb, image):
    batch = orb.detectAndComputeBatch([image, image[:200], None])
    assert batch.rows(-1) == batch.rows(2) == slice(600, 600) and batch.rows(-3) == batch.rows(np.int64(0))
    assert len(batch.keypoints()) == 600 and np.array_equal(batch.keypoints()[batch.rows(1)], batch.keypoints(1))
    for wrong in 3, -4:
        for function in batch.rows, batch.keypoints:
            with pytest.raises(IndexError):
                function(wrong)
    with pytest.raises(TypeError):
        batch.rows(1.5)


def test_arrow_takes_the_arrays_without_a_copy(orb, image):
    arrow = pytest.importorskip('pyarrow')
    batch = orb.detectAndComputeBatch([image, None, image[:200]])
    for array in batch[:6] + batch[7:]:
        assert arrow.array(array).buffers()[1].address == array.ctypes.data
    rows = arrow.FixedSizeBinaryArray.from_buffers(arrow.binary(32), len(batch.x),
                                                   [None, arrow.py_buffer(batch.descriptors)])
    assert rows.buffers()[1].address == batch.descriptors.ctypes.data
    lists = arrow.LargeListArray.from_arrays(arrow.array(batch.offsets), rows)
    assert [len(rows) for rows in lists] == [300, 0, 300]
    assert lists[2][5].as_py() == batch.descriptors[305].tobytes()
