# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb draw: a picture of the matches of two images."""

import os
import sys

import numpy as np
from PIL import Image, ImageDraw

import aqorb
from aqorb_photographs.cli import options
from aqorb_photographs import images


def add(commands):
    parser = options.add_command(commands, 'draw', run, 'draw the matches of two images',
                                 'Matches two images by a ratio test, finds more matches near these, and draws those '
                                 'that agree on one geometry.')
    parser.add_argument('first', metavar='A')
    parser.add_argument('second', metavar='B')
    parser.add_argument('--out', default='matches.png', metavar='FILE', help='%(default)s by default')
    parser.add_argument('--ratio', type=float, default=.8, help='%(default)s by default')
    parser.add_argument('--all', action='store_true', help='also draw the other matches, in red')
    parser.add_argument('--overwrite', action='store_true', help='replace an existing file')
    options.add_reading(parser)


def run(given):
    from aqorb_photographs import places
    options.new_file(given.out, given.overwrite, suffixes())
    detector = options.detector_of(given)
    pictures = [images.read_file(path, options.reading_of(given)) for path in (given.first, given.second)]
    (keypoints1, descriptors1), (keypoints2, descriptors2) = [
        detector.detectAndComputeArrays(picture.pixels) for picture in pictures]
    pairs, _ = aqorb.matchArrays(descriptors1, descriptors2, given.ratio)
    pairs, *ends, _ = aqorb.growMatchArrays(pictures[0].pixels, keypoints1, pictures[1].pixels, keypoints2, pairs)
    agree = np.zeros(len(pairs), bool)
    agree[places.verify(*ends)[0]] = True
    save(given.out, [picture._replace(size=picture.pixels.shape[::-1]) for picture in pictures],
         [points[agree] for points in ends], [points[~agree & given.all] for points in ends])
    options.say(given, f'{given.out}: {agree.sum()} of {options.count_of(len(pairs), "match", "es")} agree')
    if (agree & (pairs >= 0).all(1)).sum() < places.MIN_INLIERS:  # a grown match follows the one nearby
        print(f'aqorb: fewer than {places.MIN_INLIERS} agree: the images probably do not show the same place',
              file=sys.stderr)
    return int(not agree.any())


def suffixes():
    """Returns the suffixes of pictures that Pillow can write."""
    Image.init()
    return [suffix for suffix in ('.png', '.jpg', '.jpeg', '.webp', '.tif', '.tiff', '.bmp')
            if Image.EXTENSION.get(suffix) in Image.SAVE]


def save(out, pictures, ends, others=((), ())):
    """Draws two pictures side by side, with a line for each match. ends are the positions of matches in both
    pictures, in pixels of the pictures' sizes. others are the positions of matches to draw in red."""
    width = pictures[0].pixels.shape[1]
    heights = [len(picture.pixels) for picture in pictures]
    drawn = Image.new('RGB', (width + pictures[1].pixels.shape[1], max(heights)))
    for picture, left in zip(pictures, (0, width)):
        drawn.paste(Image.fromarray(picture.pixels), (left, 0))
    canvas = ImageDraw.Draw(drawn)
    scaled = [np.vstack([np.reshape(red, (-1, 2)), points]) * np.divide(picture.pixels.shape[::-1], picture.size)
              for points, red, picture in zip(ends, others, pictures)]
    for i, line in enumerate(np.hstack([scaled[0], scaled[1] + [width, 0]]), -len(others[0])):
        colour = 'red' if i < 0 else f'hsl({60 + 240 * i // len(ends[0])}, 90%, 60%)'
        canvas.line(line.tolist(), colour)
        for x, y in line.reshape(2, 2):
            canvas.ellipse((x - 3, y - 3, x + 3, y + 3), outline=colour)
    from aqorb_photographs import store
    with store.replacing(out) as file:
        drawn.save(file, Image.EXTENSION[os.path.splitext(out)[1].lower()])
