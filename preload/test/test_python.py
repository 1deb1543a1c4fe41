# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

'''
A cv2 that is linked to OpenCV dynamically, as Debian's, with libaqorb_preload.so preloaded.

scripts/dropin.sh runs it; OPENCV_SAMPLES names OpenCV's folder samples/python, OPENCV_SAMPLES_DATA_PATH
its folder samples/data.
'''

import os
import sys
import unittest

import cv2 as cv
import numpy as np

sys.path.insert(0, os.environ['OPENCV_SAMPLES'])
import plane_tracker  # noqa: E402  OpenCV's own, unchanged


def read(name):
    return cv.imread(cv.samples.findFile(name), cv.IMREAD_GRAYSCALE)


class Preload(unittest.TestCase):

    def test_every_way_to_create_is_reached(self):
        for create in cv.ORB_create, cv.ORB.create:
            self.assertEqual('Feature2D.AdaptiveQuadtreeORB', create().getDefaultName())
        self.assertEqual('Feature2D.AKAZE', cv.AKAZE_create().getDefaultName())

    def test_matches_a_known_motion(self):
        image = read('home.jpg')
        shift = 9
        orb = cv.ORB_create(500)
        keypoints, descriptors = orb.detectAndCompute(image, None)
        moved, others = orb.detectAndCompute(np.ascontiguousarray(image[:, shift:]), None)
        self.assertEqual((500, 32), descriptors.shape)
        matches = cv.BFMatcher(orb.defaultNorm(), crossCheck=True).match(descriptors, others)
        correct = sum(np.hypot(keypoints[m.queryIdx].pt[0] - moved[m.trainIdx].pt[0] - shift,
                               keypoints[m.queryIdx].pt[1] - moved[m.trainIdx].pt[1]) < 3 for m in matches)
        self.assertGreater(correct, 0.7 * len(matches))
        self.assertGreater(correct, 200)

    def test_planes_are_tracked(self):
        image = read('box.png')
        height, width = image.shape
        tracker = plane_tracker.PlaneTracker()
        tracker.add_target(image, (0, 0, width, height))
        angle = np.float32([[0.9, -0.3, 90], [0.3, 0.9, 20], [0, 0, 1]])
        tracked = tracker.track(cv.warpPerspective(image, angle, (width + 100, height + 100)))
        self.assertEqual(1, len(tracked))
        corners = np.float32([[[0, 0], [width, 0], [width, height], [0, height]]])
        expected = cv.perspectiveTransform(corners, angle)[0]
        self.assertLess(np.abs(tracked[0].quad - expected).max(), 5)


if __name__ == '__main__':
    unittest.main()
