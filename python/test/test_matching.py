# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of HammingMatcher and of the functions that return matches as arrays, against cv2.BFMatcher."""

import pickle

import cv2 as cv
import numpy as np
import pytest

import aqorb


def descriptors(seed, rows=200, width=32):
    """Descriptors of which some are equal, and many are at equal distances."""
    random = np.random.RandomState(seed)
    some = random.randint(0, 256, (rows, width)).astype(np.uint8)
    some[rows // 2:] = some[:rows - rows // 2] ^ (random.randint(0, 40, (rows - rows // 2, width)) == 0)
    return some


def values(matches):
    return [(m.queryIdx, m.trainIdx, m.imgIdx, m.distance) for m in matches]


def lists(matches):
    return [values(some) for some in matches]


@pytest.mark.parametrize('norm', [cv.NORM_HAMMING, cv.NORM_HAMMING2])
@pytest.mark.parametrize('width', [32, 61])
def test_has_the_matches_of_bfmatcher(norm, width):
    query, train = descriptors(1, 150, width), descriptors(2, 170, width)
    train[20:60] = query[30:70]
    mask = (np.random.RandomState(3).randint(0, 2, (150, 170)) * 255).astype(np.uint8)
    for cross in (False, True):
        ours, theirs = aqorb.HammingMatcher(norm, cross), cv.BFMatcher(norm, cross)
        assert values(ours.match(query, train)) == values(theirs.match(query, train))
    ours, theirs = aqorb.HammingMatcher_create(norm), cv.BFMatcher_create(norm)
    assert values(ours.match(query, train, mask)) == values(theirs.match(query, train, mask))
    assert lists(ours.knnMatch(query, train, 2)) == lists(theirs.knnMatch(query, train, k=2))
    assert (lists(ours.knnMatch(query, train, 3, mask, True)) ==
            lists(theirs.knnMatch(query, train, k=3, mask=mask, compactResult=True)))
    found = lists(ours.radiusMatch(query, train, 4 * width, mask))
    expected = lists(theirs.radiusMatch(query, train, 4 * width, mask=mask))
    assert found == [sorted(some, key=lambda match: (match[3], match[1])) for some in expected]
    assert isinstance(ours.match(query, train), tuple) and isinstance(ours.match(query, train)[0], cv.DMatch)
    assert isinstance(ours.knnMatch(query, train, 2)[0], tuple)


def test_matches_a_collection():
    query, images = descriptors(1), [descriptors(2, 90), descriptors(3, 110), descriptors(1)]
    masks = [np.ones((200, 90), np.uint8), None, np.zeros((200, 200), np.uint8)]
    ours, theirs = aqorb.HammingMatcher(), cv.BFMatcher(cv.NORM_HAMMING)
    assert ours.empty()
    ours.add(images)
    theirs.add(images)
    ours.train()
    assert not ours.empty() and ours.isMaskSupported()
    assert all(np.array_equal(a, b) for a, b in zip(ours.getTrainDescriptors(), images))
    assert values(ours.match(query)) == values(theirs.match(query))
    assert lists(ours.knnMatch(query, 2)) == lists(theirs.knnMatch(query, k=2))
    assert len({match.imgIdx for match in ours.match(query, masks)}) == 2
    assert values(ours.clone().match(query)) == values(ours.match(query))
    assert ours.clone(True).empty()
    ours.clear()
    assert ours.empty() and ours.match(query) == ()


def test_match_arrays():
    query, train = descriptors(1), descriptors(2, 210)
    train[100:160] = query[10:70] ^ (np.random.RandomState(5).randint(0, 20, (60, 32)) == 0)
    mutual = cv.BFMatcher(cv.NORM_HAMMING, crossCheck=True).match(query, train)
    two = cv.BFMatcher(cv.NORM_HAMMING).knnMatch(query, train, k=2)
    near = [first for first, second in two if first.distance < .8 * second.distance]
    for options, expected in (({}, mutual), ({'maxDistance': 60}, [match for match in mutual if match.distance <= 60]),
                              ({'ratio': .8, 'crossCheck': False}, near)):
        pairs, distances = aqorb.matchArrays(query, train, **options)
        assert pairs.dtype == distances.dtype == np.int32 and len(expected) > 20
        assert list(zip(*pairs.T, distances)) == [(m.queryIdx, m.trainIdx, m.distance) for m in expected]


def test_match_by_position():
    query = np.random.RandomState(1).randint(0, 256, (200, 32)).astype(np.uint8)
    predicted = np.random.RandomState(4).rand(200, 2) * 100
    keypoints = tuple(cv.KeyPoint(float(x) + 15, float(y) + 5, 31) for x, y in predicted)
    for trained in (keypoints, aqorb.keypointsToArray(keypoints)):
        pairs, distances = aqorb.matchByPosition(query, predicted, query[::-1], trained[::-1], (20, 8))
        assert len(pairs) > 100 and (pairs.sum(1) == 199).all() and not distances.any()
        assert not len(aqorb.matchByPosition(query[:1], predicted[:1], query[:1], trained[:1], (8, 20))[0])
    of_cv2 = aqorb.matchByPosition(query, predicted[:, None], query[::-1], keypoints[::-1], (20, 8))
    assert np.array_equal(of_cv2[0], pairs)
    everywhere = aqorb.matchByPosition(query, predicted, query, keypoints, (np.inf, np.inf))
    assert np.array_equal(everywhere[0], aqorb.matchArrays(query, query)[0])


@pytest.mark.parametrize('create', [aqorb.AdaptiveQuadtreeORB_create] + [
    getattr(cv, name) for name in ('AKAZE_create', 'BRISK_create') if hasattr(cv, name)])
def test_match_guided(create):
    noise = np.random.RandomState(7).randint(0, 256, (300, 400)).astype(np.uint8)
    image = cv.normalize(cv.GaussianBlur(noise, (0, 0), 3), None, 0, 255, cv.NORM_MINMAX)
    (points1, rows1), (points2, rows2) = [create().detectAndCompute(some, None) for some in (image, image[:, 40:])]
    rectified = np.float32([[0, 0, 0], [0, 0, -1], [0, 1, 0]])
    for some1, some2 in ((points1, points2), map(aqorb.keypointsToArray, (points1, points2))):
        pairs, distances = aqorb.matchGuided(rows1, some1, rows2, some2, rectified, 3)
        assert pairs.dtype == distances.dtype == np.int32 and pairs.shape == (len(distances), 2)
    offsets = cv.KeyPoint_convert(points1)[pairs[:, 0]] - cv.KeyPoint_convert(points2)[pairs[:, 1]]
    assert len(pairs) > 50 and (np.hypot(*(offsets - [40, 0]).T) < 3).mean() > .8
    assert (distances <= 90 * rows1.shape[1] // 32).all()
    more = aqorb.matchGuided(rows1, points1, rows2, points2, rectified.tolist(), np.inf, None, 8 * rows1.shape[1])
    assert np.array_equal(more[0], aqorb.matchArrays(rows1, rows2, crossCheck=False)[0])


def test_knn_match_arrays():
    query, train = descriptors(1), descriptors(2, 5)
    indices, distances = aqorb.knnMatchArrays(query, train, 7)
    assert indices.shape == distances.shape == (200, 7) and indices.dtype == distances.dtype == np.int32
    expected = cv.BFMatcher(cv.NORM_HAMMING).knnMatch(query, train, k=5)
    assert np.array_equal(indices[:, :5], [[match.trainIdx for match in some] for some in expected])
    assert np.array_equal(distances[:, :5], [[match.distance for match in some] for some in expected])
    assert (indices[:, 5:] == -1).all() and (distances[:, 5:] == -1).all()


@pytest.mark.parametrize('nothing', [None, np.zeros((0, 32), np.uint8)])
def test_no_descriptors(nothing):
    some = descriptors(1)
    for pairs, distances in (aqorb.matchArrays(some, nothing),
                             aqorb.matchByPosition(some, np.zeros((200, 2)), nothing, (), (9, 9))):
        assert pairs.shape == (0, 2) and distances.shape == (0,) and pairs.dtype == distances.dtype == np.int32
    assert aqorb.knnMatchArrays(nothing, some, 2)[0].shape == (0, 2)
    assert (aqorb.knnMatchArrays(some, nothing, 2)[0] == -1).all()
    assert aqorb.HammingMatcher().match(some, nothing) == ()


@pytest.mark.parametrize('error, message, call', [
    (aqorb.error, 'normType must', lambda some: aqorb.HammingMatcher(cv.NORM_L2)),
    (aqorb.error, 'queryDescriptors must', lambda some: aqorb.HammingMatcher().match(some.astype(np.float32), some)),
    (aqorb.error, r'descriptors\[1\] must', lambda some: aqorb.HammingMatcher().add([some, some[0]])),
    (aqorb.error, 'ratio must', lambda some: aqorb.matchArrays(some, some, ratio=-1)),
    (aqorb.error, 'trainKeypoints must', lambda some: aqorb.matchByPosition(some, some[:, :2], some, (), (1, 1))),
    (TypeError, 'queryDescriptors must', lambda some: aqorb.matchArrays([1], some)),
    (TypeError, 'ratio must', lambda some: aqorb.matchArrays(some, some, ratio='a')),
    (TypeError, 'maxDistance must', lambda some: aqorb.matchArrays(some, some, maxDistance=1.5)),
    (aqorb.error, 'F must', lambda some: aqorb.matchGuided(some, (), some, (), np.eye(2), 3)),
    (TypeError, 'F: ', lambda some: aqorb.matchGuided(some, (), some, (), 'a', 3)),
    (aqorb.error, 'predicted must', lambda some: aqorb.matchByPosition(some, some[:, None], some, (), (1, 1))),
    (TypeError, 'predicted: ', lambda some: aqorb.matchByPosition(some, 'a', some, (), (1, 1))),
    (TypeError, 'reach: [Tt]uple', lambda some: aqorb.matchByPosition(some, some[:, :2], some, (), 5))])
def test_bad_arguments(error, message, call):
    with pytest.raises(error, match=message):
        call(descriptors(1, 10))


def test_an_object_that_was_not_initialised():
    matcher, some = aqorb.HammingMatcher.__new__(aqorb.HammingMatcher), descriptors(1)
    for call in (matcher.empty, matcher.clear, matcher.clone, matcher.getTrainDescriptors,
                 lambda: pickle.dumps(matcher, 0), lambda: matcher.add([some]), lambda: matcher.match(some, some),
                 lambda: matcher.knnMatch(some, 1)):
        with pytest.raises(TypeError, match='__init__'):
            call()
    matcher.__init__()
    assert len(matcher.match(some, some)) == len(some)
