# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Relative poses of calibrated photographs and of a sequence: detected, refined and grown matches by each estimator."""

import os
import time
from typing import NamedTuple

import aqorb
import cv2
import numpy as np

import images
from methods import Method

SCENES = ['fountain-P11', 'entry-P10']
WIDTH = 1024  # of the photographs
GAPS = {'photographs': [1, 2, 3], 'sequence': [1, 2, 3, 5, 8]}  # between the two images of a pair
THRESHOLDS = [.18, .25, .5, 1]  # pixels; a row shows the one that is best for it
UNCERTAIN, FEWEST = .35, 40  # matches of larger deviations, in pixels, are left out, but for so many
POSELIB = {'min_iterations': 100, 'max_iterations': 5000}  # 1000 at least are four times slower, and no better
STAGES = ['as detected', 'refined', 'grown', 'grown, certain']


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


def read_scenes(folder):
    """The images of Strecha's scenes, reduced to the same width, and their pairs."""
    pictures, pairs = [], []
    for scene in SCENES:
        path, poses, offset = os.path.join(folder, scene), [], len(pictures)
        for name in sorted(os.listdir(os.path.join(path, 'gt_dense_cameras'))):
            image = images.read_image(os.path.join(path, 'images', name.split('.')[0]))
            with open(os.path.join(path, 'gt_dense_cameras', name), encoding='utf-8') as file:
                numbers = np.array(file.read().split(), float)
            reduced, matrix = images.scaled(image, WIDTH / image.shape[1])
            pictures.append(reduced)
            camera = matrix @ numbers[:9].reshape(3, 3)
            poses.append(np.vstack([np.column_stack([numbers[12:21].reshape(3, 3), numbers[21:24]]), [0, 0, 0, 1]]))
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


def points_of(row, n, pictures, pairs):
    """For each stage the points of each pair."""
    method, stages = Method(row.detector), {stage: [] for stage in STAGES}
    features = [method.compute(picture, n) for picture in pictures]
    for pair in pairs:
        a, b = features[pair.first], features[pair.second]
        matches = mutual(a, b, method.norm, row.ratio)
        both = pictures[pair.first], a.keypoints, pictures[pair.second], b.keypoints
        indices = np.array([(match.queryIdx, match.trainIdx) for match in matches], int).reshape(-1, 2)
        stages['as detected'].append((a.keypoints['pt'][indices[:, 0]], b.keypoints['pt'][indices[:, 1]]))
        stages['refined'].append(aqorb.refineMatchArrays(*both, indices, scaleFactor=row.scale)[1:])
        _, *points, deviations = aqorb.growMatchArrays(*both, indices, scaleFactor=row.scale)
        stages['grown'].append(points)
        stages['grown, certain'].append(certain(*points, deviations))
    return stages


def by_opencv(estimator):
    def estimate(first, second, camera, threshold):
        essential, inliers = cv2.findEssentialMat(first, second, camera, estimator, .9999, threshold)
        if essential is None or essential.shape != (3, 3):
            return None
        return cv2.recoverPose(essential, first, second, camera, mask=inliers)[1:3]
    return estimate


def by_poselib(first, second, camera, threshold):
    import poselib  # only this command needs it
    model = {'model': 'PINHOLE', 'width': WIDTH, 'height': WIDTH,
             'params': [camera[0, 0], camera[1, 1], camera[0, 2], camera[1, 2]]}
    pose, _ = poselib.estimate_relative_pose(first, second, model, model, {'max_epipolar_error': threshold, **POSELIB},
                                             {'loss_type': 'CAUCHY', 'loss_scale': threshold / 2})
    return pose.R, pose.t.reshape(3, 1)


ESTIMATORS = {name: by_opencv(getattr(cv2, name)) for name in
              ['RANSAC', 'USAC_DEFAULT', 'USAC_PARALLEL', 'USAC_ACCURATE', 'USAC_PROSAC', 'USAC_MAGSAC']}
ESTIMATORS['PoseLib'] = by_poselib
BEST = 'USAC_MAGSAC' if cv2.__version__.startswith('4.6.') else 'USAC_ACCURATE'  # by the second table


def area(errors, limit):
    return np.mean([max(0, 1 - error / limit) for error in errors])


def best_area(errors, limits):
    """The areas under the curve at limits for the threshold that is best at the last of them, and that threshold."""
    threshold = max(errors, key=lambda each: area(errors[each], limits[-1]))
    return ['{:.3f}'.format(area(errors[threshold], limit)) for limit in limits] + ['{:g}'.format(threshold)]


def angle(cosine):
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def measured(estimator, points, pairs):
    """By threshold, the larger error of the rotation and of the direction in degrees for each pair; and the median
    processor time of an estimate in milliseconds."""
    errors, times = {}, []
    for threshold in THRESHOLDS:
        cv2.setRNGSeed(1)
        errors[threshold] = []
        for (first, second), pair in zip(points, pairs):
            start = time.process_time()
            pose = ESTIMATORS[estimator](first, second, pair.camera, threshold) if len(first) >= 5 else None
            times.append(1000 * (time.process_time() - start))
            if pose is None:
                errors[threshold].append(180)
                continue
            rotation, direction = pair.motion[:3, :3], pair.motion[:3, 3]
            errors[threshold].append(max(angle((np.trace(pose[0].T @ rotation) - 1) / 2),
                                         angle(pose[1][:, 0] @ direction / np.linalg.norm(direction))))
    return errors, np.median(times)


def rows_of(row, stages, pairs):
    for stage, points in stages.items():
        cells = ['{}, {}'.format(row.title, stage), '{:.0f}'.format(np.mean([len(first) for first, _ in points]))]
        for estimator in (BEST, 'PoseLib'):
            cells += best_area(measured(estimator, points, pairs)[0], (1, 5))
        yield cells


def estimator_rows(points, pairs):
    for estimator in ESTIMATORS:
        errors, milliseconds = measured(estimator, points, pairs)
        areas = [' / '.join(best_area({threshold: each}, (1, 5))[:2]) for threshold, each in errors.items()]
        yield [estimator] + areas + ['{:.1f}'.format(milliseconds)]


def tables(options):
    """(title, head, rows) of each table."""
    head = ['', 'matches']
    for estimator in (BEST, 'PoseLib'):
        head += [estimator + ', AUC at 1 degree', 'at 5 degrees', 'threshold, px']
    for read, folder in ((read_scenes, options.scenes), (read_sequence, options.sequence)):
        pictures, pairs = read(folder) if folder else ([], [])
        for n in options.n if folder else []:
            title = '{} pairs of {}, n = {}'.format(len(pairs), os.path.basename(folder), n)
            stages = {row: points_of(row, n, pictures, pairs) for row in ROWS}
            yield title, head, (cells for row in ROWS for cells in rows_of(row, stages[row], pairs))
            yield ('{}, aqorb, grown, certain: AUC at 1 / 5 degrees'.format(title),
                   ['estimator'] + ['{:g} px'.format(threshold) for threshold in THRESHOLDS] + ['ms'],
                   estimator_rows(stages[ROWS[-1]]['grown, certain'], pairs))
