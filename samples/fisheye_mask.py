#!/usr/bin/env python3

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Masks the black corners of a fisheye lens's image, whose rim would otherwise take keypoints."""

import argparse
import sys

import cv2 as cv
import numpy as np

try:
    import aqorb
except ImportError:
    from cv2 import aqorb


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('image', nargs='?', default='graf1.png', help='image of a fisheye lens (graf1.png)')
    parser.add_argument('--centre', type=int, nargs=2, metavar=('X', 'Y'),
                        help="centre of the lens's circle, in pixels (of the image)")
    parser.add_argument('--radius', type=int, help='radius of the circle (up to the nearest side)')
    parser.add_argument('--margin', type=int, default=8, help="pixels to keep away from the circle's rim (8)")
    parser.add_argument('--nfeatures', type=int, default=1000, help='number of keypoints to ask for (1000)')
    parser.add_argument('--out', default='fisheye_mask.jpg', help='picture to write (fisheye_mask.jpg)')
    arguments = parser.parse_args()
    image = cv.imread(cv.samples.findFile(arguments.image, False), cv.IMREAD_GRAYSCALE)
    if image is None:
        sys.exit(arguments.image + ': not an image that OpenCV can read')
    height, width = image.shape
    x, y = arguments.centre or (width // 2, height // 2)
    radius = arguments.radius or min(x, width - x, y, height - y)
    inner = max(radius - arguments.margin, 0)

    # Not zero where keypoints may lie; the detector scales the mask for its pyramid.
    mask = cv.circle(np.zeros_like(image), (x, y), inner, 255, cv.FILLED)

    detector = aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)
    pictures = []
    for name, used in ('Without', None), ('With', mask):
        keypoints = detector.detect(image, used)
        outside = sum(np.hypot(k.pt[0] - x, k.pt[1] - y) > inner + 1 for k in keypoints)
        text = '{} mask: {} keypoints, {} not inside the circle'.format(name, len(keypoints), outside)
        print(text)
        picture = cv.drawKeypoints(image, keypoints, None, (0, 255, 255))
        cv.circle(picture, (x, y), inner, (0, 255, 0), 1, cv.LINE_AA)
        cv.putText(picture, text, (10, 25), cv.FONT_HERSHEY_SIMPLEX, 0.6, (0, 255, 0), 2, cv.LINE_AA)
        pictures.append(picture)
    if not cv.imwrite(arguments.out, cv.hconcat(pictures)):
        sys.exit(arguments.out + ': cannot be written')
    print('Picture:', arguments.out)


if __name__ == '__main__':
    main()
