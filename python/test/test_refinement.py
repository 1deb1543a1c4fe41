# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of refinement and growth as functions of Python. Those of the module test their positions."""

import cv2 as cv
import numpy as np
import pytest

import aqorb

SHIFT = 3.4


@pytest.fixture(scope='module')
def pair():
    """Two images, of which the second shows everything further right, with their features and matches."""
    y, x = np.mgrid[:240, :320].astype(np.float32)
    waves = [(.31, .12), (.07, .41), (-.23, .29), (.53, -.11), (-.17, -.37), (.6, .5)]

    def image(x):
        return np.uint8(128 + 18 * sum(np.sin(a * x + b * y + i) for i, (a, b) in enumerate(waves)))
    images = image(x), image(x - SHIFT)
    orb = aqorb.AdaptiveQuadtreeORB_create(300)
    (points1, rows1), (points2, rows2) = [orb.detectAndComputeArrays(some) for some in images]
    return images[0], points1, images[1], points2, aqorb.matchArrays(rows1, rows2)[0]


def matches_of(pairs):
    return tuple(cv.DMatch(int(query), int(train), 7, 2.5) for query, train in pairs)


def test_positions_are_refined(pair):
    image1, keypoints1, image2, keypoints2, pairs = pair
    left, points1, points2 = aqorb.refineMatchArrays(*pair)
    assert left.dtype == np.int32 and points1.dtype == points2.dtype == np.float32
    assert points1.shape == points2.shape == left.shape and len(left) > 50
    assert set(map(tuple, left)) <= set(map(tuple, pairs)) and (np.diff(left[:, 0]) > 0).all()
    assert np.array_equal(points1, keypoints1['pt'][left[:, 0]])
    errors = np.abs(points2 - points1 - [SHIFT, 0]).max(1)
    before = np.abs(keypoints2['pt'][left[:, 1]] - points1 - [SHIFT, 0]).max(1)
    assert np.median(errors) < .05 < np.median(before)
    every, _, points = aqorb.refineMatchArrays(*pair, minCorrelation=-1)
    assert np.array_equal(every, pairs) and len(points) == len(pairs)


def test_objects_of_cv2_give_the_same(pair):
    image1, keypoints1, image2, keypoints2, pairs = pair
    expected = aqorb.refineMatchArrays(*pair)
    objects1, objects2 = map(aqorb.keypointsFromArray, (keypoints1, keypoints2))
    given = matches_of(pairs)
    for matches in given, list(given), np.array(given):
        left, points1, points2 = aqorb.refineMatches(image1, objects1, image2, keypoints2, matches)
        assert type(left) is tuple and type(left[0]) is cv.DMatch
        assert [(m.queryIdx, m.trainIdx, m.imgIdx, m.distance) for m in left] == [
            (query, train, 7, 2.5) for query, train in expected[0]]
        assert np.array_equal(points1, expected[1]) and np.array_equal(points2, expected[2])
    homography, inliers = cv.findHomography(points1, points2, cv.RANSAC, .5)
    assert inliers.sum() > 50 and abs(homography[0, 2] - SHIFT) < .1
    reversed_types = aqorb.refineMatchArrays(image1, keypoints1, image2, objects2, pairs.astype(np.uint64))
    assert np.array_equal(reversed_types[2], expected[2])


def test_deviations_are_of_the_same_matches(pair):
    image1, keypoints1, image2, keypoints2, pairs = pair
    *expected, deviations = aqorb.refineMatchArraysWithDeviations(*pair, .8)
    for got, same in zip(expected, aqorb.refineMatchArrays(*pair)):
        assert np.array_equal(got, same)
    assert deviations.dtype == np.float32 and deviations.shape == (len(expected[0]),) and (deviations > 0).all()
    matches, *positions, again = aqorb.refineMatchesWithDeviations(*pair[:4], matches_of(pairs), .8, scaleFactor=1)
    assert np.array_equal(again, deviations) and np.array_equal(positions, expected[1:])
    assert [match.queryIdx for match in matches] == list(expected[0][:, 0])
    keypoints1 = keypoints1.copy()
    keypoints1['size'][pairs[0, 0]] = 0
    every = aqorb.refineMatchArraysWithDeviations(image1, keypoints1, image2, keypoints2, pairs, -1)[3]
    assert len(every) == len(pairs) and np.isinf(every[0]) and np.isfinite(every).sum() > 50


def test_matches_grow(pair):
    image1, keypoints1, image2, keypoints2, pairs = pair
    few = pairs[::4]
    refined, _, refined2 = aqorb.refineMatchArrays(*pair[:4], few)
    grown, points1, points2, deviations = aqorb.growMatchArrays(*pair[:4], few)
    assert np.array_equal(grown[:len(refined)], refined) and np.array_equal(points2[:len(refined)], refined2)
    into1, into2 = (np.flatnonzero(column == -1) for column in grown.T)
    assert np.array_equal(np.concatenate([into2, into1]), np.arange(len(refined), len(grown)))
    assert len(into2) > len(refined) and len(into1) > 10
    assert (np.diff(grown[into2, 0]) > 0).all() and (np.diff(grown[into1, 1]) > 0).all()
    assert np.array_equal(points1[:into1[0]], keypoints1['pt'][grown[:into1[0], 0]])
    assert np.array_equal(points2[into1], keypoints2['pt'][grown[into1, 1]])
    assert np.median(np.abs(points2 - points1 - [SHIFT, 0]).max(1)) < .05 and deviations.shape == (len(grown),)
    one_way = aqorb.growMatchArrays(*pair[:4], few, bothWays=False)
    assert all(map(np.array_equal, one_way, (each[:into1[0]] for each in (grown, points1, points2, deviations))))
    for form, kind in (np.copy, np.ndarray), (aqorb.keypointsFromArray, tuple):
        given = form(keypoints1), form(keypoints2)
        matches, *both, got1, got2, got = aqorb.growMatches(image1, given[0], image2, given[1], matches_of(few))
        assert type(matches) is tuple and [len(each) for each in given] == [len(keypoints1), len(keypoints2)]
        assert all(map(np.array_equal, (got1, got2, got), (points1, points2, deviations)))
        assert [match.distance for match in matches[len(refined):]] == [np.finfo(np.float32).max] * (
            len(grown) - len(refined))
        indices = np.array([(match.queryIdx, match.trainIdx) for match in matches])
        assert np.array_equal(indices[grown >= 0], grown[grown >= 0])
        for all_of, own, column, moved in zip(both, (keypoints1, keypoints2), indices.T, (points1, points2)):
            assert isinstance(all_of, kind)
            places = aqorb.keypointsToArray(all_of)
            assert np.array_equal(places[:len(own)], own)
            assert np.array_equal(places['pt'][column[len(refined):]], moved[len(refined):])


def test_images_are_matched(pair):
    image1, _, image2 = pair[:3]
    points1, points2, deviations = aqorb.matchImages(image1, image2, 300)
    assert points1.dtype == points2.dtype == deviations.dtype == np.float32
    assert points1.shape == points2.shape == (len(deviations), 2) and (np.diff(deviations) >= 0).all()
    _, expected1, expected2, unsorted = aqorb.growMatchArrays(*pair)
    order = np.argsort(unsorted, kind='stable')
    assert all(map(np.array_equal, (points1, points2, deviations), (expected1[order], expected2[order], unsorted[order])))
    assert len(points1) > 200 and np.median(np.abs(points2 - points1 - [SHIFT, 0]).max(1)) < .05
    colours = [cv.cvtColor(image, cv.COLOR_GRAY2BGR) for image in (image1, image2)]
    assert np.array_equal(aqorb.matchImages(*colours, nfeatures=300)[1], points2)
    for nothing in None, np.zeros((0, 0), np.uint8), np.zeros((90, 120), np.uint8):
        for images in (image1, nothing), (nothing, image2):
            assert [each.shape for each in aqorb.matchImages(*images)] == [(0, 2), (0, 2), (0,)]
    for name, arguments in ('image1', (image1 / 2, image2)), ('image2', (image1, image2[0])), ('nfeatures', (*images, -1)):
        with pytest.raises(aqorb.error, match=name + ' must'):
            aqorb.matchImages(*arguments)


@pytest.mark.parametrize('create', ['AKAZE_create', 'BRISK_create'])
def test_matches_of_other_detectors_grow(pair, create):
    if not hasattr(cv, create):
        pytest.skip('OpenCV 5 has it in its contrib modules')
    (keypoints1, descriptors1), (keypoints2, descriptors2) = [
        getattr(cv, create)().detectAndCompute(image, None) for image in pair[:3:2]]
    matches = cv.BFMatcher(cv.NORM_HAMMING, True).match(descriptors1, descriptors2)[::4]
    matches, grown1, grown2, points1, points2, _ = aqorb.growMatches(
        pair[0], keypoints1, pair[2], keypoints2, matches, scaleFactor=5)
    assert len(grown1) > len(keypoints1) and len(grown2) > len(keypoints2)
    assert len(matches) > 40 and np.median(np.abs(points2 - points1 - [SHIFT, 0]).max(1)) < .05


def test_keypoints_move_by_a_homography(pair):
    image1, keypoints1, image2 = pair[:3]
    moved = aqorb.transformKeypoints(keypoints1, np.array([[1, 0, SHIFT + 1], [0, 1, 0], [0, 0, 1]]))
    assert np.abs(moved['pt'] - keypoints1['pt'] - [SHIFT + 1, 0]).max() < 1e-3
    found, points1, points2 = aqorb.refineMatchArrays(image1, keypoints1, image2, moved,
                                                      np.arange(len(moved)).repeat(2).reshape(-1, 2))
    assert len(found) > 200 and np.median(np.abs(points2 - points1 - [SHIFT, 0]).max(1)) < .05
    assert type(aqorb.transformKeypoints(aqorb.keypointsFromArray(keypoints1), np.eye(3, dtype=int))) is tuple
    for error, message, wrong in ((TypeError, 'homography must be an array', 'x'),
                                  (aqorb.error, 'homography must be an array', np.zeros(9)),
                                  (aqorb.error, 'homography must be 3x3', np.full((3, 3), np.nan))):
        with pytest.raises(error, match=message):
            aqorb.transformKeypoints(keypoints1, wrong)


def test_points_without_sizes_are_refined(pair):
    image1, keypoints1, image2 = pair[:3]
    points1 = keypoints1['pt']
    for shape in (-1, 2), (-1, 1, 2):
        left, points2, deviations = aqorb.refinePoints(image1, points1.reshape(shape), image2,
                                                       (points1 + [SHIFT + 1, -.7]).reshape(shape).tolist())
        assert len(left) > 200 and (np.diff(left) > 0).all() and len(deviations) == len(left)
        assert np.median(np.abs(points2 - points1[left] - [SHIFT, 0]).max(1)) < .05
    assert len(aqorb.refinePoints(image1, points1, image2, points1, minCorrelation=-1)[0]) == len(points1)
    assert [len(each) for each in aqorb.refinePoints(None, np.zeros((0, 2)), None, np.zeros((0, 2)))] == [0, 0, 0]


@pytest.mark.parametrize('message, changes', [
    ('points1 must be numbers of shape', {'points1': np.zeros((3, 3))}),
    ('points2 must be numbers of shape', {'points2': np.zeros(2)}),
    ('points2 must be as many as points1, 3, got 4', {'points2': np.zeros((4, 2))}),
    ('size must be finite and > 0, got 0', {'size': 0}), ('size must', {'size': np.nan}),
    ('minCorrelation must', {'minCorrelation': 2}), ('image1 must have pixels', {'image1': None})])
def test_bad_points(pair, message, changes):
    given = {'image1': pair[0], 'image2': pair[2], 'points1': np.zeros((3, 2)), 'points2': np.zeros((3, 2))}
    with pytest.raises(aqorb.error, match=message):
        aqorb.refinePoints(**{**given, **changes})


def test_no_matches(pair):
    image1, keypoints1, image2, keypoints2, pairs = pair
    for found in (aqorb.refineMatchArrays(None, keypoints1, None, keypoints2, pairs[:0]),
                  aqorb.growMatchArrays(None, keypoints1, None, keypoints2, pairs[:0]),
                  aqorb.growMatches(image1, (), image2, (), ())[2:5],
                  aqorb.refineMatches(image1, (), image2, (), ())):
        assert len(found[0]) == 0 and found[1].shape == found[2].shape == (0, 2) and found[2].dtype == np.float32


@pytest.mark.parametrize('error, message, changes', [
    (TypeError, 'image1 must be a numpy array', {'image1': 'x'}),
    (aqorb.error, 'image2 must be uint8', {'image2': np.zeros((40, 40))}),
    (aqorb.error, 'image2 must have pixels', {'image2': None}),
    (TypeError, 'keypoints1 must be', {'keypoints1': 5}),
    (TypeError, r'keypoints2\[0\] must be a cv2.KeyPoint', {'keypoints2': [5]}),
    (TypeError, 'pairs must be an array of integers', {'pairs': 5}),
    (aqorb.error, 'pairs must be an array of integers', {'pairs': np.zeros((3, 2))}),
    (aqorb.error, 'pairs must be an array of integers', {'pairs': np.zeros((2, 3), int)}),
    (aqorb.error, r'pairs\[1\] must be indices', {'pairs': np.array([[0, 0], [0, 2 ** 40]])}),
    (aqorb.error, r'pairs\[0\] must be indices', {'pairs': np.array([[-1, 0]])}),
    (TypeError, 'matches must be a sequence of cv2.DMatch, got 5', {'matches': 5}),
    (TypeError, r'matches\[1\] must be a cv2.DMatch, got None', {'matches': [cv.DMatch(0, 0, 1), None]}),
    (aqorb.error, r'matches\[0\] must', {'matches': [cv.DMatch(0, 9999, 1)]}),
    (aqorb.error, 'minCorrelation must', {'minCorrelation': 2}), (TypeError, 'scaleFactor: ', {'scaleFactor': 'x'}),
    (aqorb.error, 'scaleFactor must', {'scaleFactor': np.nan})])
def test_bad_arguments(pair, error, message, changes):
    given = dict(zip(('image1', 'keypoints1', 'image2', 'keypoints2', 'pairs'), pair))
    if 'matches' in changes:
        del given['pairs']
    functions = (aqorb.refineMatches, aqorb.growMatches) if 'matches' in changes else (
        aqorb.refineMatchArrays, aqorb.growMatchArrays)
    for function in functions:
        with pytest.raises(error, match=message):
            function(**{**given, **changes})
