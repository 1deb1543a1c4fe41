#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Matches two images of a plane and draws where the first image lies in the second. Without images it takes graf1.png
and graf3.png of OpenCV's samples."""

import argparse
import sys

import cv2 as cv
import numpy as np

from sample import aqorb, picture_option, read_image, write_picture


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nfeatures', type=int, default=1000)
    parser.add_argument('--out', type=picture_option, default='homography.jpg', help='picture to write')
    parser.add_argument('image1', nargs='?', default='graf1.png', help="file, or one of OpenCV's samples")
    parser.add_argument('image2', nargs='?', default='graf3.png', help='the same plane from another side')
    arguments = parser.parse_args()
    image1, image2 = read_image(arguments.image1), read_image(arguments.image2)

    orb = aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)
    keypoints1, descriptors1 = orb.detectAndCompute(image1, None)
    keypoints2, descriptors2 = orb.detectAndCompute(image2, None)

    matches = []  # mutual nearest neighbours, as cv.BFMatcher(orb.defaultNorm(), crossCheck=True) gives
    if descriptors1 is not None and descriptors2 is not None:
        matches = aqorb.HammingMatcher(orb.defaultNorm(), crossCheck=True).match(descriptors1, descriptors2)
    count = len(matches)
    # Refined points allow a threshold of one pixel.
    matches, points1, points2 = aqorb.refineMatches(image1, keypoints1, image2, keypoints2, matches)
    homography = None
    if len(matches) >= 4:
        homography, inliers = cv.findHomography(points1, points2, cv.USAC_MAGSAC, 1, maxIters=10000,
                                                confidence=0.9999)
    if homography is None:
        sys.exit('no homography was found among {} matches'.format(len(matches)))
    print('Keypoints: {}, {}'.format(len(keypoints1), len(keypoints2)))
    print('Matches: {}, of which can be refined: {}, of which agree with the homography: {}'.format(
        count, len(matches), inliers.sum()))
    print('Homography:', homography, sep='\n')

    height, width = image1.shape
    corners = np.float32([[[0, 0]], [[width - 1, 0]], [[width - 1, height - 1]], [[0, height - 1]]])
    outline = cv.perspectiveTransform(corners, homography) + (width, 0)  # the second image stands right of the first
    picture = cv.drawMatches(image1, keypoints1, image2, keypoints2, matches, None, (0, 255, 255), (0, 255, 255),
                             inliers.ravel().tolist(), cv.DrawMatchesFlags_NOT_DRAW_SINGLE_POINTS)
    cv.polylines(picture, [np.int32(np.round(outline))], True, (0, 255, 0), 2, cv.LINE_AA)
    write_picture(arguments.out, picture)


if __name__ == '__main__':
    main()
