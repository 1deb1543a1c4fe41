#!/usr/bin/env python3

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Compares AdaptiveQuadtreeORB with cv.ORB on images: prints a table and writes the pictures
aqorb_keypoints.jpg and, for two images, aqorb_matches.jpg. More than two images are taken one by one
(aqorb_keypoints1.jpg, ...).

Needs the package aqorb (scripts/python.sh builds it) or a cv2 that was built with the module (scripts/opencv.sh
builds one)."""

import argparse
import os
import statistics
import sys
from collections import namedtuple

try:
    import cv2 as cv
    import numpy as np
    try:
        import aqorb
    except ImportError:
        from cv2 import aqorb
except ImportError as error:
    print('aqorb_demo.py:', error, file=sys.stderr)
    sys.exit(4)

EPILOG = ('Exit codes: 0 done, 1 bad arguments, 2 an input cannot be read, 3 a picture cannot be written, '
          '4 other.')

# features: keypoints and descriptors of each image; matches: distinct, and in agreement with the homography;
# homography_error: in pixels, or None
Result = namedtuple('Result', 'name detector features matches homography_error')


class Failure(Exception):
    def __init__(self, exit_code, message):
        super().__init__(message)
        self.exit_code = exit_code


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise Failure(1, message + '; see --help')


def count(text):
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(text + ': a whole number >= 1 is accepted')
    return int(text)


def parse_arguments():
    parser = Parser(description=__doc__, epilog=EPILOG, allow_abbrev=False,
                    formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--homography', metavar='FILE',
                        help='XML, YAML or JSON file with the 3x3 homography from image1 to image2; without it '
                             'the matches are counted that agree with the homography estimated from them')
    parser.add_argument('--out', metavar='DIR', default='.', help='existing folder for the pictures (.)')
    parser.add_argument('--nfeatures', metavar='N', type=count, default=1000,
                        help='number of keypoints to ask for, at least 1 (1000)')
    parser.add_argument('images', nargs='*', metavar='image',
                        help="without images, OpenCV's samples graf1.png, graf3.png and H1to3p.xml are taken")
    arguments = parser.parse_args()
    if arguments.homography and len(arguments.images) not in (0, 2):
        raise Failure(1, '--homography needs two images')
    if not os.path.isdir(arguments.out):
        raise Failure(3, arguments.out + ': no such folder')
    if not arguments.images:
        arguments.images, arguments.homography = ['graf1.png', 'graf3.png'], 'H1to3p.xml'
    return arguments


def find(name):
    """The path of a file or of one of OpenCV's samples."""
    path = cv.samples.findFile(name, False, True)
    if not path:
        raise Failure(2, name + ': no such file, nor a sample in OPENCV_SAMPLES_DATA_PATH')
    return path


def read_image(name):
    image = cv.imread(find(name), cv.IMREAD_GRAYSCALE)
    if image is None:
        raise Failure(2, name + ': not an image that OpenCV can read')
    return image


def read_homography(name):
    """The first matrix in the file, whatever its name."""
    path = find(name)
    homography = None
    try:
        storage = cv.FileStorage(path, cv.FILE_STORAGE_READ)
        homography = storage.getFirstTopLevelNode().mat()
    except (cv.error, SystemError):  # neither XML, YAML nor JSON, or no matrix
        pass
    if homography is None or homography.shape != (3, 3):
        raise Failure(2, name + ': holds no 3x3 matrix')
    return homography.astype(float)


def match_features(a, b, norm):
    """Mutual nearest neighbours, the best first."""
    if a[1] is None or b[1] is None:
        return []
    return sorted(cv.BFMatcher(norm, crossCheck=True).match(a[1], b[1]), key=lambda m: m.distance)


def distinct_correct(matches, start, end, homography):
    """The matches within 3 pixels of the homography, each at least 4 pixels away from every better one in both
    images: several keypoints on one corner of the scene say no more about it than one."""
    if not matches or homography is None:
        return []
    mapped = cv.perspectiveTransform(start[:, None], homography)[:, 0]
    kept = []
    for i in np.flatnonzero(np.linalg.norm(mapped - end, axis=1) <= 3):
        if all(np.linalg.norm(p[i] - p[kept], axis=1).min(initial=4) >= 4 for p in (start, end)):
            kept.append(i)
    return [matches[i] for i in kept]


def corner_error(a, b, image):
    """How far apart two homographies map the corners of an image, on average; in pixels."""
    bottom, right = np.array(image.shape, np.float32) - 1
    corners = np.array([[[0, 0]], [[right, 0]], [[right, bottom]], [[0, bottom]]], np.float32)
    difference = cv.perspectiveTransform(corners, a) - cv.perspectiveTransform(corners, b)
    return np.linalg.norm(difference, axis=2).mean()


def detect_and_match(name, detector, images, known):
    features = [detector.detectAndCompute(image, None) for image in images]
    if len(images) < 2:
        return Result(name, detector, features, [], None)
    matches = match_features(*features, detector.defaultNorm())
    start = np.array([features[0][0][m.queryIdx].pt for m in matches], np.float32)
    end = np.array([features[1][0][m.trainIdx].pt for m in matches], np.float32)
    estimate = None
    if len(matches) >= 4:
        estimate = cv.findHomography(start, end, cv.USAC_MAGSAC, 3, maxIters=10000, confidence=0.9999)[0]
    homography = estimate if known is None else known
    error = None if estimate is None else corner_error(estimate, homography, images[0])
    return Result(name, detector, features, distinct_correct(matches, start, end, homography), error)


def median_times(detectors, image, repeats=31):
    """Median times of detectAndCompute in ms. The detectors take turns, so that other load slows all of them."""
    times = [[] for _ in detectors]
    for _ in range(repeats):
        for i, detector in enumerate(detectors):
            start = cv.getTickCount()
            detector.detectAndCompute(image, None)
            times[i].append(1e3 * (cv.getTickCount() - start) / cv.getTickFrequency())
    return [statistics.median(t) for t in times]


def fast_threshold(detector, image):
    """The FAST threshold that a detector takes for an image: AdaptiveQuadtreeORB's is equation (7), limited."""
    if not isinstance(detector, aqorb.AdaptiveQuadtreeORB):
        return detector.getFastThreshold()
    return min(max(round(aqorb.adaptiveFastThreshold(image)), 1), 254)


def occupied(keypoints, image):
    return '{:.0f} %'.format(100 * aqorb.distributionOccupancy(keypoints, image.shape[::-1], (16, 12)))


def column(images, known, result, time, orb_time):
    """A detector's part of the table: label and value of each row."""
    yield '', result.name
    for i, (image, (keypoints, _)) in enumerate(zip(images, result.features)):
        yield 'image {}: keypoints'.format(i + 1), len(keypoints)
        yield '  FAST threshold (iniT)', fast_threshold(result.detector, image)
        u = aqorb.distributionUniformity(keypoints, image.shape[::-1])
        yield '  uniformity (less is more uniform)', '{:.1f}'.format(u)
        yield '  occupied cells of a 16x12 grid', occupied(keypoints, image)
    if len(images) == 2:
        yield 'distinct {} matches'.format(reference(known)), len(result.matches)
        matched = [result.features[0][0][m.queryIdx] for m in result.matches]
        yield '  cells of image 1 that hold one', occupied(matched, images[0])
    if known is not None:
        error = result.homography_error
        yield 'error of the estimated homography', 'none' if error is None else '{:.2f} px'.format(error)
    yield 'time for image 1', '{:.2f} ms'.format(time)
    yield "  as a share of cv.ORB's", '{:.2f}'.format(time / orb_time)


def reference(known):
    return 'consistent' if known is None else 'correct'


def print_table(images, known, results):
    times = median_times([r.detector for r in results], images[0])
    columns = [column(images, known, r, t, times[0]) for r, t in zip(results, times)]
    for (label, orb), (_, ours) in zip(*columns):
        print('{:36} {:>10} {:>20}'.format(label, orb, ours))
    print('Time: detectAndCompute, median of calls that take turns, {} thread(s).'.format(cv.getNumThreads()))


def labelled(picture, text):
    """The picture with a line of text above it."""
    result = cv.copyMakeBorder(picture, 36, 0, 0, 0, cv.BORDER_CONSTANT, value=(255, 255, 255))
    return cv.putText(result, text, (10, 25), cv.FONT_HERSHEY_SIMPLEX, 0.75, (0, 0, 0), 1, cv.LINE_AA)


def keypoint_picture(images, result):
    keypoints = result.features[0][0]
    picture = cv.drawKeypoints(images[0], keypoints, None, (0, 255, 255))
    return labelled(picture, '{}: {} keypoints'.format(result.name, len(keypoints)))


def match_picture(images, known, result):
    dark = [cv.convertScaleAbs(image, alpha=0.6) for image in images]  # so that the lines stand out
    picture = cv.drawMatches(dark[0], result.features[0][0], dark[1], result.features[1][0], result.matches, None,
                             matchColor=(0, 255, 255), flags=cv.DrawMatchesFlags_NOT_DRAW_SINGLE_POINTS)
    return labelled(picture, '{}: {} distinct {} matches'.format(result.name, len(result.matches),
                                                                 reference(known)))


def save(folder, name, picture):
    path = os.path.join(folder, name)
    if not cv.imwrite(path, picture, [cv.IMWRITE_JPEG_QUALITY, 85]):
        raise Failure(3, path + ': cannot be written')
    print('Picture:', os.path.realpath(path))


def compare(arguments, names, suffix=''):
    images = [read_image(name) for name in names]
    known = read_homography(arguments.homography) if arguments.homography else None
    detectors = [('cv.ORB', cv.ORB_create(arguments.nfeatures)),
                 ('AdaptiveQuadtreeORB', aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures))]
    results = [detect_and_match(name, detector, images, known) for name, detector in detectors]
    print_table(images, known, results)
    save(arguments.out, 'aqorb_keypoints' + suffix + '.jpg',
         cv.hconcat([keypoint_picture(images, r) for r in results]))
    if len(images) == 2:
        save(arguments.out, 'aqorb_matches.jpg',
             cv.vconcat([match_picture(images, known, r) for r in results]))


def run():
    arguments = parse_arguments()
    if len(arguments.images) <= 2:
        compare(arguments, arguments.images)
        return
    for i, name in enumerate(arguments.images):
        print('\n' * (i > 0) + name)
        compare(arguments, [name], str(i + 1))


def main():
    try:
        run()
    except Failure as failure:
        print('aqorb_demo.py:', failure, file=sys.stderr)
        return failure.exit_code
    except cv.error as error:
        print('aqorb_demo.py:', error, file=sys.stderr)
        return 4
    return 0


if __name__ == '__main__':
    sys.exit(main())
