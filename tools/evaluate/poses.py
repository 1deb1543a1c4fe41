# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Relative poses of calibrated photographs and of a sequence: detected, refined and grown matches by each estimator."""

import os
import tempfile
import time
from typing import NamedTuple

import aqorb
import cv2
import numpy as np

import images
import measures
from methods import Method, is_available

SCENES = ['fountain-P11', 'entry-P10']
WIDTH = 1024  # of the photographs
GAPS = {'photographs': [1, 2, 3], 'sequence': [1, 2, 3, 5, 8]}  # between the two images of a pair
THRESHOLDS, COARSE = [.18, .35], [.18, .5, 1]  # pixels; a row of the first table shows the best of COARSE
ESTIMATOR, RECIPE = 'USAC_PROSAC', .18  # and pixels, by the tutorial on matching
UNCERTAIN, FEWEST = .35, 40  # matches of larger deviations, in pixels, are left out, but for so many
REACH, AGREES = 3, 1.5  # pixels, of the second pass
POSELIB = {'min_iterations': 100, 'max_iterations': 5000}  # 1000 at least are four times slower, and no better
ORDERS, SEEDS = 10, 3  # OpenCV's estimators have no seed, but depend on the order of the matches
STAGES = ['as detected', 'refined', 'one way', 'both ways']
STRANGERS = 2000  # pairs of different places
INLIERS = [10, 14, 17, 20, 25, 30, 40]


class Row(NamedTuple):
    """A detector, the ratio of the two nearest distances or None, and refineMatches' scaleFactor."""
    title: str
    detector: str
    ratio: float
    scale: float


ROWS = [Row('cv::ORB', 'orb', None, 1), Row('SIFT, ratio .9', 'sift', .9, 6.75), Row('AKAZE', 'akaze', None, 5),
        Row('aqorb', 'aqorb', None, 1)]


class Pair(NamedTuple):
    """Two images, their cameras' matrix, and the motion from coordinates of the first camera to the second."""
    first: int
    second: int
    camera: np.ndarray
    motion: np.ndarray


def pairs_of(offset, camera, poses, gaps):
    """Pairs of images that follow each other, by their poses (camera to world)."""
    return [Pair(offset + i, offset + i + gap, camera, np.linalg.inv(poses[i + gap]) @ poses[i])
            for gap in gaps for i in range(len(poses) - gap)]


def read_scenes(folder, scenes=SCENES):
    """The images of Strecha's scenes, reduced to the same width, and their pairs."""
    pictures, pairs = [], []
    for scene in scenes:
        poses, offset = [], len(pictures)
        for _, picture, camera, rotation, centre in images.read_scene(os.path.join(folder, scene), WIDTH):
            pictures.append(picture)
            poses.append(np.vstack([np.column_stack([rotation, centre]), [0, 0, 0, 1]]))
        pairs += pairs_of(offset, camera, poses, GAPS['photographs'])
    return pictures, pairs


def read_sequence(folder):
    pictures, camera, poses = images.read_sequence(folder)
    return pictures, pairs_of(0, camera, poses, GAPS['sequence'])


def mutual(a, b, norm, ratio):
    """Mutual nearest neighbours; with a ratio those that are clearly nearer than the second nearest."""
    matcher = cv2.BFMatcher(norm)
    back = {match.queryIdx: match.trainIdx for match in matcher.match(b.descriptors, a.descriptors)}
    return [first for first, second in matcher.knnMatch(a.descriptors, b.descriptors, 2)
            if back[first.trainIdx] == first.queryIdx and (not ratio or first.distance < ratio * second.distance)]


def certain(first, second, deviations):
    """The matches without those of large deviations, the most certain one first."""
    kept = np.argsort(deviations, kind='stable')[:max(FEWEST, (deviations <= UNCERTAIN).sum())]
    return first[kept], second[kept]


class Matched(NamedTuple):
    """Two images with their keypoints and descriptors, and the pairs of mutual nearest neighbours."""
    row: Row
    views: tuple  # what aqorb's functions take
    descriptors: tuple
    pairs: np.ndarray

    def refine(self, pairs):
        return aqorb.refineMatchArraysWithDeviations(*self.views, pairs, .8, self.row.scale)

    def grow(self, pairs, both_ways=True):
        return aqorb.growMatchArrays(*self.views, pairs, scaleFactor=self.row.scale, bothWays=both_ways)[1:]


def matched(row, n, pictures, pairs):
    method = Method(row.detector)
    features = [method.compute(picture, n) for picture in pictures]
    for pair in pairs:
        a, b = features[pair.first], features[pair.second]
        if method.norm == cv2.NORM_HAMMING and not row.ratio:
            indices = aqorb.matchArrays(a.descriptors, b.descriptors)[0]
        else:
            indices = measures.indices(mutual(a, b, method.norm, row.ratio))
        yield Matched(row, (pictures[pair.first], a.keypoints, pictures[pair.second], b.keypoints),
                      (a.descriptors, b.descriptors), indices)


def points_of(row, n, pictures, pairs):
    """For each stage the points of each pair, and their deviations."""
    stages = {stage: [] for stage in STAGES}
    for each in matched(row, n, pictures, pairs):
        found = [*(each.views[2 * i + 1]['pt'][each.pairs[:, i]] for i in range(2)), np.zeros(len(each.pairs))]
        for stage, points in zip(STAGES, (found, each.refine(each.pairs)[1:], each.grow(each.pairs, False),
                                          each.grow(each.pairs))):
            stages[stage].append(points)
    return stages


def second_pass(each, pose, camera):
    """The points that grow from the matches along epipolar lines, as in the tutorial on matching."""
    fundamental = measures.fundamental_of(camera, *pose[:2])

    def agreeing(pairs):
        pairs, first, second, _ = each.refine(pairs)
        return pairs[measures.off_lines(first, second, fundamental) <= AGREES]
    seeds = agreeing(each.pairs)
    guided, _ = aqorb.matchGuided(each.descriptors[0], each.views[1], each.descriptors[1], each.views[3], fundamental,
                                  REACH)
    return each.grow(np.vstack([seeds, agreeing(guided[~np.isin(guided[:, 0], seeds[:, 0])])]))


def by_opencv(estimator):
    def estimate(first, second, camera, threshold, turn=0):
        order = np.arange(len(first))
        order = np.argsort(order + (turn > 0) * np.random.RandomState(turn).normal(0, 1 + len(first) / 20, len(first)))
        first, second = first[order], second[order]
        essential, inliers = cv2.findEssentialMat(first, second, camera, estimator, .9999, threshold)
        if essential is None or essential.shape != (3, 3):
            return None
        count = int(inliers.sum())
        return (*cv2.recoverPose(essential, first, second, camera, mask=inliers)[1:3], count)
    return estimate


def by_poselib(progressive):
    def estimate(first, second, camera, threshold, turn=0):
        import poselib  # only this command needs it
        model = {'model': 'PINHOLE', 'width': WIDTH, 'height': WIDTH,
                 'params': [camera[0, 0], camera[1, 1], camera[0, 2], camera[1, 2]]}
        pose, info = poselib.estimate_relative_pose(
            first, second, model, model,
            {'max_epipolar_error': threshold, 'progressive_sampling': progressive, 'seed': turn, **POSELIB},
            {'loss_type': 'CAUCHY', 'loss_scale': threshold / 2})
        return pose.R, pose.t.reshape(3, 1), info['num_inliers']
    return estimate


ESTIMATORS = {name: by_opencv(getattr(cv2, name)) for name in
              ['RANSAC', 'USAC_PARALLEL', 'USAC_ACCURATE', 'USAC_PROSAC', 'USAC_MAGSAC']}
ESTIMATORS['PoseLib'] = by_poselib(True)
# The best of those that do not depend on the order of the matches, which detected ones have not.
BEST = 'USAC_MAGSAC' if cv2.__version__.startswith('4.6.') else 'USAC_ACCURATE'


def areas(errors, limits=(1, 5)):
    return ['{:.3f}'.format(measures.area(errors, limit)) for limit in limits]


def best_area(errors, limits):
    """The areas under the curve at limits for the threshold that is best at the last of them, and that threshold."""
    threshold = max(errors, key=lambda each: measures.area(errors[each], limits[-1]))
    return areas(errors[threshold], limits) + ['{:g}'.format(threshold)]


def angle(cosine):
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def pose_error(pose, motion):
    """The larger error of the rotation and of the direction in degrees."""
    if pose is None:
        return 180
    rotation, direction = motion[:3, :3], motion[:3, 3]
    return max(angle((np.trace(pose[0].T @ rotation) - 1) / 2),
               angle(pose[1][:, 0] @ direction / np.linalg.norm(direction)))


def estimated(estimator, points, camera, threshold, turn=0):
    return ESTIMATORS[estimator](*points, camera, threshold, turn) if len(points[0]) >= 5 else None


def measured(estimator, points, pairs, thresholds=THRESHOLDS):
    """By threshold, the errors of all pairs, each with several orders or seeds; and the median processor time of an
    estimate in milliseconds."""
    errors, times = {threshold: [] for threshold in thresholds}, []
    for threshold in thresholds:
        for each, pair in zip(points, pairs):
            for turn in range(SEEDS if 'PoseLib' in estimator else ORDERS):
                start = time.process_time()
                pose = estimated(estimator, each, pair.camera, threshold, turn)
                times.append(1000 * (time.process_time() - start))
                errors[threshold].append(pose_error(pose, pair.motion))
    return errors, np.median(times)


def stage_rows(row, stages, pairs):
    for stage, points in stages.items():
        points = [certain(*each) for each in points]
        cells = ['{}, {}'.format(row.title, stage), '{:.0f}'.format(np.mean([len(first) for first, _ in points]))]
        for estimator in (BEST, 'PoseLib'):
            cells += best_area(measured(estimator, points, pairs, COARSE)[0], (1, 5))
        yield cells


def guided_points(estimator, matches, points, pairs):
    for each, first, pair in zip(matches, points, pairs):
        pose = estimated(estimator, first, pair.camera, RECIPE)
        yield first if pose is None else certain(*second_pass(each, pose, pair.camera))


def estimator_rows(matches, stages, pairs):
    gaps = np.array([pair.second - pair.first for pair in pairs])
    for estimator in ESTIMATORS:
        variants = {stage: [certain(*each) for each in stages[stage]] for stage in STAGES[2:]}
        variants['guided'] = list(guided_points(estimator, matches, variants['both ways'], pairs))
        for variant, points in variants.items():
            errors, milliseconds = measured(estimator, points, pairs)
            wide = np.reshape(errors[RECIPE], (len(pairs), -1))[gaps == gaps.max()].ravel()
            yield [estimator, variant] + [' / '.join(areas(each)) for each in (*errors.values(), wide)] + [
                '{:.1f}'.format(milliseconds)]


def coverage_rows(stages, pairs):
    """How many epipolar distances of right matches are below the deviations."""
    grown = stages['one way']
    truth = [measures.fundamental_of(pair.camera, pair.motion[:3, :3], pair.motion[:3, 3]) for pair in pairs]
    distances = [measures.off_lines(*points[:2], each) for points, each in zip(grown, truth)]
    yield measures.fifths('epipolar distances', np.hstack(distances), np.hstack([each[2] for each in grown]))


def strangers(groups):
    """Pairs of images of different places, with one assumed camera."""
    pictures = [(place, picture) for place, group in enumerate(groups) for picture in group]
    random, pairs = np.random.RandomState(1), []
    camera = np.array([[WIDTH, 0, WIDTH / 2], [0, WIDTH, WIDTH / 3], [0, 0, 1]])
    while len(pairs) < STRANGERS:
        first, second = random.randint(len(pictures), size=2)
        if pictures[first][0] != pictures[second][0]:
            pairs.append(Pair(first, second, camera, None))
    return [picture for _, picture in pictures], pairs


def belief_rows(estimator, n, known, foreign):
    """How many poses have at least so many inliers: of pairs of different places, wrong ones, and right ones."""
    counts = {'foreign': [], 'wrong': [], 'right': []}
    for pictures, pairs in (known, foreign):
        for each, pair in zip(matched(ROWS[-1], n, pictures, pairs), pairs):
            pose = estimated(estimator, certain(*each.grow(each.pairs)), pair.camera, RECIPE)
            kind = 'foreign' if pair.motion is None else 'right' if pose_error(pose, pair.motion) < 5 else 'wrong'
            counts[kind].append(pose[2] if pose else 0)
    for least in INLIERS:
        yield [str(least)] + ['{} of {}'.format(sum(count >= least for count in each), len(each))
                              for each in counts.values()]


def speed_rows(pictures, pairs):
    """Two files to a pose on one thread, with cv2 alone, with matchImages, and guided by a first pose."""
    camera = pairs[0].camera

    def read(*files):
        return [cv2.imread(file, cv2.IMREAD_GRAYSCALE) for file in files]

    def usual(first, second):
        orb = cv2.ORB_create(1000)
        (a, da), (b, db) = (orb.detectAndCompute(picture, None) for picture in read(first, second))
        matches = cv2.BFMatcher(cv2.NORM_HAMMING, True).match(da, db)
        return by_poselib(False)(np.float32([a[match.queryIdx].pt for match in matches]),
                                 np.float32([b[match.trainIdx].pt for match in matches]), camera, 1)

    def pose_of(matches):
        return by_poselib(True)(*certain(*matches), camera, RECIPE)

    def ours(first, second):
        return pose_of(aqorb.matchImages(*read(first, second)))

    def guided(first, second):
        each = next(matched(ROWS[-1], 1000, read(first, second), [Pair(0, 1, camera, None)]))
        return pose_of(second_pass(each, pose_of(each.grow(each.pairs)), camera))
    cv2.setNumThreads(1)
    aqorb.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        files = [os.path.join(folder, '{}.jpg'.format(i)) for i in range(len(pictures))]
        for file, picture in zip(files, pictures):
            cv2.imwrite(file, picture)
        yield measures.times_as_fast(usual, [ours, guided],
                                     [(files[pair.first], files[pair.second]) for pair in pairs[::3]])


def tables(options):
    """(title, head, rows) of each table."""
    head = ['', 'matches']
    for estimator in (BEST, 'PoseLib'):
        head += [estimator + ', AUC at 1 degree', 'at 5 degrees', 'threshold, px']
    data = [('the given scenes', *read_scenes(options.scenes))]
    if options.sequence:
        data.append((os.path.basename(options.sequence), *read_sequence(options.sequence)))
    for name, pictures, pairs in data:
        for n in options.n:
            title = '{} pairs of {}, n = {}'.format(len(pairs), name, n)
            stages = {row: points_of(row, n, pictures, pairs) for row in ROWS if is_available(row.detector)}
            yield title, head, (cells for row in stages for cells in stage_rows(row, stages[row], pairs))
            matches, ours = list(matched(ROWS[-1], n, pictures, pairs)), stages[ROWS[-1]]
            yield ('{}, aqorb, certain matches: AUC at 1 / 5 degrees'.format(title),
                   ['estimator', ''] + ['{:g} px'.format(threshold) for threshold in THRESHOLDS] +
                   ['widest pairs, {:g} px'.format(RECIPE), 'ms'],
                   estimator_rows(matches, ours, pairs))
            yield 'Share of errors below the deviation, {}'.format(title), measures.FIFTHS, coverage_rows(ours, pairs)
    _, pictures, pairs = data[0]
    groups = [read_scenes(options.scenes, [scene])[0] for scene in SCENES] + [read for _, read, _ in data[1:]]
    groups += [images.read_folder(folder, WIDTH) for root in options.elsewhere for folder, _, _ in os.walk(root)]
    for estimator in (ESTIMATOR, 'PoseLib'):
        yield ('{} at {:g} px: poses by their inliers'.format(estimator, RECIPE),
               ['inliers at least', 'pairs of different places', 'wrong poses of the given scenes', 'right poses'],
               belief_rows(estimator, options.n[0], (pictures, pairs), strangers(groups)))
    yield ('Two JPEG files to their pose by PoseLib, times as fast',
           ['cv2.ORB and cv2.BFMatcher', 'matchImages', 'guided, both ways'],
           speed_rows(pictures, pairs))
