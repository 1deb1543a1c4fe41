#!/usr/bin/env python3

# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Finds keypoints inside the circle of a fisheye lens: without a mask, where the rim of the circle takes some, and
with one. Without an image it takes graf1.png of OpenCV's samples."""

# Imported first, because it says what is missing if an import fails.
from program import BAD_ARGUMENTS, Failure, Program, aqorb, file_at, read_image, run, write_picture

import cv2 as cv
import numpy as np

from drawing import GREEN, captioned, enlarged, keypoint_picture, line_width, size_of

LARGEST = 1000000


def parse_arguments():
    program = Program(__doc__, '[IMAGE]', 0, 1, 'fisheye_mask.py --radius=290 --margin=10 fisheye.png')
    program.add_whole_number('x', -1, -1, LARGEST, "centre of the lens's circle, in pixels; -1: centre of the image")
    program.add_whole_number('y', -1, -1, LARGEST, 'the same, from the top')
    program.add_whole_number('radius', -1, -1, LARGEST, 'radius of the circle; -1: up to the nearest side of the image')
    program.add_whole_number('margin', 8, 0, LARGEST, "pixels to keep away from the circle's rim")
    program.add_feature_count()
    program.add_text('out', 'fisheye_mask.jpg', 'picture to write')
    return program.parse()


def main():
    arguments = parse_arguments()
    image = read_image(file_at(arguments, 0, 'graf1.png'))
    height, width = image.shape
    x = width // 2 if arguments.x < 0 else arguments.x
    y = height // 2 if arguments.y < 0 else arguments.y
    if x >= width or y >= height:
        raise Failure(BAD_ARGUMENTS, '--x={} --y={}: a centre inside the image of {}x{} pixels is accepted'.format(
            x, y, width, height))
    radius = min(x, width - x, y, height - y) if arguments.radius < 0 else arguments.radius
    inner = radius - arguments.margin
    if inner < 0:
        raise Failure(BAD_ARGUMENTS, '--margin={}: at most the radius of {} pixels is accepted'.format(
            arguments.margin, radius))

    # Keypoints may lie where the mask is not zero. The detector scales the mask for its pyramid.
    mask = cv.circle(np.zeros_like(image), (x, y), inner, 255, cv.FILLED)

    detector = aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)
    pictures = []
    for name, used in ('Without', None), ('With', mask):
        keypoints = detector.detect(image, used)
        outside = sum(np.hypot(k.pt[0] - x, k.pt[1] - y) > inner + 1 for k in keypoints)
        text = '{} mask: {} keypoints, {} not inside the circle'.format(name, len(keypoints), outside)
        print(text)
        picture = keypoint_picture(image, keypoints)
        factor = picture.shape[1] // width
        cv.circle(picture, np.intp(enlarged((x, y), factor)), inner * factor, GREEN, line_width(size_of(picture)),
                  cv.LINE_AA)
        pictures.append(captioned(picture, text))
    write_picture(arguments.out, cv.hconcat(pictures))


if __name__ == '__main__':
    run(main)
