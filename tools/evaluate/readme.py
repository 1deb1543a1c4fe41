# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""README's table: cv::ORB as people use it, cv::ORB at its best with this module's functions, and aqorb."""

import aqorb
import cv2
import numpy as np

import images
import measures
import poses

N, OBJECT_N = 1000, 500
TIMED = slice(0, None, 3)  # of the pairs
USUAL_THRESHOLD = 1  # pixels, with cv2.RANSAC
THRESHOLD = poses.RECIPE
HEAD = ['', 'cv::ORB as people use it', 'cv::ORB at its best', 'aqorb']
SETTINGS = [(edge, fast) for edge in (31, 16) for fast in (20, 5)]  # of cv::ORB; the best for each row counts


def orb(n, edge=31, fast=20):
    return cv2.ORB_create(n, edgeThreshold=edge, fastThreshold=fast)


def features(detector, picture):
    if hasattr(detector, 'detectAndComputeArrays'):
        return measures.Features(*detector.detectAndComputeArrays(picture))
    keypoints, descriptors = detector.detectAndCompute(picture, None)
    return measures.Features(aqorb.keypointsToArray(keypoints), descriptors)


def usual_points(first, second):
    """What a program with cv2 alone does: detect, match with a cross check, copy the positions."""
    detector = orb(N)
    (a, da), (b, db) = (detector.detectAndCompute(picture, None) for picture in (first, second))
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, True).match(da, db)
    return (np.float32([a[match.queryIdx].pt for match in matches]),
            np.float32([b[match.trainIdx].pt for match in matches]))


def grown_points(detector, first, second):
    """The recipe of the tutorial on matching."""
    a, b = (features(detector, picture) for picture in (first, second))
    pairs, _ = aqorb.matchArrays(a.descriptors, b.descriptors, crossCheck=True)
    return poses.certain(*aqorb.growMatchArrays(first, a.keypoints, second, b.keypoints, pairs)[1:])


def within_a_degree(points_of, estimator, pictures, pairs):
    """By threshold, the share of the pairs whose pose is right to one degree."""
    points = [points_of(pictures[pair.first], pictures[pair.second]) for pair in pairs]
    return {threshold: np.mean(np.array(errors) < 1)
            for threshold, errors in poses.measured(estimator, points, pairs)[0].items()}


def rows(options):
    cv2.setNumThreads(1)
    aqorb.setNumThreads(1)
    pictures, pairs = poses.read_scenes(options.scenes)
    usual, ours = orb(N), aqorb.AdaptiveQuadtreeORB_create(N)

    def percent(share):
        return '{:.0f} %'.format(100 * share)
    shares = [within_a_degree(lambda *pair: grown_points(orb(N, *settings), *pair), poses.BEST, pictures, pairs)
              for settings in SETTINGS]
    best = max(range(len(SETTINGS)), key=lambda i: max(shares[i].values()))
    best_orb, best_threshold = orb(N, *SETTINGS[best]), max(shares[best], key=shares[best].get)
    yield ['camera poses within 1 degree, of {} pairs'.format(len(pairs)),
           percent(within_a_degree(usual_points, 'RANSAC', pictures, pairs)[USUAL_THRESHOLD]),
           percent(shares[best][best_threshold]),
           percent(within_a_degree(lambda *pair: grown_points(ours, *pair), poses.BEST, pictures, pairs)[THRESHOLD])]

    def pose(points_of, estimator, threshold):
        return lambda first, second, camera: poses.ESTIMATORS[estimator](*points_of(first, second), camera, threshold)
    yield ['two images to their pose, times as fast'] + measures.times_as_fast(
        pose(usual_points, 'RANSAC', USUAL_THRESHOLD),
        [pose(lambda *pair: grown_points(best_orb, *pair), poses.BEST, best_threshold),
         pose(lambda *pair: grown_points(ours, *pair), poses.BEST, THRESHOLD)],
        [(pictures[pair.first], pictures[pair.second], pair.camera) for pair in pairs[TIMED]])
    yield ['one image, times as fast'] + measures.times_as_fast(
        *[lambda picture: usual.detectAndCompute(picture, None),
          [lambda picture, each=each: each.detectAndCompute(picture, None) for each in (best_orb, ours)]],
        [(picture,) for picture in pictures])

    def covered(detector):
        return np.mean([measures.occupancy(features(detector, picture), picture) for picture in pictures])
    yield ['cells of a 16 x 12 grid with a keypoint', percent(covered(usual)),
           percent(max(covered(orb(N, *settings)) for settings in SETTINGS)), percent(covered(ours))]

    box, scene = (images.read_image('{}/{}'.format(options.object, name)) for name in ('box', 'box_in_scene'))

    def on_object(detector):
        return measures.inliers_on_object(features(detector, box), features(detector, scene),
                                          cv2.NORM_HAMMING)['distinct']
    found = [on_object(orb(OBJECT_N)), max(on_object(orb(OBJECT_N, *settings)) for settings in SETTINGS),
             on_object(aqorb.AdaptiveQuadtreeORB_create(OBJECT_N))]
    yield ['distinct matches on a small object, {} features'.format(OBJECT_N)] + [str(number) for number in found]
