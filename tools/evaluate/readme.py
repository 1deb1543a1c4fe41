# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""README's table: cv::ORB as people use it, cv::ORB at its best with and without this module, SIFT, and aqorb."""

from typing import NamedTuple

import aqorb
import cv2
import numpy as np

import measures
import poses

THRESHOLDS = .18, .25, .5, 1  # pixels
SOME = slice(0, None, 3)  # of the pairs: those that are timed, and those that choose settings
CANDIDATES = 5000  # of cv::ORB, from which SSC or cells select
HEAD = ['', 'cv::ORB as people use it', 'cv::ORB at its best, cv2 alone', 'cv::ORB at its best with this module',
        'SIFT', 'aqorb']


class Side(NamedTuple):
    """A detector, and how its features become a pose. threshold is None for the best one."""
    detector: str
    n: int = 1000
    edge: int = 31  # of cv::ORB
    fast: int = 20
    selection: str = 'strongest'
    ratio: float = 0  # 0: mutual nearest neighbours
    grows: bool = False
    estimator: str = poses.BEST
    threshold: float = None  # pixels

    def settings(self):
        kept = {name: value for name, value in self._asdict().items()
                if name in ('n', 'estimator', 'threshold') or value != self._field_defaults.get(name)}
        return ', '.join('{} {}'.format(*item) for item in kept.items())


PEOPLE = Side('orb', estimator='RANSAC', threshold=1)
SIFT = Side('sift', ratio=.8)
# The recipe of the tutorial on matching.
AQORB = Side('aqorb', grows=True, estimator=poses.ESTIMATOR, threshold=poses.RECIPE)
CHOICES = {'n': (1000, 2000, 3000), 'edge': (31, 16), 'fast': (20, 5), 'selection': ('strongest', 'ssc', 'cells'),
           'ratio': (0, .8), 'estimator': ('RANSAC', 'USAC_MAGSAC', 'USAC_ACCURATE', 'USAC_PROSAC')}
SELECTED = {}  # the indices of selected candidates, so that no time counts a selection in Python
FEATURES = {}


def ssc(keypoints, n, shape):
    """Suppression via square covering (Bailo et al. 2018): the strongest keypoints whose squares do not overlap, with
    the largest square that leaves n."""
    order = np.argsort([-point.response for point in keypoints], kind='stable')
    points = np.array([keypoints[i].pt for i in order])
    low, high, best = 1, max(shape), order
    while low <= high:
        width = (low + high) // 2
        cells, kept = (points / (width / 2)).astype(int) + 2, []
        covered = np.zeros(cells.max(0) + 3, bool)
        for i, (x, y) in enumerate(cells):
            if not covered[x, y]:
                kept.append(order[i])
                covered[x - 2:x + 3, y - 2:y + 3] = True
        if len(kept) >= n:
            low, best = width + 1, kept[:n]
        else:
            high = width - 1
    return best


def strongest_in_cells(keypoints, n, shape):
    """The strongest keypoints in each of 8 x 6 cells."""
    cells = {}
    for i in np.argsort([-point.response for point in keypoints], kind='stable'):
        x, y = keypoints[i].pt
        cells.setdefault((int(8 * x / shape[1]), int(6 * y / shape[0])), []).append(i)
    return [i for cell in cells.values() for i in cell[:n // 48]]


def detected(side, picture):
    """The keypoints and descriptors of cv2, or arrays of aqorb."""
    if side.detector == 'aqorb':
        return aqorb.AdaptiveQuadtreeORB_create(side.n).detectAndComputeArrays(picture)
    if side.detector == 'sift':
        return cv2.SIFT_create(side.n).detectAndCompute(picture, None)
    if side.selection == 'strongest':
        return cv2.ORB_create(side.n, edgeThreshold=side.edge, fastThreshold=side.fast).detectAndCompute(picture, None)
    detector = cv2.ORB_create(CANDIDATES, edgeThreshold=side.edge, fastThreshold=side.fast)
    keypoints, key = detector.detect(picture), (id(picture),) + side[:5]
    if key not in SELECTED:
        select = ssc if side.selection == 'ssc' else strongest_in_cells
        SELECTED[key] = sorted(select(keypoints, side.n, picture.shape))
    return detector.compute(picture, [keypoints[i] for i in SELECTED[key]])


def remembered(side, picture):
    key = (id(picture),) + side[:5]
    if key not in FEATURES:
        FEATURES[key] = detected(side, picture)
    return FEATURES[key]


def arrays_of(keypoints):
    return keypoints if isinstance(keypoints, np.ndarray) else aqorb.keypointsToArray(keypoints)


def matched_by_cv2(a, b, side):
    norm = cv2.NORM_L2 if side.detector == 'sift' else cv2.NORM_HAMMING
    if not side.ratio:
        return cv2.BFMatcher(norm, True).match(a, b)
    return [match[0] for match in cv2.BFMatcher(norm).knnMatch(a, b, 2)
            if len(match) == 2 and match[0].distance < side.ratio * match[1].distance]


def points_of(side, first, second, detected_by=detected):
    (a, of_a), (b, of_b) = detected_by(side, first), detected_by(side, second)
    if side.grows:
        pairs, _ = aqorb.matchArrays(of_a, of_b, side.ratio, not side.ratio)
        return poses.certain(*aqorb.growMatchArrays(first, arrays_of(a), second, arrays_of(b), pairs)[1:])
    matches = sorted(matched_by_cv2(of_a, of_b, side), key=lambda match: match.distance)  # for PROSAC
    if side.detector == 'aqorb':
        return a['pt'][[match.queryIdx for match in matches]], b['pt'][[match.trainIdx for match in matches]]
    return (np.float32([a[match.queryIdx].pt for match in matches]),
            np.float32([b[match.trainIdx].pt for match in matches]))


def share_of(side, pictures, pairs, orders=1):
    """The share of the pairs whose pose is right to one degree, a mean over orders of the matches, on which OpenCV's
    estimators depend; and the threshold, the best one unless side has one."""
    points = [points_of(side, pictures[pair.first], pictures[pair.second], remembered) for pair in pairs]

    def share(threshold):
        estimate = poses.ESTIMATORS[side.estimator]
        return np.mean([len(each[0]) >= 5
                        and poses.pose_error(estimate(*each, pair.camera, threshold, turn), pair.motion) < 1
                        for each, pair in zip(points, pairs) for turn in range(orders)])
    return max((share(threshold), threshold) for threshold in ([side.threshold] if side.threshold else THRESHOLDS))


def best(side, choices, pictures, pairs):
    """Changes one choice after another while this helps on some pairs; the threshold is the best one for all."""
    shares, before = {}, None

    def share(each):
        if each not in shares:
            shares[each] = share_of(each, pictures, pairs[SOME], poses.SEEDS)[0]
        return shares[each]
    while side != before:
        before = side
        for name in choices:
            side = max([side] + [side._replace(**{name: value}) for value in CHOICES[name]], key=share)
    return side._replace(threshold=share_of(side, pictures, pairs, poses.ORDERS)[1])


def pose_of(side):
    return lambda first, second, camera: poses.ESTIMATORS[side.estimator](*points_of(side, first, second), camera,
                                                                          side.threshold)


def tables(options):
    yield 'Measured on one thread', HEAD, rows(options)


def rows(options):
    cv2.setNumThreads(1)
    aqorb.setNumThreads(1)
    pictures, pairs = poses.read_scenes(options.scenes)

    def percent(share):
        return '{:.0f} %'.format(100 * share)
    alone = best(Side('orb', ratio=.8), [name for name in CHOICES if name != 'selection'], pictures, pairs)
    helped = best(Side('orb', grows=True), list(CHOICES), pictures, pairs)
    sides = [PEOPLE, alone, helped, SIFT._replace(threshold=share_of(SIFT, pictures, pairs, poses.ORDERS)[1]), AQORB]
    yield ['camera poses within 1 degree, of {} pairs'.format(len(pairs))] + [
        percent(share_of(side, pictures, pairs, poses.ORDERS)[0]) for side in sides]
    yield ['only the detector differs: mutual matches, RANSAC at 1 px'] + [
        percent(share_of(PEOPLE._replace(detector=name), pictures, pairs, poses.ORDERS)[0]) if name else ''
        for name in ('orb', '', '', 'sift', 'aqorb')]
    yield ['two images to their pose, times as fast'] + measures.times_as_fast(
        pose_of(sides[0]), [pose_of(side) for side in sides[1:]],
        [(pictures[pair.first], pictures[pair.second], pair.camera) for pair in pairs[SOME]])
    yield ['one image, times as fast'] + measures.times_as_fast(
        lambda picture: detected(sides[0], picture),
        [lambda picture, side=side: detected(side, picture) for side in sides[1:]],
        [(picture,) for picture in pictures])
    yield ['cells of a 16 x 12 grid with a keypoint'] + [
        percent(np.mean([aqorb.distributionOccupancy(arrays_of(remembered(side, picture)[0]), picture.shape[::-1],
                                                     measures.GRID) for picture in pictures])) for side in sides]
    yield ['settings'] + [side.settings() for side in sides]
