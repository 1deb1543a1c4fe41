#!/usr/bin/env python3

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Thins out the keypoints of SIFT and of FAST: keeps the best by response, which cluster, and, by retainUniform, the
best spread."""

import argparse
import sys

import cv2 as cv

try:
    import aqorb
except ImportError:
    from cv2 import aqorb


def retain_best(keypoints, npoints):
    """As cv::KeyPointsFilter::retainBest, which Python does not have."""
    return sorted(keypoints, key=lambda k: k.response, reverse=True)[:npoints]


def drawn(image, keypoints, name):
    size = image.shape[::-1]
    print('{:24} {:9} {:10.1f} {:9.0f} %'.format(name, len(keypoints),
                                                 aqorb.distributionUniformity(keypoints, size),
                                                 100 * aqorb.distributionOccupancy(keypoints, size)))
    picture = cv.drawKeypoints(image, keypoints, None, (0, 255, 255))
    return cv.putText(picture, name, (10, 25), cv.FONT_HERSHEY_SIMPLEX, 0.75, (0, 255, 0), 2, cv.LINE_AA)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('image', nargs='?', default='graf1.png', help='(graf1.png)')
    parser.add_argument('--npoints', type=int, default=500, help='number of keypoints to keep (500)')
    parser.add_argument('--out', default='retain_uniform.jpg', help='picture to write (retain_uniform.jpg)')
    arguments = parser.parse_args()
    image = cv.imread(cv.samples.findFile(arguments.image, False), cv.IMREAD_GRAYSCALE)
    if image is None:
        sys.exit(arguments.image + ': not an image that OpenCV can read')

    print('{:24} {:>9} {:>10} {:>11}'.format('', 'keypoints', 'uniformity', 'occupied'))
    rows = []
    for name, detector in ('SIFT', cv.SIFT_create()), ('FAST', cv.FastFeatureDetector_create()):
        keypoints = detector.detect(image)
        best = retain_best(keypoints, arguments.npoints)
        uniform = aqorb.retainUniform(keypoints, image.shape[::-1], arguments.npoints)
        rows.append(cv.hconcat([drawn(image, best, name + ', retainBest'),
                                drawn(image, uniform, name + ', retainUniform')]))
    if not cv.imwrite(arguments.out, cv.vconcat(rows)):
        sys.exit(arguments.out + ': cannot be written')
    print('Picture:', arguments.out)


if __name__ == '__main__':
    main()
