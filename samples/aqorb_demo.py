#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Compares AdaptiveQuadtreeORB with cv.ORB: prints a table and writes the pictures aqorb_keypoints.jpg and, for two
images, aqorb_matches.jpg. More than two images are taken one by one (aqorb_keypoints1.jpg, ...). Without images it
takes three pairs of OpenCV's samples: one where all of the scene is in both images, one with a small object, and one
from two sides."""

import argparse
import os
import statistics
import sys
from collections import namedtuple

import cv2 as cv
import numpy as np

try:
    import aqorb
except ImportError:  # a cv2 that was built with the module
    from cv2 import aqorb

YELLOW = (0, 255, 255)

# What the program shows without images.
PAIRS = [
    ('rubberwhale1.png', 'rubberwhale2.png', '',
     """1. AdaptiveQuadtreeORB wins: two frames of a video, with something to see everywhere.
How to read it: cv.ORB's keypoints crowd where the contrast is highest, several on one corner;
AdaptiveQuadtreeORB's cover the image. So more of them match at distinct places, and these
places fill more of the image's cells."""),
    ('box.png', 'box_in_scene.png', '',
     """2. cv.ORB has more matches in all: a small box, and the same box among other things.
How to read it: only the box is in both images. AdaptiveQuadtreeORB spreads its keypoints over
the whole scene, so fewer of them lie on the box. If you look for a small object, see StrengthWeight
in the tutorial."""),
    ('graf1.png', 'graf3.png', 'H1to3p.xml',
     """3. AdaptiveQuadtreeORB wins: a painted wall from two sides, with a known homography between them.
How to read it: AdaptiveQuadtreeORB has more correct matches, on more places of the wall. The error
says by how many pixels the homography is off that is estimated from each detector's matches.""")]

LEGEND = """Matches are mutual nearest neighbours. Consistent: within 3 pixels of the homography estimated
from the detector's matches; correct: of the known one. Distinct: at least 4 pixels from every
better one in both images. cv.ORB often has more in all, because it finds a strong corner on
several levels and each of these counts. FAST threshold: cv.ORB's is fixed, AdaptiveQuadtreeORB's
follows the contrast of the image."""

# features: keypoints and descriptors of each image; matches: distinct, and in agreement with the homography;
# agreeing, matched: how many agree with it, whether distinct or not, and how many there are; homography_error: in
# pixels, or None
Result = namedtuple('Result', 'name detector features matches agreeing matched homography_error')


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--homography', help='XML, YAML or JSON file with the 3x3 homography from image 1 to image 2; '
                        'without it those matches are counted that agree with the homography estimated from them')
    parser.add_argument('--nfeatures', type=int, default=1000)
    parser.add_argument('--out', default='.', help='existing folder for the pictures')
    parser.add_argument('images', nargs='*', metavar='IMAGE')
    return parser.parse_args()


def read_image(name):
    image = cv.imread(cv.samples.findFile(name, False), cv.IMREAD_GRAYSCALE)
    if image is None:
        sys.exit(name + ': cannot be read as an image'
                 " (OpenCV's: export OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))")
    return image


def read_homography(name):
    """The first matrix in the file, whatever its name."""
    storage = cv.FileStorage(cv.samples.findFile(name), cv.FILE_STORAGE_READ)  # must outlive its nodes
    homography = storage.getFirstTopLevelNode().mat()
    if homography is None or homography.shape != (3, 3):
        sys.exit(name + ': has no 3x3 matrix')
    return homography.astype(float)


def write_picture(folder, name, picture):
    path = os.path.join(folder, name)
    if not cv.imwrite(path, picture, [cv.IMWRITE_JPEG_QUALITY, 85]):
        sys.exit(path + ': cannot be written; an existing folder is accepted')
    print('Picture:', path)


def size_of(image):
    return image.shape[1], image.shape[0]


def drawing_scale(size):
    """How much larger circles and letters are than on a picture of 800x640 pixels; at least 1."""
    return max(1, (size[0] * size[1] / (800 * 640)) ** 0.5)


def line_width(size):
    return round(drawing_scale(size))


def enlargement(size):
    """By which factor a small image is enlarged, so that circles and a caption find room on it."""
    return max(1, (400 + size[0] - 1) // size[0])


def canvas(image, factor):
    """The image in colour, enlarged."""
    picture = cv.resize(image, None, fx=factor, fy=factor, interpolation=cv.INTER_NEAREST)
    return picture if picture.ndim == 3 else cv.cvtColor(picture, cv.COLOR_GRAY2BGR)


def enlarged(position, factor):
    """Where a position lies on the enlarged image. The centre of a pixel has whole numbers on both."""
    return (np.array(position) + 0.5) * factor - 0.5


def draw_circle(picture, centre, radius, width):
    """A circle at a fraction of a pixel."""
    bits = 4  # of the fraction
    cv.circle(picture, np.intp(np.round(centre * (1 << bits))), round(radius * (1 << bits)), YELLOW, width, cv.LINE_AA,
              bits)


def keypoint_picture(image, keypoints):
    """The image with a circle at each keypoint."""
    factor = enlargement(size_of(image))
    picture = canvas(image, factor)
    scale = drawing_scale(size_of(picture))
    for keypoint in keypoints:
        draw_circle(picture, enlarged(keypoint.pt, factor), 3 * scale, round(scale))
    return picture


def match_picture(image1, keypoints1, image2, keypoints2, matches):
    """Two images side by side, darker, with a line for each match."""
    factor = min(enlargement(size_of(image)) for image in (image1, image2))
    left, right = [canvas(cv.convertScaleAbs(image, alpha=0.6), factor) for image in (image1, image2)]
    height = max(left.shape[0], right.shape[0])
    parts = [cv.copyMakeBorder(image, 0, height - image.shape[0], 0, 0, cv.BORDER_CONSTANT, value=(255, 255, 255))
             for image in (left, right)]
    picture = cv.hconcat(parts)
    size = max(left.shape[1], right.shape[1]), height
    shift = np.array([left.shape[1], 0])
    ends = [(enlarged(keypoints1[match.queryIdx].pt, factor), enlarged(keypoints2[match.trainIdx].pt, factor) + shift)
            for match in matches]
    # Hundreds of lines would hide the images. So they are translucent, and of many matches only some have one. All have
    # circles at their ends.
    lines = picture.copy()
    for start, end in ends[::max(1, -(-len(ends) // 100))]:
        cv.line(lines, np.intp(np.round(start)), np.intp(np.round(end)), YELLOW, line_width(size), cv.LINE_AA)
    picture = cv.addWeighted(lines, 0.4, picture, 0.6, 0)
    for pair in ends:
        for position in pair:
            draw_circle(picture, position, 3 * drawing_scale(size), line_width(size))
    return picture


def captioned(picture, text):
    """The picture with a line of text above it, in letters that fit its width."""
    font = cv.FONT_HERSHEY_SIMPLEX
    largest = 0.75 * drawing_scale(size_of(picture))
    (width, _), _ = cv.getTextSize(text, font, 1, 1)
    scale = min(largest, 0.94 * picture.shape[1] / width)
    height, thickness = round(48 * largest), max(1, round(1.3 * scale))
    result = cv.copyMakeBorder(picture, height, 0, 0, 0, cv.BORDER_CONSTANT, value=(255, 255, 255))
    origin = round(0.02 * picture.shape[1]), height - round(15 * largest)
    return cv.putText(result, text, origin, font, scale, (0, 0, 0), thickness, cv.LINE_AA)


def match_features(a, b, norm):
    """Mutual nearest neighbours, those of cv.BFMatcher(norm, crossCheck=True), the best first."""
    if a[1] is None or b[1] is None:
        return []
    return sorted(aqorb.HammingMatcher(norm, crossCheck=True).match(a[1], b[1]), key=lambda m: m.distance)


def correct(start, end, homography):
    """The indices of the matches within 3 pixels of the homography."""
    if not len(start) or homography is None:
        return []
    mapped = cv.perspectiveTransform(start[:, None], homography)[:, 0]
    return np.flatnonzero(np.linalg.norm(mapped - end, axis=1) <= 3)


def distinct(indices, start, end):
    """Those of them that are at least 4 pixels away from every better one in both images: several keypoints on one
    corner of the scene say no more about it than one."""
    kept = []
    for i in indices:
        if all(np.linalg.norm(p[i] - p[kept], axis=1).min(initial=4) >= 4 for p in (start, end)):
            kept.append(i)
    return kept


def corner_error(a, b, image):
    """How far apart two homographies map the corners of an image, on average; in pixels."""
    bottom, right = np.array(image.shape, np.float32) - 1
    corners = np.array([[[0, 0]], [[right, 0]], [[right, bottom]], [[0, bottom]]], np.float32)
    difference = cv.perspectiveTransform(corners, a) - cv.perspectiveTransform(corners, b)
    return np.linalg.norm(difference, axis=2).mean()


def detect_and_match(name, detector, images, known):
    features = [detector.detectAndCompute(image, None) for image in images]
    if len(images) < 2:
        return Result(name, detector, features, [], 0, 0, None)
    matches = match_features(*features, detector.defaultNorm())
    start = np.array([features[0][0][m.queryIdx].pt for m in matches], np.float32)
    end = np.array([features[1][0][m.trainIdx].pt for m in matches], np.float32)
    estimate = None
    if len(matches) >= 4:
        estimate = cv.findHomography(start, end, cv.USAC_MAGSAC, 3, maxIters=10000, confidence=0.9999)[0]
    homography = estimate if known is None else known
    error = None if estimate is None else corner_error(estimate, homography, images[0])
    agreeing = correct(start, end, homography)
    return Result(name, detector, features, [matches[i] for i in distinct(agreeing, start, end)], len(agreeing),
                  len(matches), error)


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
    yield 'FAST threshold', ', '.join(str(fast_threshold(result.detector, image)) for image in images)
    yield 'uniformity (less is more uniform)', ', '.join('{:.1f}'.format(u) for u in uniformity)
    yield 'occupied cells of a 16x12 grid', ', '.join(occupied(keypoints, image) for image, keypoints in pairs)
    if len(images) == 2:
        yield 'distinct {} matches'.format(reference(known)), len(result.matches)
        matched = [result.features[0][0][m.queryIdx] for m in result.matches]
        yield '  cells of image 1 that hold one', occupied(matched, images[0])
        yield '{} matches in all'.format(reference(known)), '{} of {}'.format(result.agreeing, result.matched)
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
    write_picture(folder, 'aqorb_keypoints' + suffix + '.jpg', cv.hconcat(keypoints))
    if matches:
        write_picture(folder, 'aqorb_matches' + suffix + '.jpg', cv.vconcat(matches))


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
    if not arguments.images:
        for i, (image1, image2, homography, text) in enumerate(PAIRS, 1):
            print(text, '{}, {}'.format(image1, image2), '', sep='\n')
            compare(arguments, [image1, image2], homography, str(i))
            print()
    elif len(arguments.images) <= 2:
        compare(arguments, arguments.images, arguments.homography)
    else:
        for i, name in enumerate(arguments.images, 1):
            print(name)
            compare(arguments, [name], suffix=str(i))
            print()
    print(LEGEND)
    print('Time: detectAndCompute, median of calls that take turns, {} thread(s).'.format(cv.getNumThreads()))


if __name__ == '__main__':
    main()
