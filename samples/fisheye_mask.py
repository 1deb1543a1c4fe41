#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Finds keypoints inside the circle of a fisheye lens: without a mask, where the rim of the circle takes some, and
with one. Without an image it takes graf1.png of OpenCV's samples."""

import argparse

import cv2 as cv
import numpy as np

from sample import aqorb, picture_option, read_image, write_picture


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--radius', type=int, default=-1, help='of the circle; -1: up to the nearest side of the image')
    parser.add_argument('--margin', type=int, default=8, help="pixels to keep away from the circle's rim")
    parser.add_argument('--nfeatures', type=int, default=1000)
    parser.add_argument('--out', type=picture_option, default='fisheye_mask.jpg', help='picture to write')
    parser.add_argument('image', nargs='?', default='graf1.png', help="file, or one of OpenCV's samples")
    arguments = parser.parse_args()
    image = read_image(arguments.image)
    y, x = image.shape[0] // 2, image.shape[1] // 2
    radius = min(x, y) if arguments.radius < 0 else arguments.radius
    inner = max(radius - arguments.margin, 0)

    # Keypoints may lie where the mask is not zero. The detector scales the mask for its pyramid.
    mask = cv.circle(np.zeros_like(image), (x, y), inner, 255, cv.FILLED)

    detector = aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)
    pictures = []
    for name, used in ('Without', None), ('With', mask):
        keypoints = detector.detect(image, used)
        outside = sum(np.hypot(k.pt[0] - x, k.pt[1] - y) > inner + 1 for k in keypoints)
        print('{} mask: {} keypoints, {} not inside the circle'.format(name, len(keypoints), outside))
        picture = cv.drawKeypoints(image, keypoints, None, (0, 255, 255))
        pictures.append(cv.circle(picture, (x, y), inner, (0, 255, 0), 1, cv.LINE_AA))
    write_picture(arguments.out, cv.hconcat(pictures))


if __name__ == '__main__':
    main()
