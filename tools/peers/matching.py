#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Compares matchers of binary descriptors, and libraries that estimate the motion between two views, in turns.
scripts/measure.sh peers runs it.

matching.py matchers SEQUENCE   the time of mutual nearest neighbours, by the matchers that pip installs
matching.py views SEQUENCE      the time of the stages from two views to their relative pose, and its error

SEQUENCE is a folder in the layout of KITTI's odometry, with poses.txt. Prints a table. The number of threads is that of
the processors that the process may use.
"""

import os
import sys
import time

import aqorb
import cv2
import faiss
import kornia_rs
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'evaluate'))
import images  # noqa: E402 (after its folder is named)

REPEATS = 11
VIEWS = range(0, 45, 5)  # each with the next but one
THRESHOLD = 1.0  # pixels


def median_times(works):
    """The median times of functions, in ms, and what each returned at last."""
    times, results = np.empty((REPEATS, len(works))), [None] * len(works)
    for repeat in range(-1, REPEATS):  # once to warm up
        for i, work in enumerate(works):
            start = time.perf_counter()
            results[i] = work()
            if repeat >= 0:
                times[repeat, i] = 1000 * (time.perf_counter() - start)
    return np.median(times, 0), results


def mutual(there, back):
    """Pairs of indices, from the nearest train descriptor of each query, and the nearest query of each train."""
    queries = np.arange(len(there))
    chosen = (there >= 0) & (back[there] == queries)
    return np.column_stack([queries[chosen], there[chosen]])


def by_bfmatcher(query, train):
    return np.array([(m.queryIdx, m.trainIdx) for m in cv2.BFMatcher(cv2.NORM_HAMMING, True).match(query, train)])


def by_hamming_matcher(query, train):
    matches = aqorb.HammingMatcher(cv2.NORM_HAMMING, True).match(query, train)
    return np.array([(m.queryIdx, m.trainIdx) for m in matches])


def by_kornia(query, train):
    return kornia_rs.features.match_descriptors(query, train, cross_check=True)


def by_faiss(query, train):
    nearest = []
    for a, b in ((query, train), (train, query)):
        index = faiss.IndexBinaryFlat(256)
        index.add(b)
        nearest.append(index.search(a, 1)[1][:, 0])
    return mutual(*nearest)


def by_flann(query, train):
    nearest = []
    for a, b in ((query, train), (train, query)):
        matcher = cv2.FlannBasedMatcher({'algorithm': 6, 'table_number': 6, 'key_size': 12, 'multi_probe_level': 1})
        found = np.full(len(a), -1)
        for match in matcher.match(a, b):
            found[match.queryIdx] = match.trainIdx
        nearest.append(found)
    return mutual(*nearest)


MATCHERS = {'`cv2.BFMatcher`': by_bfmatcher, '`aqorb.HammingMatcher`': by_hamming_matcher,
            '`aqorb.matchArrays`': lambda query, train: aqorb.matchArrays(query, train)[0],
            'kornia-rs, `match_descriptors`': by_kornia, 'faiss, `IndexBinaryFlat`, both ways': by_faiss,
            '`cv2.FlannBasedMatcher` with LSH, both ways': by_flann}


def matchers(sequence):
    print('| matcher | ' + ' | '.join('n = {0}, ms | pairs of `cv2.BFMatcher`'.format(n) for n in (1000, 2000)) + ' |')
    print('|---|' + '---:|' * 4)
    cells = {name: [] for name in MATCHERS}
    frames = images.read_sequence(sequence)[0]
    for n in 1000, 2000:
        orb = aqorb.AdaptiveQuadtreeORB_create(n)
        query, train = [orb.detectAndComputeArrays(frames[i])[1] for i in (0, 2)]
        times, results = median_times([lambda f=f: f(query, train) for f in MATCHERS.values()])
        expected = {tuple(pair) for pair in results[0].tolist()}
        for name, ms, pairs in zip(MATCHERS, times, results):
            same = len(expected & {tuple(pair) for pair in np.asarray(pairs).tolist()})
            cells[name] += ['{:.2f}'.format(ms), '{:.1f} %'.format(100 * same / len(expected))]
    for name in MATCHERS:
        print('| {} | {} |'.format(name, ' | '.join(cells[name])))


def pose_by_cv2(source, target, camera):
    essential, inliers = cv2.findEssentialMat(source, target, camera, cv2.USAC_MAGSAC, 0.999, THRESHOLD)
    _, rotation, translation, _ = cv2.recoverPose(essential, source, target, camera, mask=inliers)
    return rotation, translation[:, 0]


def pose_by_kornia(source, target, camera):
    pose = kornia_rs.k3d.two_view_estimate(source.astype(float), target.astype(float), camera, seed=1,
                                           ransac_threshold=THRESHOLD)
    return np.array(pose.rotation), np.array(pose.translation).ravel()


def by_cv2_orb(image):
    keypoints, descriptors = cv2.ORB_create(1000).detectAndCompute(image, None)
    return cv2.KeyPoint_convert(keypoints), descriptors


def by_aqorb(image):
    keypoints, descriptors = aqorb.AdaptiveQuadtreeORB_create(1000).detectAndComputeArrays(image)
    return keypoints['pt'], descriptors


def by_kornia_orb(image):
    found = kornia_rs.features.orb_detect_and_compute(image, 640)  # it finds about 1000
    return found.keypoints_xy, found.descriptors


LIBRARIES = {'OpenCV: `ORB`, `BFMatcher`, USAC': (by_cv2_orb, by_bfmatcher, pose_by_cv2),
             'aqorb: `detectAndComputeArrays`, `matchArrays`, and OpenCV\'s USAC':
                 (by_aqorb, MATCHERS['`aqorb.matchArrays`'], pose_by_cv2),
             'kornia-rs: `orb_detect_and_compute`, `match_descriptors`, `two_view_estimate`':
                 (by_kornia_orb, by_kornia, pose_by_kornia)}


def angle(cosine):
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def views(sequence):
    frames, camera, poses = images.read_sequence(sequence)
    camera = np.ascontiguousarray(camera)
    rows = {name: [] for name in LIBRARIES}
    for first in VIEWS:
        pair = [frames[first], frames[first + 2]]
        true = np.linalg.inv(poses[first + 2]) @ poses[first]
        stages = list(LIBRARIES.values())
        detecting, found = median_times([lambda s=s: [s[0](image) for image in pair] for s in stages])
        matching, pairs = median_times([lambda s=s, f=f: s[1](f[0][1], f[1][1]) for s, f in zip(stages, found)])
        points = [(np.float32(f[0][0])[p[:, 0]], np.float32(f[1][0])[p[:, 1]]) for f, p in zip(found, pairs)]
        posing, estimates = median_times([lambda s=s, p=p: s[2](p[0], p[1], camera) for s, p in zip(stages, points)])
        for i, name in enumerate(LIBRARIES):
            rotation, translation = estimates[i]
            direction = true[:3, 3] / np.linalg.norm(true[:3, 3])
            rows[name].append((detecting[i], matching[i], posing[i], len(pairs[i]),
                               angle((np.trace(rotation @ true[:3, :3].T) - 1) / 2), angle(translation @ direction)))
    print('| library | detect two frames, ms | match, ms | pose, ms | in all, ms | matches | rotation error, degrees '
          '| direction error, degrees |')
    print('|---|' + '---:|' * 7)
    for name, row in rows.items():
        detect, match, pose, count, *errors = np.median(row, 0)
        print('| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.0f} | {:.3f} | {:.2f} |'.format(
            name, detect, match, pose, detect + match + pose, count, *errors))


if __name__ == '__main__':
    commands = {'matchers': matchers, 'views': views}
    if len(sys.argv) != 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    cv2.setNumThreads(len(os.sched_getaffinity(0)))
    aqorb.setNumThreads(len(os.sched_getaffinity(0)))
    commands[sys.argv[1]](sys.argv[2])
