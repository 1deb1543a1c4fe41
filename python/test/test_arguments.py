# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of what the package accepts as an argument, and of what it says about the rest."""

import collections
import re
import reprlib

import cv2 as cv
import numpy as np
import pytest

import aqorb
from conftest import LINUX, python

KEYPOINT = cv.KeyPoint(100, 100, 31)
SEQUENCE = 'keypoints must be a sequence of cv2.KeyPoint or an array of aqorb.keypoint_dtype, got '


def message_of(error, call):
    with pytest.raises(error) as raised:
        call()
    assert type(raised.value) is error
    return str(raised.value)


@pytest.mark.parametrize('wrong, message', [
    (None, SEQUENCE + 'None'), ('x' * 99, SEQUENCE + "'xxxxxxxxxxxx...xxxxxxxxxxxxx'"),
    ('\udcff', SEQUENCE + r"'\udcff'"), ({}, SEQUENCE + '{}'), (KEYPOINT, SEQUENCE + reprlib.repr(KEYPOINT)),
    ([KEYPOINT, None], 'keypoints[1] must be a cv2.KeyPoint, got None'),
    (np.array([KEYPOINT, 5]), 'keypoints[1] must be a cv2.KeyPoint, got 5')])
def test_things_that_are_no_keypoints(orb, image, wrong, message):
    for call in (lambda: orb.compute(image, wrong), lambda: aqorb.retainUniform(wrong, (640, 480), 5),
                 lambda: aqorb.keypointsToArray(wrong)):
        assert message_of(TypeError, call) == message
    of_list = message.replace('keypoints', 'keypoints[0]', 1)
    assert message_of(TypeError, lambda: orb.compute([image], [wrong])) == of_list


@pytest.mark.parametrize('wrong', [
    np.zeros((5, 7), np.float32), np.zeros(5), np.zeros((1, 1), aqorb.keypoint_dtype), np.array(KEYPOINT, object),
    np.zeros(2, aqorb.keypoint_dtype.newbyteorder())])
def test_arrays_that_are_no_keypoints(orb, image, wrong):
    with pytest.raises(aqorb.error, match=SEQUENCE + r'an array of dtype .* and shape \(.*\)'):
        orb.compute(image, wrong)


@pytest.mark.parametrize('kind', [list, tuple, np.array, collections.deque,
                                  lambda keypoints: np.array(keypoints * 2, object)[::2][:len(keypoints)]])
def test_keypoints_of_any_sequence(orb, image, kind):
    keypoints = orb.detect(image)[:1] * 20
    expected = orb.compute(image, keypoints)[1]
    computed, descriptors = orb.compute(image, kind(keypoints))
    assert type(computed) is tuple and np.array_equal(descriptors, expected)
    computed, descriptors = orb.compute([image], [kind(keypoints)])
    assert np.array_equal(descriptors[0], expected)


def test_keypoints_as_an_array_of_records(orb, image):
    keypoints = orb.detectAndComputeArrays(image)[0]
    expected = orb.compute(image, keypoints)[1]
    read_only = keypoints.copy()
    read_only.flags.writeable = False
    for array in keypoints.view(np.recarray), read_only, keypoints[::-1][::-1], np.repeat(keypoints, 2)[::2]:
        computed, descriptors = orb.compute(image, array)
        assert computed.dtype == aqorb.keypoint_dtype and np.array_equal(descriptors, expected)
    assert np.array_equal(read_only, keypoints)


def test_arrays_that_no_memory_can_hold(orb):
    with pytest.raises(MemoryError):
        orb.detect(np.lib.stride_tricks.as_strided(np.zeros(1, np.uint8), (2 ** 30, 2 ** 30), (0, 0)))
    with pytest.raises(MemoryError):
        aqorb.keypointsToArray(np.broadcast_to(np.zeros(1, aqorb.keypoint_dtype), (10 ** 12,)))


@pytest.mark.parametrize('wrong', ['x', 5, b'x', {}, cv.UMat])
def test_things_that_are_no_image(orb, image, wrong):
    for message, call in (
            ('image must be a numpy array', lambda: orb.detect(wrong)),
            ('image must be a numpy array', lambda: orb.compute(wrong, [])),
            ('images[1] must be a numpy array', lambda: orb.detect([image, wrong])),
            ('mask must be a numpy array or None', lambda: orb.detectAndCompute(image, wrong)),
            ('masks[0] must be a numpy array or None', lambda: orb.detect([image], [wrong])),
            ('masks must be a sequence of numpy arrays or None', lambda: orb.detect([image], wrong))):
        assert message_of(TypeError, call) == message + ', got ' + reprlib.repr(wrong)


@pytest.mark.parametrize('wrong', [
    np.zeros((40, 40), bool), np.zeros((40, 40), object), np.zeros((40, 40), 'S1'), np.zeros((40, 40), [('grey', 'u1')]),
    np.zeros(40, np.uint8), np.array(5, np.uint8), np.zeros((2, 40, 40, 3), np.uint8)])
def test_arrays_that_are_no_image(orb, image, wrong):
    given = ' must be uint8 .*' + re.escape(f', got an array of dtype {wrong.dtype} and shape {wrong.shape}')
    for images, name in (wrong, 'image'), ([image, wrong], r'images\[1\]'):
        with pytest.raises(aqorb.error, match='^' + name + given):
            orb.detect(images)


def test_arrays_that_are_read_only(orb, image):
    frozen, mask = image.copy(), image > 99
    expected = orb.detectAndCompute(image, mask.astype(np.uint8))[1]
    frozen.flags.writeable = mask.flags.writeable = False
    of_bytes = np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape)
    for given in frozen, of_bytes:
        assert np.array_equal(orb.detectAndCompute(given, mask)[1], expected)
    # A level of the pyramid is the caller's to change, also that of the image itself.
    orb.buildPyramid(frozen)[0][:] = 0
    assert np.array_equal(frozen, image)


def test_masks_of_several_images(orb, image):
    mask, everywhere = np.zeros(image.shape, np.uint8), len(orb.detect(image))
    for masks in None, [], (), [None, None]:
        assert [len(found) for found in orb.detect([image, image], masks)] == [everywhere] * 2
    with pytest.raises(aqorb.error, match='masks must be one for each image or none, got 1 for 2 images'):
        orb.detect([image, image], [mask])
    with pytest.raises(aqorb.error, match=r'masks\[1\] must be uint8 or bool .*, got an array of dtype float64'):
        orb.detect([image, image], [None, mask * 1.])


def test_empty_lists(orb, image):
    assert orb.detect([]) == orb.detect(()) == orb.detect([], []) == orb.detect([], None) == []
    assert orb.compute([], []) == ([], [])
    assert orb.detect([None]) == [()]
    assert orb.compute([None, image], [[], ()]) == ([(), ()], [None, None])
    assert orb.compute(image, []) == orb.compute(image, ()) == ((), None)
    assert aqorb.retainUniform([], (640, 480), 5) == ()
    with pytest.raises(aqorb.error, match='keypoints must be one sequence for each image, got 0 for 1 images'):
        orb.compute([image], [])
    assert message_of(TypeError, lambda: orb.compute([image], None)) == (
        'keypoints must be a sequence of keypoints for each of several images, got None')


@pytest.mark.parametrize('wrong', [5, None, (640,), (640, 480, 3), (640., 480.), '12', (2 ** 40, 1), {1: 2, 3: 4},
                                   (np.float32(640), 480)])
def test_sizes(wrong):
    for name, call in (('imageSize', lambda: aqorb.distributionUniformity([], wrong)),
                       ('imageSize', lambda: aqorb.distributionOccupancy([], wrong)),
                       ('imageSize', lambda: aqorb.retainUniform([], wrong, 5)),
                       ('grid', lambda: aqorb.distributionOccupancy([], (640, 480), wrong))):
        assert re.search(name + r': [Tt]uple\[', message_of(TypeError, call))
    for size in [640, 480], np.array([640, 480]), (np.int64(640), np.uint8(200)):
        assert aqorb.distributionOccupancy([KEYPOINT], size, (1, 1)) == 1


def test_numbers(orb):
    orb.setPatchSize(np.int64(50))
    orb.setOctaveSuppression(np.float32(0.5))
    orb.setSubPixel(np.bool_(False))
    assert (orb.getPatchSize(), orb.getOctaveSuppression(), orb.getSubPixel()) == (50, 0.5, False)
    create = aqorb.AdaptiveQuadtreeORB_create
    for wrong in '50', 50.5, None, [50], np.float32(50), np.array([50]):
        assert 'patchSize: int' in message_of(TypeError, lambda: orb.setPatchSize(wrong))
        assert 'nfeatures: int' in message_of(TypeError, lambda: create(wrong))
    for wrong in '1', None, [1.5]:
        assert 'rankRadius: ' in message_of(TypeError, lambda: orb.setRankRadius(wrong))
    assert 'subPixel: bool' in message_of(TypeError, lambda: orb.setSubPixel('yes'))
    assert 'nfeatures: int' in message_of(TypeError, lambda: create(nFeatures=5))


ROWS = np.zeros((5, 32), np.uint8)
PARAMETERS = ('nfeatures', 'nlevels', 'edgeThreshold', 'firstLevel', 'WTA_K', 'scoreType', 'patchSize', 'fastThreshold')
MATCHER = aqorb.HammingMatcher()


@pytest.mark.parametrize('name, call', [
    *[(name, lambda number, name=name: aqorb.AdaptiveQuadtreeORB_create(**{name: number})) for name in PARAMETERS],
    ('selectionType', aqorb.AdaptiveQuadtreeORB_create().setSelectionType),
    ('npoints', lambda number: aqorb.retainUniform([], (640, 480), number)),
    ('normType', aqorb.HammingMatcher), ('normType', lambda number: aqorb.matchArrays(ROWS, ROWS, normType=number)),
    ('k', lambda number: aqorb.knnMatchArrays(ROWS, ROWS, number)),
    ('k', lambda number: MATCHER.knnMatch(ROWS, number)), ('k', lambda number: MATCHER.knnMatch(ROWS, ROWS, number)),
    ('nthreads', aqorb.setNumThreads)])
def test_integers(name, call):
    for wrong in 2 ** 31, 2 ** 64, -2 ** 31 - 1:
        assert message_of(aqorb.error, lambda: call(wrong)) == f'{name} must be an int of 32 bits, got {wrong}'
    for wrong in np.float32(2.9), np.float64(3), 3.:
        assert f'{name}: int' in message_of(TypeError, lambda: call(wrong))


class Failing:
    """Fails in its conversion to a number, from the `calls`-th one on."""

    def __init__(self, error, calls=1):
        self.error, self.calls = error, calls

    def __index__(self):
        self.calls -= 1
        if self.calls <= 0:
            raise self.error
        return 5

    def __float__(self):
        return float(self.__index__())


@pytest.mark.parametrize('error', [KeyboardInterrupt, ZeroDivisionError])
@pytest.mark.parametrize('calls', [1, 2])
def test_errors_of_a_conversion(error, calls):
    for call in (aqorb.AdaptiveQuadtreeORB_create, aqorb.HammingMatcher, lambda number: MATCHER.knnMatch(ROWS, number),
                 lambda number: aqorb.matchArrays(ROWS, ROWS, maxDistance=number),
                 lambda number: aqorb.matchArrays(ROWS, ROWS, number)):
        number = Failing(error, calls)
        try:
            call(number)
        except error:
            assert number.calls <= 0
        except aqorb.error:  # of the number 5
            assert number.calls == 1
        else:
            assert number.calls == 1


LACK = '''
import resource
import numpy as np
import aqorb
image, rows = np.zeros((8000, 8000), np.uint8), np.zeros((20000, 32), np.uint8)
orb = aqorb.AdaptiveQuadtreeORB_create()
for call in lambda: orb.detectAndComputeArrays(image), lambda: aqorb.knnMatchArrays(rows, rows[:9], 10000):
    used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + 2 ** 25, -1))
    try:
        call()
    except MemoryError as error:
        assert isinstance(error, aqorb.error) and error.code == -4, error
    else:
        raise AssertionError('there was enough')
'''


@LINUX
def test_lack_of_memory():
    run = python('-c', LACK)
    assert run.returncode == 0, run.stdout
