# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What is measured of the features of one image or two."""

import time
from typing import NamedTuple

import aqorb
import cv2
import numpy as np

GRID = 16, 12
CORRECT = 3  # pixels of the second image
DISTINCT = 4  # pixels
NO_HOMOGRAPHY = 1e6
RIGHT = 1.5  # pixels, of the errors that are compared with deviations
FIFTHS = [''] + ['{} fifth, px'.format(which) for which in ('first', 'second', 'third', 'fourth', 'last')] + ['all']
TURNS = 5


class Features(NamedTuple):
    keypoints: np.ndarray  # of aqorb.keypoint_dtype
    descriptors: np.ndarray


def size_of(image):
    return image.shape[1], image.shape[0]


def uniformity(features, image):
    return aqorb.distributionUniformity(features.keypoints, size_of(image))


def occupancy(features, image):
    return aqorb.distributionOccupancy(features.keypoints, size_of(image), GRID)


def transformed(points, homography):
    points = np.asarray(points, np.float64).reshape(-1, 1, 2)
    return cv2.perspectiveTransform(points, homography).reshape(-1, 2) if len(points) else points.reshape(-1, 2)


def indices(matches):
    """The numbers of both keypoints of cv2's matches."""
    return np.array([(match.queryIdx, match.trainIdx) for match in matches], np.int32).reshape(-1, 2)


def points(a, b, pairs):
    return a.keypoints['pt'][pairs[:, 0]], b.keypoints['pt'][pairs[:, 1]]


def matched(a, b, norm):
    """The points of mutual nearest neighbours in both images, the best match first."""
    if not len(a.keypoints) or not len(b.keypoints):
        return np.zeros((0, 2), np.float32), np.zeros((0, 2), np.float32)
    if norm == cv2.NORM_HAMMING:
        pairs, distances = aqorb.matchArrays(a.descriptors, b.descriptors, crossCheck=True)
    else:
        matches = cv2.BFMatcher(norm, True).match(a.descriptors, b.descriptors)
        pairs, distances = indices(matches), [match.distance for match in matches]
    return points(a, b, pairs[np.argsort(distances, kind='stable')])


def errors_of(first, second, homography):
    return np.linalg.norm(transformed(first, homography) - second, axis=1)


def agree_with_homography(first, second, homography):
    return errors_of(first, second, homography) <= CORRECT


def agree_with_fundamental(first, second, fundamental):
    """Each point is within 3 pixels of the epipolar line of the other."""
    return np.maximum(off_lines(first, second, fundamental), off_lines(second, first, fundamental.T)) <= CORRECT


def in_common_part(first, second, homography, image, other):
    """Which matches lie, by the known homography, where both images show the scene: not where a canvas was filled."""
    def inside(points, of):
        return ((points >= 0) & (points <= np.array(size_of(of)) - 1)).all(1)
    return (inside(transformed(first, homography), other)
            & inside(transformed(second, np.linalg.inv(homography)), image))


def distinct(first, second):
    """How many of the correct matches are at least 4 pixels away from every better one in both images."""
    kept = np.zeros((0, 4))
    for match in np.hstack([first, second]).astype(np.float64):
        apart = kept - match
        if (np.hypot(apart[:, 0], apart[:, 1]) >= DISTINCT).all() and \
                (np.hypot(apart[:, 2], apart[:, 3]) >= DISTINCT).all():
            kept = np.vstack([kept, match])
    return len(kept)


def counts(first, second, correct, image):
    """The measures of matches by name; places are cells of a 16x12 grid over the first image with a correct match."""
    found = np.zeros(correct.sum(), aqorb.keypoint_dtype)
    found['pt'] = first[correct]
    places = aqorb.distributionOccupancy(found, size_of(image), GRID) * GRID[0] * GRID[1]
    return {'distinct': distinct(first[correct], second[correct]), 'places': round(places),
            'precision': correct.mean() if len(correct) else 0}


def homography_error(first, second, homography, image, seed, threshold=3):
    """The mean distance of the first image's corners under the estimated homography from where they belong."""
    parameters = cv2.UsacParams()
    parameters.score = cv2.SCORE_METHOD_MAGSAC
    parameters.sampler = cv2.SAMPLING_UNIFORM
    parameters.loMethod = cv2.LOCAL_OPTIM_SIGMA
    parameters.loIterations, parameters.maxIterations = 10, 5000
    parameters.confidence, parameters.threshold = .9999, threshold
    parameters.randomGeneratorState = seed
    estimate = cv2.findHomography(first, second, parameters)[0] if len(first) >= 4 else None
    if estimate is None:
        return NO_HOMOGRAPHY
    right, bottom = size_of(image)[0] - 1, size_of(image)[1] - 1
    corners = [(0, 0), (right, 0), (right, bottom), (0, bottom)]
    error = errors_of(corners, transformed(corners, homography), estimate).mean()
    return NO_HOMOGRAPHY if np.isnan(error) else min(error, NO_HOMOGRAPHY)


def area(errors, limit):
    """The area under the curve of the share of errors below a limit; 1 is perfect."""
    return np.mean([max(0, 1 - error / limit) for error in errors])


def area_under_curve(first, second, homography, image, seeds):
    return area([homography_error(first, second, homography, image, 7919 * seed) for seed in range(1, seeds + 1)], 5)


def inliers_on_object(a, b, norm):
    """The inliers of OpenCV's sample find_obj.py with its brute-force matcher, and how many of them are distinct."""
    none = {'inliers': 0, 'distinct': 0}
    if not len(a.keypoints) or len(b.keypoints) < 2:
        return none
    two_best = cv2.BFMatcher(norm).knnMatch(a.descriptors, b.descriptors, 2)
    good = [best for best, second in two_best if best.distance < .75 * second.distance]
    if len(good) < 4:
        return none
    first, second = points(a, b, indices(good))
    mask = cv2.findHomography(first, second, cv2.RANSAC, 5)[1]
    if mask is None:
        return none
    inliers = sorted(np.flatnonzero(mask), key=lambda i: good[i].distance)
    return {'inliers': len(inliers), 'distinct': distinct(first[inliers], second[inliers])}


def start_matches(a, b):
    """Matches of the finest level of two frames, as a SLAM system with one camera makes them before it knows the scene.
    Written from the description in the paper of ORB-SLAM: the nearest descriptor within 100 pixels along x and y, if it
    is clearly nearer than the second, in one match only, and with a turn that many matches have."""
    finest = [each.keypoints['octave'] == 0 for each in (a, b)]
    da, db = a.descriptors[finest[0]], b.descriptors[finest[1]]
    a, b = a.keypoints[finest[0]], b.keypoints[finest[1]]
    if len(a) == 0 or len(b) == 0:
        return np.zeros((0, 2)), np.zeros((0, 2))
    bits = [2 * np.unpackbits(descriptors, axis=1).astype(np.float32) - 1 for descriptors in (da, db)]
    distance = (bits[0].shape[1] - bits[0] @ bits[1].T) / 2
    distance[(np.abs(a['pt'][:, None] - b['pt'][None]) > 100).any(2)] = np.inf
    nearest = distance.argmin(1)
    two = np.sort(np.column_stack([distance, np.full(len(a), np.inf)]), 1)[:, :2]
    chosen = {}
    for i in np.flatnonzero((two[:, 0] < .9 * two[:, 1]) & np.isfinite(two[:, 0])):
        j = nearest[i]
        if j not in chosen or two[i, 0] < two[chosen[j], 0]:
            chosen[j] = i
    to = np.array(sorted(chosen), int)
    of = np.array([chosen[j] for j in to], int)
    turn = ((a['angle'][of] - b['angle'][to]) % 360 * 30 // 360).astype(int) % 30
    best = np.argsort(-np.bincount(turn, minlength=30), kind='stable')[:3]
    kept = np.isin(turn, best)
    return a['pt'][of[kept]], b['pt'][to[kept]]


def fundamental_of(camera, rotation, translation):
    """The fundamental matrix of two images of one camera, from the motion from its first place to the second."""
    x, y, z = np.ravel(translation)
    inverse = np.linalg.inv(camera)
    return inverse.T @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation @ inverse


def off_lines(first, second, fundamental):
    """The distances of the second points from the epipolar lines of the first ones, in pixels."""
    first, second = (np.column_stack([each, np.ones(len(each))]) for each in (first, second))
    lines = first @ fundamental.T
    return np.abs((lines * second).sum(1)) / np.hypot(lines[:, 0], lines[:, 1])


def correct_starts(first, second, camera, motion):
    """How many matches lie within 2 pixels of the epipolar line of their first point.
    @param motion from coordinates of the first frame to those of the second"""
    return int((off_lines(first, second, fundamental_of(camera, motion[:3, :3], motion[:3, 3])) <= 2).sum())


def fifths(title, errors, deviations):
    """A row of the median deviation and the share of errors below the deviation, by fifths of the deviations."""
    right = errors <= RIGHT
    order = np.flatnonzero(right)[np.argsort(deviations[right])]
    return [title] + ['{:.3f}: {:.0f} %'.format(np.median(deviations[part]), 100 * (errors < deviations)[part].mean())
                      for part in np.array_split(order, 5) + [order]]


def times_as_fast(usual, others, inputs):
    """How many times as fast the other functions are: medians over the inputs, measured in turns on one thread."""
    ratios = []
    for each in inputs:
        seconds = [[] for _ in range(1 + len(others))]
        for _ in range(TURNS):
            for function, spent in zip([usual] + others, seconds):
                start = time.perf_counter()
                function(*each)
                spent.append(time.perf_counter() - start)
        ratios.append([np.median(seconds[0]) / np.median(spent) for spent in seconds[1:]])
    return ['1'] + ['{:.2g}'.format(ratio) for ratio in np.median(ratios, axis=0)]
