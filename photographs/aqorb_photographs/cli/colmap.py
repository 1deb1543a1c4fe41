# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb colmap: features and matches in a database of COLMAP."""

from aqorb_photographs.cli import options
from aqorb_photographs import Refused


def add(commands):
    parser = options.add_command(
        commands, 'colmap', run, 'write features and matches into a database of COLMAP',
        'Cameras, focal lengths and places are those of COLMAP\'s own import of the images.')
    parser.add_argument('features', metavar='FEATURES', help='folder of aqorb extract')
    parser.add_argument('matches', nargs='?', metavar='MATCHES', help='folder of aqorb match')
    parser.add_argument('--images', required=True, metavar='FOLDER', help='to which the names of images are relative')
    parser.add_argument('--database', required=True, metavar='FILE', help='new file, such as scene.db')
    parser.add_argument('--append', action='store_true', help='add what is not in a database that exists')
    parser.add_argument('--refine', action='store_true',
                        help='refine positions by tracks, against one image each, for an exact bundle adjustment')
    parser.add_argument('--camera-mode', choices=['AUTO', 'SINGLE', 'PER_FOLDER', 'PER_IMAGE'], default='AUTO',
                        help='which images have a camera in common; as their EXIF data say by default')
    parser.add_argument('--camera-model', metavar='MODEL', help='of COLMAP (SIMPLE_RADIAL)')
    parser.add_argument('--camera-params', metavar='NUMBERS', help='of the model, with commas between them')
    parser.add_argument('--default-focal-length-factor', type=float, metavar='X',
                        help='times the longer side, where no focal length is known (1.2)')
    parser.add_argument('--strict', action='store_true', help='exit with 1 if an image was left out')


def run(given):
    import pycolmap  # noqa: F401 # said now, and here, if it is missing
    from aqorb_photographs import colmap
    names = 'camera_model', 'camera_params', 'default_focal_length_factor'
    reader = {name: getattr(given, name) for name in names if getattr(given, name) is not None}
    for folder in filter(None, (given.features, given.matches)):
        options.store_at(folder)
    images, pairs, left_out, needs = colmap.export(given.features, given.matches, given.images, given.database,
                                                   given.camera_mode, reader, given.append, given.refine)
    options.list_failures(left_out, f'{options.count_of(len(left_out), "image")} left out')
    options.say(given, f'{given.database}: {options.count_of(images, "new image")}, '
                f'{options.count_of(pairs, "new pair")}' + (f'; {needs}' if needs else ''))
    if not images + pairs and not given.append:
        raise Refused('COLMAP read none of the images')
    return int(bool(given.strict and left_out))
