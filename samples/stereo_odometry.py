#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Stereo visual odometry with AdaptiveQuadtreeORB and with cv.ORB. FOLDER is laid out as KITTI's odometry sequences:
calib.txt, image_0 and image_1 (or image_l and image_r) and, for the errors, poses.txt. Prints a table and writes the
paths and the features tracked into the last frame to a picture."""

import argparse
import glob
import os
import sys

import cv2 as cv
import numpy as np

try:
    import aqorb
except ImportError:  # a cv2 that was built with the module
    from cv2 import aqorb


class Sequence:
    """A sequence of rectified image pairs."""

    def __init__(self, folder):
        projections = self._matrices(os.path.join(folder, 'calib.txt'))
        self.left = self._images(folder, 'image_l', 'image_0')
        self.right = self._images(folder, 'image_r', 'image_1')
        if len(projections) < 2 or not self.left or len(self.left) != len(self.right):
            sys.exit(folder + ': needs calib.txt and as many images of both cameras')
        self.camera = projections[0][:, :3]
        self.baseline = (projections[0][0, 3] - projections[1][0, 3]) / self.camera[0, 0]  # in metres
        self.poses = [np.vstack([m, [0, 0, 0, 1]]) for m in self._matrices(os.path.join(folder, 'poses.txt'))]
        if self.poses and len(self.poses) < len(self.left):
            sys.exit(folder + ': poses.txt has fewer poses than there are images')

    @staticmethod
    def _matrices(path):
        if not os.path.exists(path):
            return []
        with open(path, encoding='ascii') as file:
            try:
                rows = [np.array(line.split(':')[-1].split(), float) for line in file]
            except ValueError:  # no number, or no ASCII
                sys.exit(path + ': rows of 12 numbers are accepted')
        return [row.reshape(3, 4) for row in rows if row.size == 12]

    @staticmethod
    def _images(folder, a, b):
        folder = os.path.join(folder, a if os.path.isdir(os.path.join(folder, a)) else b)
        return sorted(glob.glob(os.path.join(folder, '*.png')))


class Odometry:
    def __init__(self, name, detector, colour):
        self.name, self.detector, self.colour = name, detector, colour
        self.poses = []  # of the left camera, from the first frame's on
        self.keypoints, self.depths, self.inliers, self.lost = [], [], [], 0
        self.frame = self.tracks = None
        self.motion = np.eye(4)

    def add(self, left, right, sequence):
        frame = self.stereo_frame(left, right, sequence)
        if self.frame is None:
            self.poses.append(np.eye(4))
        else:
            self.estimate_motion(self.frame, frame, sequence)
            self.poses.append(self.poses[-1] @ self.motion)
        self.frame = frame

    def stereo_frame(self, left, right, sequence):
        """Pixels, descriptors and points in space of the features that match one of the right image best, and
        the other way round, among those within some rows and at most 200 pixels further left."""
        (keypoints, a), (others, b) = [self.detector.detectAndCompute(image, None) for image in (left, right)]
        self.keypoints.append(len(keypoints))
        if not keypoints or not others:
            self.depths.append(0)
            return np.empty((0, 2)), None, np.empty((0, 3))
        p, q = cv.KeyPoint_convert(keypoints), cv.KeyPoint_convert(others)
        low, high = 0.5, 200  # disparity
        predicted = p - np.float32([(low + high) / 2, 0])
        pairs, _ = aqorb.matchByPosition(a, predicted, b, others, ((high - low) / 2, 3),
                                         normType=self.detector.defaultNorm())
        if pairs is None:  # of a cv2 that was built with the module
            pairs = np.empty((0, 2), int)
        self.depths.append(len(pairs))
        i, match = pairs.T
        depth = sequence.camera[0, 0] * sequence.baseline / (p[i, 0] - q[match, 0])
        rays = np.column_stack([p[i], np.ones(len(i))]) @ np.linalg.inv(sequence.camera).T
        return p[i], a[i], rays * depth[:, None]

    def estimate_motion(self, earlier, later, sequence):
        """The motion between two frames: PnP with RANSAC, refined on the inliers."""
        matches = []
        if len(earlier[0]) and len(later[0]):
            matches = aqorb.HammingMatcher(self.detector.defaultNorm(), crossCheck=True).match(earlier[1], later[1])
        source, target = [m.queryIdx for m in matches], [m.trainIdx for m in matches]
        points, pixels = earlier[2][source], later[0][target].astype(float)
        found, inliers = False, None
        if len(matches) >= 6:
            found, rotation, translation, inliers = cv.solvePnPRansac(
                points, pixels, sequence.camera, None, iterationsCount=1000, reprojectionError=2,
                confidence=0.9999, flags=cv.SOLVEPNP_P3P)
        if not found or len(inliers) < 6:  # the last motion is taken again
            self.lost += 1
            self.inliers.append(0)
            self.tracks = None
            return
        inliers = inliers[:, 0]
        rotation, translation = cv.solvePnPRefineLM(points[inliers], pixels[inliers], sequence.camera, None,
                                                    rotation, translation)
        motion = np.eye(4)
        motion[:3, :3], motion[:3, 3] = cv.Rodrigues(rotation)[0], translation[:, 0]
        self.motion = np.linalg.inv(motion)
        self.inliers.append(len(inliers))
        self.tracks = earlier[0][source][inliers], later[0][target][inliers]


def path_length(poses):
    return np.linalg.norm(np.diff([pose[:3, 3] for pose in poses], axis=0), axis=1).sum()


def motion_error(estimate, truth):
    """Metres and degrees between two rigid motions."""
    rest = np.linalg.inv(truth) @ estimate
    return np.linalg.norm(rest[:3, 3]), np.degrees(np.linalg.norm(cv.Rodrigues(rest[:3, :3])[0]))


def errors(poses, truth, step=10):
    """Of the motion over `step` frames: per cent of the path, degrees per 100 m. Of the last position: per cent."""
    all_errors = []
    for i in range(len(poses) - step):
        error = motion_error(np.linalg.inv(poses[i]) @ poses[i + step], np.linalg.inv(truth[i]) @ truth[i + step])
        all_errors.append(100 * np.array(error) / max(path_length(truth[i:i + step + 1]), 1e-6))
    last = len(poses) - 1
    end = motion_error(poses[last], np.linalg.inv(truth[0]) @ truth[last])[0]
    mean = np.mean(all_errors, axis=0) if all_errors else (0, 0)
    return mean[0], mean[1], 100 * end / max(path_length(truth[:last + 1]), 1e-6)


def print_table(odometries, sequence):
    def row(label, form, values):
        print('{:45} {:>10} {:>20}'.format(label, *[form.format(v) for v in values]))

    frames = len(odometries[0].poses)
    row('{} frames'.format(frames), '{}', [o.name for o in odometries])
    row('keypoints of the left image, mean', '{:.0f}', [np.mean(o.keypoints) for o in odometries])
    row('  of these with a depth', '{:.0f}', [np.mean(o.depths) for o in odometries])
    row('inliers of the motion, mean', '{:.0f}', [np.mean(o.inliers or 0) for o in odometries])
    row('frames whose motion was not found', '{}', [o.lost for o in odometries])
    row('length of the path', '{:.2f} m', [path_length(o.poses) for o in odometries])
    if not sequence.poses:
        return
    print('  by poses.txt: {:.2f} m'.format(path_length(sequence.poses[:frames])))
    columns = list(zip(*[errors(o.poses, sequence.poses) for o in odometries]))
    row('translation error over 10 frames, of the path', '{:.2f} %', columns[0])
    row('rotation error over 10 frames, degrees/100 m', '{:.2f}', columns[1])
    row('error of the last position, of the path', '{:.2f} %', columns[2])


def track_picture(odometry, left):
    """The left image with the tracked features: a line from where each was in the frame before."""
    picture = cv.cvtColor(left, cv.COLOR_GRAY2BGR)
    for start, end in zip(*(odometry.tracks or ([], []))):
        start, end = np.intp(start.round()), np.intp(end.round())
        cv.line(picture, start, end, odometry.colour, 1, cv.LINE_AA)
        cv.circle(picture, end, 2, odometry.colour, cv.FILLED, cv.LINE_AA)
    picture = cv.copyMakeBorder(picture, 40, 0, 0, 0, cv.BORDER_CONSTANT, value=(255, 255, 255))
    text = '{}: {} inliers'.format(odometry.name, odometry.inliers[-1] if odometry.inliers else 0)
    return cv.putText(picture, text, (12, 28), cv.FONT_HERSHEY_SIMPLEX, 0.75, odometry.colour, 1, cv.LINE_AA)


def path_picture(paths, size):
    """The paths from above: x to the right, z (ahead) to the top."""
    width, height = size
    lines = [np.array([pose[[0, 2], 3] for pose in poses]) for poses, _ in paths]
    corners = np.vstack(lines + [np.array([[-5, -5], [5, 5]])])
    low, high = corners.min(0), corners.max(0)
    margin = 20
    scale = ((np.array(size) - (2 * margin, 4 * margin)) / (high - low)).min()
    picture = np.full((height, width, 3), 255, np.uint8)
    for line, (_, colour) in zip(lines, paths):
        pixels = np.array(size) / 2 + (line - (low + high) / 2) * scale * (1, -1)
        cv.polylines(picture, [pixels.round().astype(np.int32)], False, colour, 2, cv.LINE_AA)
    x, y = 10, height - 10
    cv.line(picture, (x, y), (x + round(10 * scale), y), (0, 0, 0), 2)
    for text, position in (('10 m', (x, y - 8)),
                           ('Paths from above; grey: poses.txt', (x, margin))):
        cv.putText(picture, text, position, cv.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv.LINE_AA)
    return picture


def draw_all(odometries, sequence, left):
    paths = [(o.poses, o.colour) for o in odometries]
    if sequence.poses:
        start = np.linalg.inv(sequence.poses[0])
        paths.insert(0, ([start @ pose for pose in sequence.poses[:len(paths[0][0])]], (160, 160, 160)))
    tracks = cv.vconcat([track_picture(o, left) for o in odometries])
    return cv.hconcat([tracks, path_picture(paths, (tracks.shape[0] // 2, tracks.shape[0]))])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nfeatures', type=int, default=1000)
    parser.add_argument('--show', action='store_true', help='show the picture in a window, too, frame by frame')
    parser.add_argument('--out', default='stereo_odometry.jpg', help='picture to write')
    parser.add_argument('folder')
    arguments = parser.parse_args()

    sequence = Sequence(arguments.folder)
    odometries = [Odometry('cv.ORB', cv.ORB_create(arguments.nfeatures), (60, 60, 230)),
                  Odometry('AdaptiveQuadtreeORB', aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures),
                           (40, 200, 40))]
    for left_path, right_path in zip(sequence.left, sequence.right):
        left, right = [cv.imread(path, cv.IMREAD_GRAYSCALE) for path in (left_path, right_path)]
        if left is None or right is None or left.shape != right.shape:
            sys.exit(left_path + ': not a pair of images of one size')
        for odometry in odometries:
            odometry.add(left, right, sequence)
        if arguments.show:
            cv.imshow('stereo odometry (Esc: stop)', draw_all(odometries, sequence, left))
            if cv.waitKey(30) == 27:
                break
    print_table(odometries, sequence)
    sys.exit(not cv.imwrite(arguments.out, draw_all(odometries, sequence, left)))


if __name__ == '__main__':
    main()
