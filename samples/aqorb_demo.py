#!/usr/bin/env python3

# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Compares AdaptiveQuadtreeORB with cv.ORB: prints a table and writes the pictures aqorb_keypoints.jpg and, for two
images, aqorb_matches.jpg. More than two images are taken one by one (aqorb_keypoints1.jpg, ...). Without images it
takes three pairs of OpenCV's samples: one where all of the scene is in both images, one with a small object, and one
from two sides."""

import statistics
from collections import namedtuple

# Imported first, because it says what is missing if an import fails.
from program import (BAD_ARGUMENTS, FAILED, Failure, Program, aqorb, find_file, path_in, read_image, run,
                     write_picture)

import cv2 as cv
import numpy as np

from drawing import captioned, keypoint_picture, match_picture, size_of

# What the program shows without images.
PAIRS = [
    ('rubberwhale1.png', 'rubberwhale2.png', '',
     """1. AdaptiveQuadtreeORB wins: two frames of a video, with something to see everywhere.
How to read it: cv.ORB's keypoints crowd where the contrast is highest, several on one corner;
AdaptiveQuadtreeORB's cover the image. So more of them match at distinct places, and these
places fill more of the image's cells."""),
    ('box.png', 'box_in_scene.png', '',
     """2. cv.ORB has more matches: a small box, and the same box among other things.
How to read it: only the box is in both images. AdaptiveQuadtreeORB spreads its keypoints over
the whole scene, so fewer of them lie on the box, and fewer match. The matches cover as much of it.
If you look for a small object, see StrengthWeight in the tutorial."""),
    ('graf1.png', 'graf3.png', 'H1to3p.xml',
     """3. AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them.
How to read it: AdaptiveQuadtreeORB has more correct matches, on more places of the wall. The error
says by how many pixels the homography is off that is estimated from each detector's matches.""")]

LEGEND = """Distinct: matches at least 4 pixels from each other. Consistent: within 3 pixels of the
homography estimated from the detector's matches; correct: of the known one."""

# features: keypoints and descriptors of each image; matches: distinct, and in agreement with the homography;
# homography_error: in pixels, or None
Result = namedtuple('Result', 'name detector features matches homography_error')


def parse_arguments():
    program = Program(__doc__, '[IMAGE1 [IMAGE2]] or IMAGE IMAGE IMAGE ...', 0, 100000,
                      'aqorb_demo.py --nfeatures=500 --out=pictures photograph1.jpg photograph2.jpg')
    program.add_text('homography', '',
                     'XML, YAML or JSON file with the 3x3 homography from image 1 to image 2; without it those '
                     'matches are counted that agree with the homography estimated from them')
    program.add_feature_count()
    program.add_text('out', '.', 'existing folder for the pictures')
    arguments = program.parse()
    path_in(arguments.out, '')
    if arguments.homography and len(arguments.files) != 2:
        raise Failure(BAD_ARGUMENTS, '--homography={}: is accepted with two images'.format(arguments.homography))
    return arguments


def read_homography(name):
    """The first matrix in the file, whatever its name."""
    path = find_file(name)
    homography = None
    try:
        storage = cv.FileStorage(path, cv.FILE_STORAGE_READ)
        homography = storage.getFirstTopLevelNode().mat()
    except (cv.error, SystemError):  # neither XML, YAML nor JSON, or no matrix
        pass
    if homography is None or homography.shape != (3, 3):
        raise Failure(FAILED, '--homography={}: an XML, YAML or JSON file with a 3x3 matrix is accepted'.format(name))
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
    return '{:.0f} %'.format(100 * aqorb.distributionOccupancy(keypoints, size_of(image), (16, 12)))


def column(images, known, result, time, orb_time):
    """A detector's part of the table: label and value of each row. What is said of each image is in one row."""
    pairs = [(image, keypoints) for image, (keypoints, _) in zip(images, result.features)]
    uniformity = [aqorb.distributionUniformity(keypoints, size_of(image)) for image, keypoints in pairs]
    yield 'image 1, image 2' if len(images) == 2 else '', result.name
    yield 'keypoints', ', '.join(str(len(keypoints)) for _, keypoints in pairs)
    yield 'FAST threshold (iniT)', ', '.join(str(fast_threshold(result.detector, image)) for image in images)
    yield 'uniformity (less is more uniform)', ', '.join('{:.1f}'.format(u) for u in uniformity)
    yield 'occupied cells of a 16x12 grid', ', '.join(occupied(keypoints, image) for image, keypoints in pairs)
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
    for i, ((label, orb), (_, ours)) in enumerate(zip(*columns)):
        print('{:34} {:>13} {:>20}'.format(label, orb, ours))
        if i == 0:
            print('-' * 69)


def save_pictures(images, known, results, folder, suffix):
    keypoints, matches = [], []
    for result in results:
        features = [f[0] for f in result.features]
        keypoints.append(captioned(keypoint_picture(images[0], features[0]),
                                   '{}: {} keypoints'.format(result.name, len(features[0]))))
        if len(images) == 2:
            text = '{}: {} distinct {} matches'.format(result.name, len(result.matches), reference(known))
            matches.append(captioned(match_picture(images[0], features[0], images[1], features[1], result.matches),
                                     text))
    write_picture(path_in(folder, 'aqorb_keypoints' + suffix + '.jpg'), cv.hconcat(keypoints))
    if matches:
        write_picture(path_in(folder, 'aqorb_matches' + suffix + '.jpg'), cv.vconcat(matches))


def compare(arguments, names, homography='', suffix=''):
    images = [read_image(name) for name in names]
    known = read_homography(homography) if homography else None
    detectors = [('cv.ORB', cv.ORB_create(arguments.nfeatures)),
                 ('AdaptiveQuadtreeORB', aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures))]
    results = [detect_and_match(name, detector, images, known) for name, detector in detectors]
    print_table(images, known, results)
    save_pictures(images, known, results, arguments.out, suffix)


def main():
    arguments = parse_arguments()
    if not arguments.files:
        for i, (image1, image2, homography, text) in enumerate(PAIRS, 1):
            print(text, '{}, {}'.format(image1, image2), '', sep='\n')
            compare(arguments, [image1, image2], homography, str(i))
            print()
    elif len(arguments.files) <= 2:
        compare(arguments, arguments.files, arguments.homography)
    else:
        for i, name in enumerate(arguments.files, 1):
            print(name)
            compare(arguments, [name], suffix=str(i))
            print()
    print(LEGEND)
    print('Time: detectAndCompute, median of calls that take turns, {} thread(s).'.format(cv.getNumThreads()))


if __name__ == '__main__':
    run(main)
