#!/usr/bin/env python3

# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Keeps some keypoints of SIFT and of FAST: by response alone, as cv::KeyPointsFilter::retainBest in C++, and by
retainUniform, which spreads them over the image. Without an image it takes graf1.png of OpenCV's samples."""

# Imported first, because it says what is missing if an import fails.
from program import Program, aqorb, file_at, read_image, run, write_picture

import cv2 as cv

from drawing import captioned, keypoint_picture, size_of


def retain_best(keypoints, npoints):
    """As cv::KeyPointsFilter::retainBest, which Python does not have."""
    return sorted(keypoints, key=lambda k: k.response, reverse=True)[:npoints]


def drawn(image, keypoints, name):
    size = size_of(image)
    print('{:24} {:9} {:10.1f} {:9.0f} %'.format(name, len(keypoints),
                                                 aqorb.distributionUniformity(keypoints, size),
                                                 100 * aqorb.distributionOccupancy(keypoints, size)))
    return captioned(keypoint_picture(image, keypoints), name)


def main():
    program = Program(__doc__, '[IMAGE]', 0, 1, 'retain_uniform.py --npoints=300 graf1.png')
    program.add_feature_count(500, 'npoints', 'number of keypoints to keep')
    program.add_text('out', 'retain_uniform.jpg', 'picture to write')
    arguments = program.parse()
    image = read_image(file_at(arguments, 0, 'graf1.png'))

    print('{:24} {:>9} {:>10} {:>11}'.format('', 'keypoints', 'uniformity', 'occupied'))
    rows = []
    for name, detector in ('SIFT', cv.SIFT_create()), ('FAST', cv.FastFeatureDetector_create()):
        keypoints = detector.detect(image)
        best = retain_best(keypoints, arguments.npoints)
        uniform = aqorb.retainUniform(keypoints, size_of(image), arguments.npoints)
        rows.append(cv.hconcat([drawn(image, best, name + ', retainBest'),
                                drawn(image, uniform, name + ', retainUniform')]))
    write_picture(arguments.out, cv.vconcat(rows))


if __name__ == '__main__':
    run(main)
