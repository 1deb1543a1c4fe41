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
    import numpy as np
    from PIL import Image, ImageDraw
    from aqorb import collection, files
    if os.path.exists(options.out) and not options.overwrite:
        raise files.Refused(f'{options.out} exists; --overwrite replaces it')
    detector = aqorb.AdaptiveQuadtreeORB_create(options.num_features)
    images = []
    for path in options.images:
        try:
            with command.open_file('', path) as file:
                images.append(collection.read_image(file, options.reader, options.max_size,
                                                    not options.ignore_orientation)[0])
        except Exception as error:  # decoders raise errors of any kind
            raise files.Refused(f'{path}: {error}') from error
    (keypoints1, descriptors1), (keypoints2, descriptors2) = map(detector.detectAndComputeArrays, images)
    pairs, _ = aqorb.matchArrays(descriptors1, descriptors2, options.ratio)
    width = images[0].shape[1]
    picture = Image.new('RGB', (width + images[1].shape[1], max(len(image) for image in images)))
    for image, left in zip(images, (0, width)):
        picture.paste(Image.fromarray(image), (left, 0))
    canvas = ImageDraw.Draw(picture)
    ends = np.hstack([keypoints1['pt'][pairs[:, 0]], keypoints2['pt'][pairs[:, 1]] + [width, 0]])
    for i, line in enumerate(ends):
        colour = f'hsl({360 * i // len(ends)}, 90%, 60%)'
        canvas.line(line.tolist(), colour)
        for x, y in line.reshape(2, 2):
            canvas.ellipse((x - 3, y - 3, x + 3, y + 3), outline=colour)
    _stop.finish()
    picture.save(options.out)
    print(f'{options.out}: {command.count_of(len(pairs), "match", "es")} of {len(keypoints1)} and {len(keypoints2)} features')
