# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What refineMatches and growMatches give to homographies of photographs, beside the matches as detected."""

import numpy as np

import images
import measures
import poses

THRESHOLDS = [.5, 1, 1.5]  # pixels; a row shows the one that is best for it
ROWS = [poses.Row('aqorb, cross check', 'aqorb', None, 1), poses.Row('aqorb, ratio .9', 'aqorb', .9, 1),
        poses.Row('SIFT, ratio .9', 'sift', .9, 6.75), poses.Row('cv::ORB, ratio .9', 'orb', .9, 1)]


def homography_rows(datasets, n):
    pictures, pairs, truth = [], [], []
    for name in images.SETS:
        found, homographies = images.read_set(datasets, name)
        pairs += [poses.Pair(len(pictures), len(pictures) + i, None, None) for i in range(1, 6)]
        truth += homographies[1:]
        pictures += found
    for row in ROWS:
        stages = poses.points_of(row, n, pictures, pairs)
        before_right = sum(measures.agree_with_homography(*points, homography).sum()
                           for points, homography in zip(stages['as detected'], truth))
        for stage in poses.STAGES:
            near, matches, errors = [], 0, {threshold: [] for threshold in THRESHOLDS}
            for pair, homography, points in zip(pairs, truth, stages[stage]):
                off = np.linalg.norm(measures.transformed(points[0], homography) - points[1], axis=1)
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
