#!/usr/bin/env python3

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Stereo visual odometry with AdaptiveQuadtreeORB and with cv.ORB on a folder laid out as KITTI's odometry
sequences: calib.txt, image_0 and image_1 (or image_l and image_r) and, for the errors, poses.txt. Prints a table
and writes the paths and the features tracked into the last frame to a picture.

Needs a cv2 that was built with the module aqorb (scripts/opencv.sh builds one)."""

import argparse
import glob
import os
import sys

try:
    import cv2 as cv
    import numpy as np
except ImportError as error:
    print('stereo_odometry.py:', error, file=sys.stderr)
    sys.exit(4)

EPILOG = ('Exit codes: 0 done, 1 bad arguments, 2 an input cannot be read, 3 the picture cannot be written, '
          '4 other.')


class Failure(Exception):
    def __init__(self, exit_code, message):
        super().__init__(message)
        self.exit_code = exit_code


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise Failure(1, message + '; see --help')


class Sequence:
    """A sequence of rectified image pairs."""

    def __init__(self, folder):
        projections = self._matrices(os.path.join(folder, 'calib.txt'))
        self.left = self._images(folder, 'image_l', 'image_0')
        self.right = self._images(folder, 'image_r', 'image_1')
        if len(projections) < 2 or not self.left or len(self.left) != len(self.right):
            raise Failure(2, folder + ': needs calib.txt and as many images of both cameras')
        self.camera = projections[0][:, :3]
        self.baseline = (projections[0][0, 3] - projections[1][0, 3]) / self.camera[0, 0]  # in metres
        self.poses = [np.vstack([m, [0, 0, 0, 1]]) for m in self._matrices(os.path.join(folder, 'poses.txt'))]
        if self.poses and len(self.poses) < len(self.left):
            raise Failure(2, folder + ': poses.txt has fewer poses than there are images')

    @staticmethod
    def _matrices(path):
        if not os.path.exists(path):
            return []
        with open(path, encoding='ascii') as file:
            rows = [np.array(line.split(':')[-1].split(), float) for line in file]
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
        the other way round, among those within two pixels of its row (more for large features) further left."""
        (keypoints, a), (others, b) = [self.detector.detectAndCompute(image, None) for image in (left, right)]
        self.keypoints.append(len(keypoints))
        if not keypoints or not others:
            self.depths.append(0)
            return np.empty((0, 2)), None, np.empty((0, 3))
        p, q = cv.KeyPoint_convert(keypoints), cv.KeyPoint_convert(others)
        rows = 2 * np.array([k.size for k in keypoints]) / 31  # more for large features
        disparity = p[:, None, 0] - q[None, :, 0]
        bits, other_bits = [np.unpackbits(d, axis=1).astype(np.float32) for d in (a, b)]
        distance = bits.sum(1)[:, None] + other_bits.sum(1) - 2 * bits @ other_bits.T  # Hamming
        distance = np.where((abs(p[:, None, 1] - q[None, :, 1]) <= rows[:, None]) & (disparity >= 0.5) &
                            (disparity <= 200), distance, 1 << 20)
        match, back = distance.argmin(1), distance.argmin(0)
        i = np.arange(len(p))
        i = i[(back[match] == i) & (distance[i, match] < 1 << 20)]
        self.depths.append(len(i))
        depth = sequence.camera[0, 0] * sequence.baseline / disparity[i, match[i]]
        rays = np.column_stack([p[i], np.ones(len(i))]) @ np.linalg.inv(sequence.camera).T
        return p[i], a[i], rays * depth[:, None]

    def estimate_motion(self, earlier, later, sequence):
        """The motion between two frames: PnP with RANSAC, refined on the inliers."""
        matches = []
        if len(earlier[0]) and len(later[0]):
            matches = cv.BFMatcher(self.detector.defaultNorm(), crossCheck=True).match(earlier[1], later[1])
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
    """Of the motion over `step` frames: per cent of the way, degrees per 100 m. Of the last position: per cent."""
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
        print('{:44} {:>10} {:>20}'.format(label, *[form.format(v) for v in values]))

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
    row('translation error over 10 frames, of the way', '{:.2f} %', columns[0])
    row('rotation error over 10 frames, degrees/100 m', '{:.2f}', columns[1])
    row('error of the last position, of the way', '{:.2f} %', columns[2])


def track_picture(odometry, left):
    """The left image with the tracked features: a line from where each was in the frame before."""
    picture = cv.cvtColor(left, cv.COLOR_GRAY2BGR)
    for p, q in zip(*(odometry.tracks or ([], []))):
        cv.line(picture, np.intp(p.round()), np.intp(q.round()), odometry.colour, 1, cv.LINE_AA)
        cv.circle(picture, np.intp(q.round()), 2, odometry.colour, cv.FILLED, cv.LINE_AA)
    text = '{}: {} inliers'.format(odometry.name, odometry.inliers[-1] if odometry.inliers else 0)
    for colour, thickness in (((0, 0, 0), 4), (odometry.colour, 1)):
        cv.putText(picture, text, (10, 24), cv.FONT_HERSHEY_SIMPLEX, 0.7, colour, thickness, cv.LINE_AA)
    return picture


def path_picture(paths, size):
    """The paths from above: x to the right, z (ahead) to the top."""
    width, height = size
    lines = [np.array([pose[[0, 2], 3] for pose in poses]) for poses, _ in paths]
    corners = np.vstack(lines + [np.array([[-5, -5], [5, 5]])])
    low, high = corners.min(0), corners.max(0)
    scale = ((np.array(size) - 40) / (high - low)).min()
    picture = np.full((height, width, 3), 255, np.uint8)
    for line, (_, colour) in zip(lines, paths):
        pixels = np.array(size) / 2 + (line - (low + high) / 2) * scale * (1, -1)
        cv.polylines(picture, [pixels.round().astype(np.int32)], False, colour, 2, cv.LINE_AA)
    cv.line(picture, (10, height - 10), (10 + round(10 * scale), height - 10), (0, 0, 0), 2)
    return cv.putText(picture, '10 m', (10, height - 18), cv.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv.LINE_AA)


def draw_all(odometries, sequence, left):
    paths = [(o.poses, o.colour) for o in odometries]
    if sequence.poses:
        start = np.linalg.inv(sequence.poses[0])
        paths.insert(0, ([start @ pose for pose in sequence.poses[:len(paths[0][0])]], (160, 160, 160)))
    tracks = cv.vconcat([track_picture(o, left) for o in odometries])
    return cv.hconcat([tracks, path_picture(paths, (tracks.shape[0] // 2, tracks.shape[0]))])


def read_image(path):
    image = cv.imread(path, cv.IMREAD_GRAYSCALE)
    if image is None:
        raise Failure(2, path + ': not an image that OpenCV can read')
    return image


def run():
    parser = Parser(description=__doc__, epilog=EPILOG, allow_abbrev=False,
                    formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', help='the sequence')
    parser.add_argument('--nfeatures', metavar='N', type=int, default=1000,
                        help='number of keypoints to ask for, at least 1 (1000)')
    parser.add_argument('--out', metavar='FILE', default='stereo_odometry.jpg',
                        help='the picture (stereo_odometry.jpg)')
    parser.add_argument('--show', action='store_true', help='show the picture in a window, too, frame by frame')
    arguments = parser.parse_args()
    if arguments.nfeatures < 1:
        raise Failure(1, '--nfeatures: a whole number >= 1 is accepted')
    if not hasattr(cv, 'aqorb'):
        raise Failure(4, '{} was built without the module aqorb; see README.md, "Inside OpenCV"'.format(
            getattr(cv, '__file__', 'cv2')))

    sequence = Sequence(arguments.folder)
    odometries = [Odometry('cv.ORB', cv.ORB_create(arguments.nfeatures), (60, 60, 230)),
                  Odometry('AdaptiveQuadtreeORB', cv.aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures),
                           (40, 200, 40))]
    for left_path, right_path in zip(sequence.left, sequence.right):
        left, right = read_image(left_path), read_image(right_path)
        for odometry in odometries:
            odometry.add(left, right, sequence)
        if arguments.show:
            cv.imshow('stereo odometry (Esc: stop)', draw_all(odometries, sequence, left))
            if cv.waitKey(30) == 27:
                break
    print_table(odometries, sequence)
    try:
        written = cv.imwrite(arguments.out, draw_all(odometries, sequence, left), [cv.IMWRITE_JPEG_QUALITY, 85])
    except cv.error:  # no such format
        written = False
    if not written:
        raise Failure(3, arguments.out + ': cannot be written')
    print('Picture:', arguments.out)


def main():
    try:
        run()
    except Failure as failure:
        print('stereo_odometry.py:', failure, file=sys.stderr)
        return failure.exit_code
    except cv.error as error:
        print('stereo_odometry.py:', error, file=sys.stderr)
        return 4
    return 0


if __name__ == '__main__':
    sys.exit(main())
