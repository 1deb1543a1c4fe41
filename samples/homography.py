#!/usr/bin/env python3

# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Matches two images of a plane, estimates the homography between them, and draws where the first image lies in
the second. Without images it takes graf1.png and graf3.png of OpenCV's samples."""

# Imported first, because it says what is missing if an import fails.
from program import BAD_ARGUMENTS, FAILED, Failure, Program, aqorb, file_at, read_image, run, write_picture

import cv2 as cv
import numpy as np

from drawing import match_picture


def main():
    program = Program(__doc__, '[IMAGE1 IMAGE2]', 0, 2, 'homography.py --nfeatures=2000 graf1.png graf3.png')
    program.add_feature_count()
    program.add_text('out', 'homography.jpg', 'picture to write')
    arguments = program.parse()
    if len(arguments.files) == 1:
        raise Failure(BAD_ARGUMENTS, arguments.files[0] + ': a second image is needed')
    image1, image2 = read_image(file_at(arguments, 0, 'graf1.png')), read_image(file_at(arguments, 1, 'graf3.png'))

    orb = aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)
    keypoints1, descriptors1 = orb.detectAndCompute(image1, None)
    keypoints2, descriptors2 = orb.detectAndCompute(image2, None)

    matches = []  # mutual nearest neighbours
    if descriptors1 is not None and descriptors2 is not None:
        matches = cv.BFMatcher(orb.defaultNorm(), crossCheck=True).match(descriptors1, descriptors2)
    homography = None
    if len(matches) >= 4:
        points1 = np.float32([keypoints1[m.queryIdx].pt for m in matches])
        points2 = np.float32([keypoints2[m.trainIdx].pt for m in matches])
        homography, inliers = cv.findHomography(points1, points2, cv.USAC_MAGSAC, 3, maxIters=10000,
                                                confidence=0.9999)
    if homography is None:
        raise Failure(FAILED, 'no homography was found among {} matches'.format(len(matches)))
    inliers = [match for match, is_inlier in zip(matches, inliers.ravel()) if is_inlier]
    print('Keypoints: {}, {}'.format(len(keypoints1), len(keypoints2)))
    print('Matches: {}, of which agree with the homography: {}'.format(len(matches), len(inliers)))
    print('Homography:', homography, sep='\n')

    height, width = image1.shape
    corners = np.float32([[[0, 0]], [[width - 1, 0]], [[width - 1, height - 1]], [[0, height - 1]]])
    mapped = cv.perspectiveTransform(corners, homography)
    write_picture(arguments.out, match_picture(image1, keypoints1, image2, keypoints2, inliers, mapped))


if __name__ == '__main__':
    run(main)
