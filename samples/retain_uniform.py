#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Keeps some keypoints of SIFT and of FAST: by response alone, as cv::KeyPointsFilter::retainBest in C++ (left), and by
retainUniform, which spreads them over the image. Without an image it takes graf1.png of OpenCV's samples."""

import argparse

import cv2 as cv

from sample import aqorb, picture_option, read_image, write_picture


def drawn(image, keypoints, name):
    size = image.shape[1::-1]
    print('{:24} {:9} {:10.1f} {:9.0f} %'.format(name, len(keypoints), aqorb.distributionUniformity(keypoints, size),
                                                 100 * aqorb.distributionOccupancy(keypoints, size)))
    picture = cv.drawKeypoints(image, keypoints, None, (0, 255, 255))
    picture = cv.copyMakeBorder(picture, 34, 0, 0, 8, cv.BORDER_CONSTANT, value=(255, 255, 255))
    return cv.putText(picture, name, (8, 23), cv.FONT_HERSHEY_SIMPLEX, 0.65, (0, 0, 0), 1, cv.LINE_AA)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--npoints', type=int, default=500, help='number of keypoints to keep')
    parser.add_argument('--out', type=picture_option, default='retain_uniform.jpg', help='picture to write')
    parser.add_argument('image', nargs='?', default='graf1.png', help="file, or one of OpenCV's samples")
    arguments = parser.parse_args()
    image = read_image(arguments.image)

    print('{:24} {:>9} {:>10} {:>11}'.format('', 'keypoints', 'uniformity', 'occupied'))
    rows = []
    for name, detector in ('SIFT', cv.SIFT_create()), ('FAST', cv.FastFeatureDetector_create()):
        keypoints = detector.detect(image)
        best = sorted(keypoints, key=lambda k: k.response, reverse=True)[:arguments.npoints]
        uniform = aqorb.retainUniform(keypoints, image.shape[1::-1], arguments.npoints)
        rows.append(cv.hconcat([drawn(image, best, name + ', retainBest'),
                                drawn(image, uniform, name + ', retainUniform')]))
    write_picture(arguments.out, cv.vconcat(rows))


if __name__ == '__main__':
    main()
