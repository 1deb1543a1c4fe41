# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb draw: a picture of the matches of two images."""

import json
import os
import sys

import numpy as np
from PIL import Image, ImageDraw

import aqorb
from aqorb_photographs.cli import options
from aqorb_photographs import images

LINES = 100  # more would hide the pictures


def add(commands):
    parser = options.add_command(commands, 'draw', run, 'draw the matches of two images',
                                 'Matches two images, finds more matches near these, and draws those that agree on one '
                                 'geometry. Says whether the images probably show the same thing.')
    parser.add_argument('first', metavar='A')
    parser.add_argument('second', metavar='B')
    parser.add_argument('--out', default='matches.png', metavar='FILE', help='%(default)s by default')
    parser.add_argument('--ratio', type=float, default=.8, help='%(default)s by default')
    parser.add_argument('--all', action='store_true', help=f'draw a line for each match, not for {LINES} of them, and '
                        'the matches that disagree in red')
    parser.add_argument('--outline', action='store_true', help='draw where a flat A lies in B')
    parser.add_argument('--json', action='store_true', help='print the result for programs')
    parser.add_argument('--overwrite', action='store_true', help='replace an existing file')
    options.add_reading(parser)


def run(given):
    from aqorb_photographs import places
    options.new_file(given.out, given.overwrite, suffixes())
    detector = options.detector_of(given)
    pictures = [images.read_file(path, options.reading_of(given)) for path in (given.first, given.second)]
    features = [detector.detectAndComputeArrays(picture.pixels) for picture in pictures]
    ends = places.grow([picture.pixels for picture in pictures], features, given.ratio)
    found = places.agreement(*ends)
    agree = np.zeros(len(ends[0]), bool)
    agree[found.inliers] = True
    frame = outline(pictures[0].pixels.shape, found.homography) if given.outline and found.is_same else None
    save(given.out, [picture._replace(size=picture.pixels.shape[::-1]) for picture in pictures],
         [points[agree] for points in ends], [points[~agree & given.all] for points in ends],
         None if given.all else LINES, frame)
    counts = (f'{agree.sum()} of {options.count_of(len(agree), "match", "es")} agree, '
              f'and {options.count_of(found.places, "place")} lie in one plane')
    if given.json:
        matrices = {name: None if matrix is None else matrix.tolist()
                    for name, matrix in (('homography', found.homography), ('fundamental_matrix', found.fundamental))}
        print(json.dumps({'same': found.is_same, 'places': found.places, 'matches': np.hstack(ends)[agree].tolist(),
                          'disagreeing': int((~agree).sum()), **matrices}))
    elif found.is_same:
        options.say(given, f'{given.out}: the images probably show the same thing: {counts}')
    else:
        print(f'{given.out}: the images probably do not show the same thing: {counts}, fewer than {places.MIN_PLACES}',
              file=sys.stderr)
    return int(not agree.any())


def suffixes():
    """Returns the suffixes of pictures that Pillow can write."""
    Image.init()
    return [suffix for suffix in ('.png', '.jpg', '.jpeg', '.webp', '.tif', '.tiff', '.bmp')
            if Image.EXTENSION.get(suffix) in Image.SAVE]


def outline(shape, homography):
    """Returns the corners of a picture seen through a homography."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * np.subtract(shape[::-1], 1)
    seen = np.column_stack([corners, np.ones(4)]) @ homography.T
    return seen[:, :2] / seen[:, 2:]


def spread(points, size, number):
    """Returns which points to keep, of which number lie evenly in an image of this size."""
    keypoints = np.zeros(len(points), aqorb.keypoint_dtype)
    keypoints['pt'], keypoints['class_id'] = points, np.arange(len(points))
    return aqorb.retainUniform(keypoints, size, number)['class_id']


def save(out, pictures, ends, others=((), ()), number=LINES, frame=None):
    """Draws two pictures side by side, with lines between matches. ends are the positions of matches in both pictures,
    in pixels of the pictures' sizes. A number of them has a line, and the others have a dot in each picture, or all have
    a line (None). others are the positions of matches to draw in red. frame is an outline in picture 2."""
    width = pictures[0].pixels.shape[1]
    heights = [len(picture.pixels) for picture in pictures]
    drawn = Image.new('RGB', (width + pictures[1].pixels.shape[1], max(heights)))
    for picture, left in zip(pictures, (0, width)):
        drawn.paste(Image.fromarray(picture.pixels), (left, 0))
    canvas = ImageDraw.Draw(drawn)
    thickness = max(1, round(drawn.width / 1600))  # of lines, which a large picture hides if they are thin
    scaled = [np.vstack([np.reshape(red, (-1, 2)), points]) * np.divide(picture.pixels.shape[::-1], picture.size)
              for points, red, picture in zip(ends, others, pictures)]
    lines = np.hstack([scaled[0], scaled[1] + [width, 0]])
    has_line = np.ones(len(lines), bool)
    if number is not None and len(lines) > number:
        has_line = np.isin(np.arange(len(lines)), spread(scaled[0], pictures[0].pixels.shape[::-1], number))
    for i in np.argsort(has_line, kind='stable'):  # lines above dots
        line, agreeing = lines[i], i - len(others[0])
        colour = 'red' if agreeing < 0 else f'hsl({60 + 240 * agreeing // len(ends[0])}, 90%, 60%)'
        radius = thickness * (3 if has_line[i] else 1)
        if has_line[i]:
            canvas.line(line.tolist(), colour, thickness)
        for x, y in line.reshape(2, 2):
            canvas.ellipse((x - radius, y - radius, x + radius, y + radius), outline=colour, width=thickness)
    if frame is not None:
        corners = frame * np.divide(pictures[1].pixels.shape[::-1], pictures[1].size) + [width, 0]
        canvas.line(np.vstack([corners, corners[:2]]).ravel().tolist(), 'lime', 3 * thickness, 'curve')
    from aqorb_photographs import store
    with store.replacing(out) as file:
        drawn.save(file, Image.EXTENSION[os.path.splitext(out)[1].lower()])
