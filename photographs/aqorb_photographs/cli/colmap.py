# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb colmap: features and matches in a database of COLMAP."""

import argparse

from aqorb_photographs.cli import options
from aqorb_photographs import InputError


def add(commands):
    parser = options.add_command(
        commands, 'colmap', run, 'write features and matches to a COLMAP database',
        'Cameras, focal lengths and places come from COLMAP\'s own import of the images.')
    parser.add_argument('features', metavar='FEATURES', help='folder of aqorb extract')
    parser.add_argument('matches', nargs='?', metavar='MATCHES', help='folder of aqorb match')
    parser.add_argument('--images', required=True, metavar='FOLDER', help='root folder of the names of images')
    parser.add_argument('--database', required=True, metavar='FILE', help='new file, such as scene.db')
    parser.add_argument('--refine', action=argparse.BooleanOptionalAction, default=True,
                        help='write tracks of aligned positions, for an exact bundle adjustment (the default)')
    parser.add_argument('--min-inliers', type=options.positive, default=40, metavar='N',
                        help='aligned positions of a pair that must agree on one geometry (%(default)s)')
    parser.add_argument('--part-size', type=options.positive, default=1024, metavar='N',
                        help='pairs after which aligned positions are saved (%(default)s)')
    parser.add_argument('--camera-mode', choices=['AUTO', 'SINGLE', 'PER_FOLDER', 'PER_IMAGE'], default='AUTO',
                        help='which images share a camera; by default their EXIF data decide')
    parser.add_argument('--camera-model', metavar='MODEL', help='camera model of COLMAP (SIMPLE_RADIAL)')
    parser.add_argument('--camera-params', metavar='NUMBERS', help='parameters of the model, separated by commas')
    parser.add_argument('--default-focal-length-factor', type=float, metavar='X',
                        help='unknown focal length in units of the longer side (1.2)')
    parser.add_argument('--strict', action='store_true', help='exit with 1 if an image was left out')
    options.add_threads(parser)


def run(given):
    import pycolmap  # noqa: F401 # fails here, at once, if it is missing
    from aqorb_photographs import colmap
    names = 'camera_model', 'camera_params', 'default_focal_length_factor'
    reader = {name: getattr(given, name) for name in names if getattr(given, name) is not None}
    for folder in filter(None, (given.features, given.matches)):
        options.store_at(folder)
    images, pairs, left_out, needs = colmap.export(
        given.features, given.matches, given.images, given.database, given.camera_mode, reader, given.refine,
        given.min_inliers, given.threads, given.part_size,
        lambda label, total: options.progress(given, total, 'pair', label).update)
    options.list_failures(left_out, f'{options.count_of(len(left_out), "image")} left out')
    options.say(given, f'{given.database}: {options.count_of(images, "image")}, '
                f'{options.count_of(pairs, "pair")}' + (f'; {needs}' if needs else ''))
    if not images:
        raise InputError('COLMAP read none of the images')
    return int(bool(given.strict and left_out))
