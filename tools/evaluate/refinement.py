# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What refineMatches and growMatches give to homographies of photographs, beside the matches as detected."""

import cv2
import numpy as np

import images
import measures
import poses

THRESHOLDS = [.5, 1, 1.5]  # pixels; a row shows the one that is best for it
ROWS = [poses.Row('aqorb, cross check', 'aqorb', None, 1), poses.Row('aqorb, ratio .9', 'aqorb', .9, 1),
        poses.Row('SIFT, ratio .9', 'sift', .9, 6.75), poses.Row('cv::ORB, ratio .9', 'orb', .9, 1)]


def photographs(datasets):
    """The images of all sets, the pairs of the first image of a set and another one, and their homographies."""
    pictures, pairs, truth = [], [], []
    for name in images.SETS:
        found, homographies = images.read_set(datasets, name)
        pairs += [poses.Pair(len(pictures), len(pictures) + i, None, None) for i in range(1, 6)]
        truth += homographies[1:]
        pictures += found
    return pictures, pairs, truth


def drawn(pictures, pairs):
    """The same with the other images drawn from the first: turned and in perspective, with noise."""
    random, pictures, truth = np.random.RandomState(1), list(pictures), []
    for pair in pairs:
        image = pictures[pair.first]
        size = measures.size_of(image)
        corners = np.float32([(0, 0), (size[0], 0), size, (0, size[1])])
        moved = corners + random.uniform(-.12, .12, (4, 2)) * size
        truth.append(cv2.getPerspectiveTransform(corners, moved.astype(np.float32)))
        other = cv2.warpPerspective(image, truth[-1], size, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT_101)
        pictures[pair.second] = np.uint8(np.clip(np.round(other + random.normal(0, 2, other.shape)), 0, 255))
    return pictures, pairs, truth


def coverage_rows(datasets, n):
    """How many errors of right matches are below the deviations."""
    given = photographs(datasets)
    for title, (pictures, pairs, truth) in (('drawn warps', drawn(*given[:2])), ('opencv_extra', given)):
        grown = poses.points_of(ROWS[0], n, pictures, pairs)['one way']
        errors = [measures.errors_of(*points[:2], each) for points, each in zip(grown, truth)]
        yield measures.fifths(title, np.hstack(errors), np.hstack([points[2] for points in grown]))


def homography_rows(datasets, n):
    pictures, pairs, truth = photographs(datasets)
    for row in ROWS:
        stages = poses.points_of(row, n, pictures, pairs)
        before_right = sum(measures.agree_with_homography(*points[:2], homography).sum()
                           for points, homography in zip(stages['as detected'], truth))
        for stage in poses.STAGES:
            near, matches, errors = [], 0, {threshold: [] for threshold in THRESHOLDS}
            for pair, homography, (*points, _) in zip(pairs, truth, stages[stage]):
                off = measures.errors_of(*points, homography)
                near += list(off[off <= measures.CORRECT])
                matches += len(off)
                for threshold in THRESHOLDS:
                    errors[threshold].append(
                        measures.homography_error(*points, homography, pictures[pair.first], 7919, threshold))
            values = np.median(near), len(near) / matches, len(near) / before_right
            yield (['{}, {}'.format(row.title, stage)] + ['{:.2f}'.format(value) for value in values]
                   + poses.best_area(errors, (3, 5)))


def tables(options):
    """(title, head, rows) of each table."""
    for n in options.n:
        yield ('Homographies, n = {}'.format(n),
               ['', 'median error, px', 'right', 'right ones, times', 'AUC at 3 px', 'at 5 px', 'threshold, px'],
               homography_rows(options.datasets, n))
        yield ('Share of errors below the deviation, n = {}'.format(n), measures.FIFTHS,
               coverage_rows(options.datasets, n))
