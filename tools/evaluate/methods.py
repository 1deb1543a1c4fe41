# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The detectors that are compared, by name."""

import math

import aqorb
import cv2
import numpy as np

from measures import Features

# The paper's column C. Where the paper states no value, as for cells and border, the default stays.
PAPER = 'aqorb:selection=quadtree'
TITLES = {'orb': 'cv::ORB (A)', 'orb_slam': "ORB_SLAM's quadtree (B)", PAPER: "the paper's method (C)",
          'aqorb': 'as shipped', 'sift': 'SIFT', 'brisk': 'BRISK', 'akaze': 'AKAZE', 'surf': 'SURF',
          'superpoint': 'SuperPoint'}

# What NAME=VALUE in the name of a method sets.
SETTINGS = {'edge': 'EdgeThreshold', 'fast': 'FastThreshold', 'octave': 'OctaveSuppression', 'radius': 'RankRadius',
            'ratio': 'MinThresholdRatio', 'score': 'ScoreType', 'selection': 'SelectionType',
            'strength': 'StrengthWeight', 'subpixel': 'SubPixel', 'threshold': 'AdaptiveThreshold'}
WORDS = {'quadtree': aqorb.AdaptiveQuadtreeORB_QUADTREE_SELECTION,
         'ranked': aqorb.AdaptiveQuadtreeORB_RANKED_SELECTION, 'fast': cv2.ORB_FAST_SCORE}
# SlamExtractor with the thresholds of ORB-SLAM's example settings; opencv2/aqorb/slam.hpp sets the same.
SLAM = 'fast=20:ratio={}:threshold=0:subpixel=0:octave=0:strength=0.15:radius=2.25'.format(20 / 7)


def number(text):
    return int(text) if text.lstrip('-').isdigit() else float(text)


def with_settings(detector, settings):
    for setting in filter(None, settings.split(':')):
        name, _, value = setting.partition('=')
        if name not in SETTINGS or not value:
            raise ValueError('{}: no setting; there are {}'.format(setting, ', '.join(SETTINGS)))
        kind = type(getattr(detector, 'get' + SETTINGS[name])())
        getattr(detector, 'set' + SETTINGS[name])(kind(WORDS[value] if value in WORDS else number(value)))
    return detector


def is_available(name):
    """Whether cv2 has the detector: OpenCV 5 moved some to its contrib modules."""
    return name == 'aqorb' or hasattr(cv2, name.upper() + '_create')


class Method:
    """A detector by its name: orb:NAME=VALUE:..., orb_slam, sift, brisk, akaze, aqorb:NAME=VALUE:...,
    slam:NAME=VALUE:..."""

    def __init__(self, name):
        self.name = name
        self.title = TITLES.get(name, name)
        self.norm = {'sift': cv2.NORM_L2}.get(name, cv2.NORM_HAMMING)
        self.n, self.detector = None, None
        self.make(1)  # an unknown name is an error before anything is measured

    def make(self, n):
        kind, _, settings = self.name.partition(':')
        if kind == 'slam':  # one more for each level, as there
            return with_settings(aqorb.AdaptiveQuadtreeORB_create(n + 8), SLAM + ':' + settings)
        if kind in ('aqorb', 'orb'):
            return with_settings((aqorb.AdaptiveQuadtreeORB_create if kind == 'aqorb' else cv2.ORB_create)(n), settings)
        makers = {'sift': cv2.SIFT_create, 'orb_slam': OrbSlam,
                  'brisk': lambda _: cv2.BRISK_create(), 'akaze': lambda _: cv2.AKAZE_create()}
        if self.name not in makers:
            raise ValueError('{}: unknown method; there are aqorb, orb, slam, {}'.format(self.name, ', '.join(makers)))
        return makers[self.name](n)

    def prepare(self, n):
        if n != self.n:
            self.n, self.detector = n, self.make(n)

    def compute(self, image, n, mask=None):  # BRISK and AKAZE take no mask here
        self.prepare(n)
        if self.name in ('brisk', 'akaze'):  # the best n by response, as these take no number of features
            keypoints = sorted(self.detector.detect(image), key=lambda point: -point.response)[:n]
            keypoints, descriptors = self.detector.compute(image, keypoints)
        elif hasattr(self.detector, 'detectAndComputeArrays'):
            return Features(*self.detector.detectAndComputeArrays(image, mask))
        else:
            keypoints, descriptors = self.detector.detectAndCompute(image, mask)
        if descriptors is None:
            descriptors = np.zeros((0, 32), np.uint8)
        return Features(aqorb.keypointsToArray(keypoints), descriptors)


class OrbSlam:
    """The keypoint distribution of ORB_SLAM (Mur-Artal et al. 2015), the paper's column B, written from its
    description: FAST with threshold 20 in cells, and with threshold 7 in those that stay empty. Then a quadtree is
    split until it has as many nodes as the level is to have keypoints. The paper names no thresholds; these are usual."""

    LEVELS, SCALE, PATCH, BORDER, CELL, OVERLAP = 8, 1.2, 31, 16, 30, 3

    def __init__(self, n):
        share = n * (1 - 1 / self.SCALE) / (1 - self.SCALE ** -self.LEVELS)  # equation (8)
        self.quotas = [round(share / self.SCALE ** level) for level in range(self.LEVELS - 1)]
        self.quotas.append(max(n - sum(self.quotas), 0))
        self.orb = cv2.ORB_create(1, self.SCALE, 1, self.BORDER)  # describes one level
        y, x = np.mgrid[-15:16, -15:16]
        self.disc = (x * x + y * y <= 15.5 * 15.5).astype(np.float32)
        self.x, self.y = x * self.disc, y * self.disc

    def corners(self, level):
        border, right, bottom = self.BORDER, level.shape[1] - self.BORDER, level.shape[0] - self.BORDER
        width, height = (math.ceil((end - border) / max((end - border) // self.CELL, 1)) for end in (right, bottom))
        found = []
        for top in range(border, bottom, height):
            for left in range(border, right, width):
                x, y = max(left - self.OVERLAP, border), max(top - self.OVERLAP, border)
                cell = level[y:min(top + height + self.OVERLAP, bottom), x:min(left + width + self.OVERLAP, right)]
                for threshold in (20, 7):
                    points = cv2.FastFeatureDetector_create(threshold).detect(cell)
                    if points:
                        break
                found += [(point.pt[0] + x, point.pt[1] + y, point.response) for point in points]
        return np.array(found).reshape(-1, 3)

    def distribute(self, corners, shape, quota):
        """A keypoint of each of about as many nodes as the quota. A node is left, top, width, height and corners."""
        height, width = (side - 2 * self.BORDER for side in shape)
        roots = max(round(width / height), 1)
        column = np.minimum((corners[:, 0] - self.BORDER) * roots // width, roots - 1)
        nodes = [(self.BORDER + i * width / roots, self.BORDER, width / roots, height, corners[column == i])
                 for i in range(roots)]
        nodes = [node for node in nodes if len(node[4])]
        while len(nodes) < quota:
            splits = [len(node[4]) > 1 and node[2] > 1e-3 for node in nodes]
            whole = [node for node, does in zip(nodes, splits) if not does]
            parts = sorted((node for node, does in zip(nodes, splits) if does), key=lambda node: -len(node[4]))
            if not parts:
                break
            one_by_one, count, nodes = len(whole) + 4 * len(parts) > quota, len(whole) + len(parts), []
            for node in parts:
                children = [node] if one_by_one and count >= quota else self.split(*node)
                count += len(children) - 1
                nodes += children
            nodes += whole
        return np.array([node[4][node[4][:, 2].argmax()] for node in nodes]).reshape(-1, 3)

    @staticmethod
    def split(left, top, width, height, points):
        width, height = width / 2, height / 2
        child = (points[:, 0] >= left + width) + 2 * (points[:, 1] >= top + height)
        children = [(left + i % 2 * width, top + i // 2 * height, width, height, points[child == i]) for i in range(4)]
        return [each for each in children if len(each[4])]

    def detectAndCompute(self, image, _):
        level = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        height, width = level.shape
        keypoints, descriptors = [], [np.zeros((0, 32), np.uint8)]
        for octave, quota in enumerate(self.quotas):
            scale = self.SCALE ** octave
            if octave:
                level = cv2.resize(level, (round(width / scale), round(height / scale)))
            points = []
            for x, y, response in self.distribute(self.corners(level), level.shape, quota):
                patch = level[int(y) - 15:int(y) + 16, int(x) - 15:int(x) + 16]
                angle = math.degrees(math.atan2((patch * self.y).sum(), (patch * self.x).sum())) % 360
                points.append(cv2.KeyPoint(x, y, self.PATCH, angle, response, 0))
            points, described = self.orb.compute(level, points)
            for point in points:
                keypoints.append(cv2.KeyPoint(point.pt[0] * scale, point.pt[1] * scale, self.PATCH * scale, point.angle,
                                              point.response, octave))
            if points:
                descriptors.append(described)
        return keypoints, np.vstack(descriptors)
