# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb draw: a picture of the matches of two images."""

import os

import aqorb
from aqorb import _stop, command


def add(commands):
    parser = commands.add_parser('draw', help='draw the matches of two images',
                                 description='Matches two images by a ratio test and draws what was found.')
    parser.add_argument('images', nargs=2, metavar=('A', 'B'))
    parser.add_argument('--out', default='matches.png', metavar='FILE', help='%(default)s by default')
    parser.add_argument('--ratio', type=float, default=.8, help='%(default)s by default')
    command.add_image_options(parser)
    command.add_overwrite(parser)
    parser.set_defaults(run=run)


def run(options):
    from aqorb import files
    if os.path.exists(options.out) and not options.overwrite:
        raise files.Refused(f'{options.out} exists; --overwrite replaces it')
    detector = aqorb.AdaptiveQuadtreeORB_create(options.num_features)
    images = [read(path, options.max_size, not options.ignore_orientation) for path in options.images]
    (keypoints1, descriptors1), (keypoints2, descriptors2) = [
        detector.detectAndComputeArrays(image) for image, _ in images]
    pairs, _ = aqorb.matchArrays(descriptors1, descriptors2, options.ratio)
    ends = keypoints1['pt'][pairs[:, 0]], keypoints2['pt'][pairs[:, 1]]
    save(options.out, [(image, image.shape[::-1]) for image, _ in images], ends)
    print(f'{options.out}: {command.count_of(len(pairs), "match", "es")} of {len(keypoints1)} and {len(keypoints2)} features')


def read(path, max_size, orientation):
    """An image, reduced, and the width and height that it had before."""
    from aqorb import collection, files
    try:
        with command.open_file(b'', os.fsencode(path)) as file:
            return collection.read_image(file, max_size, orientation)
    except Exception as error:  # decoders raise errors of any kind
        raise files.Refused(f'{os.fsdecode(path)}: {error}') from error


def save(out, images, ends):
    """Draws two images side by side, with a line for each row of ends: the positions in both, in pixels of the sizes
    that come with the images."""
    import numpy as np
    from PIL import Image, ImageDraw
    (first, _), (second, _) = images
    width = first.shape[1]
    picture = Image.new('RGB', (width + second.shape[1], max(len(first), len(second))))
    for (image, _), left in zip(images, (0, width)):
        picture.paste(Image.fromarray(image), (left, 0))
    canvas = ImageDraw.Draw(picture)
    scaled = [points * np.divide(image.shape[::-1], size) for points, (image, size) in zip(ends, images)]
    lines = np.hstack([scaled[0], scaled[1] + [width, 0]])
    for i, line in enumerate(lines):
        colour = f'hsl({360 * i // len(lines)}, 90%, 60%)'
        canvas.line(line.tolist(), colour)
        for x, y in line.reshape(2, 2):
            canvas.ellipse((x - 3, y - 3, x + 3, y + 3), outline=colour)
    _stop.finish()
    picture.save(out)
