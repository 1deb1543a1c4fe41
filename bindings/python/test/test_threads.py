# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of what the package does while several threads use it. scripts/python.sh --asan repeats them where no wrong
access to memory, and no touch of a Python object without the GIL, goes unseen."""

import multiprocessing
import os
import subprocess
import sys
import threading
import time

import cv2 as cv
import numpy as np
import pytest

import aqorb
from conftest import LINUX, never_freed, values_of

SECONDS = 0.5
OWN_THREADS = pytest.mark.skipif(not aqorb._aqorb._has_own_opencv,
                                 reason='the threads are those of the OpenCV that is shared with cv2')


def run_together(*bodies):
    """Calls each body again and again in a thread of its own, for SECONDS. Raises what they raise."""
    end = time.monotonic() + SECONDS
    errors = []

    def repeat(body):
        try:
            while time.monotonic() < end and not errors:
                body()
        except BaseException as error:  # an assertion, too
            errors.append(error)

    threads = [threading.Thread(target=repeat, args=(body,)) for body in bodies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


def count_references(objects):
    return [sys.getrefcount(item) for item in objects]


@pytest.mark.parametrize('call', [
    lambda orb, image, mask: orb.detect([image] * 50, [mask] * 50),
    lambda orb, image, mask: orb.detect([image] * 50, [mask, None] * 25),
    lambda orb, image, mask: orb.compute([image] * 50, [KEYPOINTS] * 50),
    lambda orb, image, mask: orb.detectAndCompute(image, mask),
    lambda orb, image, mask: orb.detectAndComputeArrays(image[::-1], mask[::-1]),
    lambda orb, image, mask: orb.detectAndComputeBatch([image, image[::-1]] * 25, [mask, None] * 25),
    lambda orb, image, mask: orb.buildPyramid(image),
    lambda orb, image, mask: aqorb.adaptiveFastThreshold(image, mask)],
    ids=['detect', 'detect with some masks', 'compute', 'detectAndCompute', 'arrays', 'batch', 'pyramid', 'threshold'])
def test_threads_keep_references(call):
    # The images are small, so that the calls begin and end often.
    orb = aqorb.AdaptiveQuadtreeORB_create()
    image, mask = np.zeros((40, 40), np.uint8), np.ones((40, 40), np.uint8)
    objects = image, mask, KEYPOINTS, KEYPOINTS[0]
    before = count_references(objects)
    run_together(*[lambda: call(orb, image, mask)] * 4, lambda: [[mask, image] * 100 for _ in range(100)])
    assert count_references(objects) == before


KEYPOINTS = [cv.KeyPoint(20, 20, 31)] * 3


def test_threads_keep_references_when_calls_fail():
    orb = aqorb.AdaptiveQuadtreeORB_create()
    image, mask, wrong = np.zeros((40, 40), np.uint8), np.ones((40, 40), np.uint8), np.ones((39, 40), np.uint8)

    def fail():
        with pytest.raises(aqorb.error, match='mask'):
            orb.detect([image] * 10, [mask] * 9 + [wrong])
        with pytest.raises(aqorb.error, match=r'images\[8\]: mask'):
            orb.detectAndComputeBatch([image] * 10, [mask] * 8 + [wrong] * 2)

    before = count_references((image, mask, wrong))
    run_together(*[fail] * 4)
    assert count_references((image, mask, wrong)) == before


def test_a_setter_during_a_call(orb, image):
    # A call keeps the parameters that it began with, so that its result is that of one of the settings.
    small = image[:120, :160]
    settings = [(1, 31), (8, 31), (3, 20), (12, 50)]

    def use(nlevels, patch_size):
        orb.setNLevels(nlevels)
        orb.setPatchSize(patch_size)

    expected = set()
    for nlevels, _ in settings:  # the setters are two calls, so that other pairs are met, too
        for _, patch_size in settings:
            use(nlevels, patch_size)
            expected.add(orb.detectAndComputeArrays(small)[1].tobytes())

    def detect():
        assert orb.detectAndComputeArrays(small)[1].tobytes() in expected

    run_together(detect, detect, lambda: [use(*setting) for setting in settings])


def test_reading_parameters_during_a_call(tmp_path, image):
    files = [str(tmp_path / name) for name in ('small.yml', 'large.yml')]
    aqorb.AdaptiveQuadtreeORB_create(nlevels=1, patchSize=5).write(files[0])
    aqorb.AdaptiveQuadtreeORB_create(nlevels=30, patchSize=301).write(files[1])
    orb = aqorb.AdaptiveQuadtreeORB_create()
    run_together(*[lambda: orb.detectAndComputeArrays(image[:120, :160])] * 2, lambda: [orb.read(f) for f in files])


def test_a_setter_during_a_call_changes_its_own_property_only(unusual, image):
    # A setter goes on with a copy of the detector while another thread uses it.
    orb, values = unusual

    def change():
        orb.setCellSize(60)
        orb.setCellSize(values['CellSize'])
        assert values_of(orb, values) == values

    run_together(*[lambda: orb.detectAndComputeArrays(image)] * 2, change)


def test_a_list_that_changes_while_it_is_read(orb, image):
    # cv2 releases the GIL for each keypoint that is made, and Python between any two instructions.
    keypoints = list(orb.detect(image))
    images = [image[:40, :40]] * 20

    def change():
        for items in keypoints, images:
            taken = items[5:]
            del items[5:]
            items.extend(taken)

    run_together(lambda: aqorb.keypointsToArray(keypoints), lambda: orb.compute(image, keypoints),
                 lambda: orb.detect(images), lambda: orb.detectAndComputeBatch(images), change)


def test_a_keypoint_that_changes_its_list():

    class Treacherous(cv.KeyPoint):
        @property
        def pt(self):
            keypoints.clear()
            return 50., 50.

    keypoints = [never_freed(Treacherous()) for _ in range(1000)]
    assert len(aqorb.keypointsToArray(keypoints)) == 1000


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
    run = subprocess.run([sys.executable, '-c', EXIT.format(call)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                         timeout=300)
    assert run.returncode == 0, run.stdout


POINTS = aqorb.keypointsToArray([cv.KeyPoint(999, 999, 31)] * 1000)


@pytest.mark.parametrize('call', [
    lambda orb, image: orb.detect(image),
    lambda orb, image: orb.detect([image]),
    lambda orb, image: orb.compute(image, POINTS),
    lambda orb, image: orb.compute([image], [POINTS]),
    lambda orb, image: orb.detectAndCompute(image, None),
    lambda orb, image: orb.detectAndComputeArrays(image),
    lambda orb, image: orb.detectAndComputeBatch([image, image[:99]]),
    lambda orb, image: aqorb.adaptiveFastThreshold(image)])
def test_the_gil_is_released(orb, call):
    # Within the switch interval another thread runs only if this one lets it. The image is blank, as making a
    # cv2.KeyPoint releases the GIL, too.
    image = np.zeros((2000, 2000), np.uint8)
    gate, ran = threading.Semaphore(0), []
    thread = threading.Thread(target=lambda: gate.acquire() and ran.append(True))
    thread.start()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(600)
    try:
        gate.release()
        for _ in range(1000):
            if ran:
                break
            call(orb, image)
        released = bool(ran)
    finally:
        sys.setswitchinterval(interval)
        thread.join()
    assert released


def test_threads_share_a_detector(orb, image):
    expected = orb.detectAndComputeArrays(image)[1]
    results = []
    threads = [threading.Thread(target=lambda: results.append(orb.detectAndComputeArrays(image)[1]))
               for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4 and all(np.array_equal(result, expected) for result in results)


@pytest.fixture
def threads():
    """The number of threads, which is set back afterwards."""
    number = aqorb.getNumThreads()
    yield number
    aqorb.setNumThreads(number)


def threads_of_process():
    return len(os.listdir('/proc/self/task'))


def test_the_number_of_threads(orb, image, threads):
    expected = orb.detectAndComputeArrays(image)[1]
    for number in 1, 2, 5, 3, 1:
        aqorb.setNumThreads(number)
        assert aqorb.getNumThreads() == number
        assert np.array_equal(orb.detectAndComputeArrays(image)[1], expected)
    aqorb.setNumThreads(0)
    assert aqorb.getNumThreads() == 1
    aqorb.setNumThreads(-1)
    assert aqorb.getNumThreads() == threads >= 1
    for wrong in '2', 2.5, None:
        with pytest.raises(TypeError, match='nthreads'):
            aqorb.setNumThreads(wrong)


def test_setting_the_number_of_threads_during_a_call(orb, image, threads):
    expected = orb.detectAndComputeArrays(image)[1]

    def detect():
        assert np.array_equal(orb.detectAndComputeArrays(image)[1], expected)

    def detect_in_batch():
        batch = orb.detectAndComputeBatch([image] * 5)
        assert all(np.array_equal(batch.descriptors[batch.rows(i)], expected) for i in range(5))

    run_together(detect, detect_in_batch, detect_in_batch, lambda: [aqorb.setNumThreads(number) for number in (1, 4, 2)])


NUMBER = '''
import os
import numpy as np
import aqorb
image = np.random.RandomState(0).randint(0, 256, (480, 640)).astype(np.uint8)
before = len(os.listdir('/proc/self/task'))
aqorb.AdaptiveQuadtreeORB_create().detectAndComputeArrays(image)
print(aqorb.getNumThreads(), len(os.listdir('/proc/self/task')) - before)
'''


@LINUX
@OWN_THREADS
@pytest.mark.parametrize('number', [1, 3])
def test_the_number_of_threads_by_an_environment_variable(number):
    run = subprocess.run([sys.executable, '-c', NUMBER], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                         env=dict(os.environ, OPENCV_FOR_THREADS_NUM=str(number)))
    assert run.stdout.split() == [str(number), str(number - 1)]


def describe(number):
    image = np.random.RandomState(number).randint(0, 256, (240, 320)).astype(np.uint8)
    return aqorb.AdaptiveQuadtreeORB_create(200).detectAndComputeArrays(image)[1].tobytes()


@LINUX
@OWN_THREADS
def test_processes_that_are_forked(orb, image, threads):
    aqorb.setNumThreads(3)
    expected = [describe(number) for number in range(8)]
    context = multiprocessing.get_context('fork')
    stop = threading.Event()

    def detect():
        while not stop.is_set():
            orb.detectAndComputeArrays(image)

    def detect_in_batches():
        while not stop.is_set():
            orb.detectAndComputeBatch([image] * 50)

    # The processes begin while other threads are in calls.
    busy = [threading.Thread(target=target) for target in (detect, detect, detect_in_batches)]
    for thread in busy:
        thread.start()
    try:
        for _ in range(5):
            with context.Pool(3) as pool:
                assert pool.map_async(describe, range(8)).get(60) == expected
    finally:
        stop.set()
        for thread in busy:
            thread.join()
    assert [describe(number) for number in range(8)] == expected


def fork():
    child = os.fork()
    if not child:
        os._exit(0)
    return child


@pytest.mark.parametrize('wait', [lambda: aqorb.setNumThreads(2), pytest.param(fork, marks=LINUX)],
                         ids=['setNumThreads', 'fork'])
def test_who_waits_for_calls_stops_no_thread_of_python(orb, threads, wait):
    image = np.random.RandomState(0).randint(0, 256, (4000, 4000)).astype(np.uint8)

    def steps_meanwhile():
        begun, waited = threading.Event(), threading.Event()

        def detect():
            while not waited.is_set():
                orb.detectAndComputeArrays(image)

        def begin():
            begun.set()
            child = wait()
            waited.set()
            if child:
                os.waitpid(child, 0)

        running = [threading.Thread(target=target) for target in (detect, detect, begin)]
        for thread in running:
            thread.start()
        begun.wait()
        steps = 0
        while not waited.is_set():
            time.sleep(0.001)
            steps += 1
        for thread in running:
            thread.join()
        return steps

    # A call may end just when somebody begins to wait for it. With the GIL held there are some steps before and after.
    assert sorted(steps_meanwhile() for _ in range(5))[2] > 12


def fork_that_detects():
    child = os.fork()
    if not child:
        os._exit(0 if CHILD.detectAndComputeBatch([SMALL] * 4).offsets[-1] else 1)
    return child


CHILD = aqorb.AdaptiveQuadtreeORB_create()
SMALL = np.random.RandomState(0).randint(0, 256, (240, 320)).astype(np.uint8)


@pytest.mark.parametrize('wait', [lambda: aqorb.setNumThreads(3), pytest.param(fork_that_detects, marks=LINUX)],
                         ids=['setNumThreads', 'fork'])
@pytest.mark.parametrize('number', [1, 2])
def test_who_waits_for_calls_waits_for_no_whole_batch(orb, threads, number, wait):
    images = [np.random.RandomState(0).randint(0, 256, (480, 640)).astype(np.uint8)] * 400
    aqorb.setNumThreads(number)
    expected = orb.detectAndComputeArrays(images[0])[1]

    def goes_on_afterwards():
        begun, ended, batches = threading.Event(), threading.Event(), []

        def detect():
            begun.set()
            batches.append(orb.detectAndComputeBatch(images))
            ended.set()

        thread = threading.Thread(target=detect)
        thread.start()
        begun.wait()
        time.sleep(0.02)
        child = wait()
        time.sleep(0.1)  # a batch that is complete by now ends
        goes_on = not ended.is_set()
        thread.join()
        if child:
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert np.array_equal(batches[0].descriptors.reshape(400, -1, 32), np.stack([expected] * 400))
        return goes_on

    # Another program may keep this thread from running for as long as the batch takes.
    assert any(goes_on_afterwards() for _ in range(4))


def count_threads_of_a_child(_):
    describe(0)
    return aqorb.getNumThreads(), threads_of_process()


@LINUX
@OWN_THREADS
def test_a_forked_process_has_threads_of_its_own(threads):
    aqorb.setNumThreads(3)
    describe(0)
    with multiprocessing.get_context('fork').Pool(1) as pool:
        number, running = pool.map_async(count_threads_of_a_child, [0]).get(60)[0]
    assert number == 3 and running >= 3


WITHOUT_THREADS = '''
import resource
import numpy as np
import aqorb
image = np.random.RandomState(0).randint(0, 256, (480, 640)).astype(np.uint8)
aqorb.setNumThreads(1)
expected = aqorb.AdaptiveQuadtreeORB_create().detectAndComputeArrays(image)[1]
aqorb.setNumThreads(4)
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
assert np.array_equal(aqorb.AdaptiveQuadtreeORB_create().detectAndComputeArrays(image)[1], expected)
batch = aqorb.AdaptiveQuadtreeORB_create().detectAndComputeBatch([image] * 3)
assert np.array_equal(batch.descriptors, np.concatenate([expected] * 3))
'''


@LINUX
@OWN_THREADS
def test_goes_on_where_no_thread_can_be_started():
    import resource  # which Windows does not have

    # A thread's stack would be larger than the memory that the process may have.
    def limit_stack():
        resource.setrlimit(resource.RLIMIT_STACK, (4 << 30, resource.getrlimit(resource.RLIMIT_STACK)[1]))

    run = subprocess.run([sys.executable, '-c', WITHOUT_THREADS], preexec_fn=limit_stack, stdout=subprocess.PIPE,
                         stderr=subprocess.STDOUT, text=True, timeout=300, env=dict(os.environ, OPENBLAS_NUM_THREADS='1'))
    assert run.returncode == 0, run.stdout
