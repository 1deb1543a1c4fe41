#!/usr/bin/env python3

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Matches two images of a plane and draws where the first lies in the second."""

import argparse
import sys

import cv2 as cv
import numpy as np

try:
    import aqorb
except ImportError:
    from cv2 import aqorb


def read(name):
    image = cv.imread(cv.samples.findFile(name, False), cv.IMREAD_GRAYSCALE)
    if image is None:
        sys.exit(name + ': not an image that OpenCV can read')
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('image1', nargs='?', default='graf1.png', help='image of a plane (graf1.png)')
    parser.add_argument('image2', nargs='?', default='graf3.png', help='another view of it (graf3.png)')
    parser.add_argument('--nfeatures', type=int, default=1000, help='number of keypoints to ask for (1000)')
    parser.add_argument('--out', default='homography.jpg', help='picture to write (homography.jpg)')
    arguments = parser.parse_args()
    image1, image2 = read(arguments.image1), read(arguments.image2)

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
        sys.exit('No homography found among {} matches'.format(len(matches)))
    print('Keypoints: {}, {}'.format(len(keypoints1), len(keypoints2)))
    print('Matches: {}, of which agree with the homography: {}'.format(len(matches), np.count_nonzero(inliers)))
    print('Homography:', homography, sep='\n')

    picture = cv.drawMatches(image1, keypoints1, image2, keypoints2, matches, None, matchColor=(0, 255, 255),
                             matchesMask=inliers.ravel().tolist(),
                             flags=cv.DrawMatchesFlags_NOT_DRAW_SINGLE_POINTS)
    height, width = image1.shape
    corners = np.float32([[[0, 0]], [[width - 1, 0]], [[width - 1, height - 1]], [[0, height - 1]]])
    outline = cv.perspectiveTransform(corners, homography) + (width, 0)  # the second image is to the right
    cv.polylines(picture, [np.int32(outline)], True, (0, 255, 0), 2, cv.LINE_AA)
    if not cv.imwrite(arguments.out, picture):
        sys.exit(arguments.out + ': cannot be written')
    print('Picture:', arguments.out)


if __name__ == '__main__':
    main()
