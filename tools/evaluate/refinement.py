# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What refineMatches gives to homographies of photographs, beside other matches."""

from typing import NamedTuple

import aqorb
import cv2
import numpy as np

import images
import measures
from methods import Method

THRESHOLDS = [.5, 1, 1.5]  # pixels; a row shows the one that is best for it


class Row(NamedTuple):
    """A way to match: a detector, the ratio of the two nearest distances, and refineMatches' scaleFactor, or None."""
    title: str
    detector: str
    ratio: float
    scale: float


ROWS = [Row('aqorb, cross check', 'aqorb', None, None), Row('aqorb, ratio .9', 'aqorb', .9, None),
        Row('aqorb, refined', 'aqorb', None, 1), Row('aqorb, ratio .9, refined', 'aqorb', .9, 1),
        Row('SIFT, ratio .9', 'sift', .9, None), Row('SIFT, refined', 'sift', None, 6.75),
        Row('cv::ORB, ratio .9', 'orb', .9, None), Row('cv::ORB, refined', 'orb', None, 1)]


def mutual(a, b, norm, ratio):
    """Mutual nearest neighbours; with a ratio those that are clearly nearer than the second nearest."""
    matcher = cv2.BFMatcher(norm)
    back = {match.queryIdx: match.trainIdx for match in matcher.match(b.descriptors, a.descriptors)}
    return [first for first, second in matcher.knnMatch(a.descriptors, b.descriptors, 2)
            if back[first.trainIdx] == first.queryIdx and (not ratio or first.distance < ratio * second.distance)]


def features_of(pictures, n):
    methods = [Method(name) for name in dict.fromkeys(row.detector for row in ROWS)]
    return {method.name: [method.compute(picture, n) for picture in pictures] for method in methods}


class Matched:
    """The matches of pairs of images by a row: before refinement, and the points of those that are left."""

    def __init__(self, row, pictures, features, pairs):
        self.before, self.points = [], []
        for i, j in pairs:
            a, b = (features[row.detector][which] for which in (i, j))
            matches = mutual(a, b, Method(row.detector).norm, row.ratio)
            first, second = (each.keypoints['pt'][np.array([getattr(match, index) for match in matches], int)]
                             for each, index in ((a, 'queryIdx'), (b, 'trainIdx')))
            self.before.append((first, second))
            if row.scale:
                _, first, second = aqorb.refineMatches(pictures[i], a.keypoints, pictures[j], b.keypoints, matches,
                                                       scaleFactor=row.scale)
            self.points.append([np.array(each, np.float32).reshape(-1, 2) for each in (first, second)])


def area(errors, limit):
    return np.mean([max(0, 1 - error / limit) for error in errors])


def best_area(errors, limits):
    """The areas under the curve at limits for the threshold that is best at the last of them, and that threshold."""
    threshold = max(errors, key=lambda each: area(errors[each], limits[-1]))
    return ['{:.3f}'.format(area(errors[threshold], limit)) for limit in limits] + ['{:g}'.format(threshold)]


def homography_rows(datasets, n):
    pictures, pairs, truth = [], [], []
    for name in images.SETS:
        found, homographies = images.read_set(datasets, name)
        pairs += [(len(pictures), len(pictures) + i) for i in range(1, 6)]
        truth += homographies[1:]
        pictures += found
    features = features_of(pictures, n)
    for row in ROWS:
        matched = Matched(row, pictures, features, pairs)
        near, matches, before_right, errors = [], 0, 0, {threshold: [] for threshold in THRESHOLDS}
        for (i, _), homography, before, points in zip(pairs, truth, matched.before, matched.points):
            off = np.linalg.norm(measures.transformed(points[0], homography) - points[1], axis=1)
            right = off <= measures.CORRECT
            near += list(off[right])
            matches += len(off)
            before_right += measures.agree_with_homography(*before, homography).sum()
            for threshold in THRESHOLDS:
                errors[threshold].append(measures.homography_error(*points, homography, pictures[i], 7919, threshold))
        values = np.median(near), len(near) / matches, len(near) / before_right
        yield [row.title] + ['{:.2f}'.format(value) for value in values] + best_area(errors, (3, 5))


def tables(options):
    """(title, head, rows) of each table."""
    for n in options.n:
        yield ('Homographies, n = {}'.format(n),
               ['', 'median error, px', 'right', 'right ones kept', 'AUC at 3 px', 'at 5 px', 'threshold, px'],
               homography_rows(options.datasets, n))
