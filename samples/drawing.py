# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""How the samples draw keypoints, matches and captions: in proportion to the picture, the same as drawing.hpp. The
circles of cv.drawKeypoints and cv.drawMatches measure 3 pixels, which cannot be seen on a photograph of 12
megapixels."""

import cv2 as cv
import numpy as np

YELLOW, GREEN = (0, 255, 255), (0, 255, 0)


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


def draw_circle(picture, centre, radius, width, colour=YELLOW):
    """A circle at a fraction of a pixel."""
    bits = 4  # of the fraction
    cv.circle(picture, np.intp(np.round(centre * (1 << bits))), round(radius * (1 << bits)), colour, width, cv.LINE_AA,
              bits)


def keypoint_picture(image, keypoints):
    """The image with a circle at each keypoint."""
    factor = enlargement(size_of(image))
    picture = canvas(image, factor)
    scale = drawing_scale(size_of(picture))
    for keypoint in keypoints:
        draw_circle(picture, enlarged(keypoint.pt, factor), 3 * scale, round(scale))
    return picture


def match_picture(image1, keypoints1, image2, keypoints2, matches, area=None):
    """Two images side by side, darker, with a line for each match, and the outline of an area of the second where
    its corners are given."""
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
    # Hundreds of lines would hide the images, so the lines are translucent. The circles at their ends are not.
    lines = picture.copy()
    for start, end in ends:
        cv.line(lines, np.intp(np.round(start)), np.intp(np.round(end)), YELLOW, line_width(size), cv.LINE_AA)
    picture = cv.addWeighted(lines, 0.4, picture, 0.6, 0)
    for pair in ends:
        for position in pair:
            draw_circle(picture, position, 3 * drawing_scale(size), line_width(size))
    if area is not None:
        outline = np.int32(np.round(enlarged(area, factor) + shift))
        cv.polylines(picture, [outline], True, GREEN, 2 * line_width(size), cv.LINE_AA)
    return picture


def captioned(picture, text, colour=(0, 0, 0)):
    """The picture with a line of text above it, in letters that fit its width."""
    font = cv.FONT_HERSHEY_SIMPLEX
    largest = 0.75 * drawing_scale(size_of(picture))
    (width, _), _ = cv.getTextSize(text, font, 1, 1)
    scale = min(largest, 0.94 * picture.shape[1] / width)
    height, thickness = round(48 * largest), max(1, round(1.3 * scale))
    result = cv.copyMakeBorder(picture, height, 0, 0, 0, cv.BORDER_CONSTANT, value=(255, 255, 255))
    origin = round(0.02 * picture.shape[1]), height - round(15 * largest)
    return cv.putText(result, text, origin, font, scale, colour, thickness, cv.LINE_AA)
