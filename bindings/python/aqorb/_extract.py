# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb extract: the features of all images in a folder."""

import functools
import hashlib
import importlib.util
import os
import sys

import aqorb
from aqorb import command


def add(commands):
    parser = commands.add_parser('extract', help='detect the features of all images in a folder',
                                 description='Detects the features of all images in a folder. If it is stopped, the '
                                 'same command goes on where it was. Files that are no images are listed at the end.')
    parser.add_argument('folder', metavar='FOLDER')
    parser.add_argument('--out', required=True, metavar='FILE', help='.parquet, or .db for COLMAP')
    parser.add_argument('--recursive', action='store_true', help='with the folders in the folder')
    parser.add_argument('--part-size', type=command.positive, default=256, metavar='N',
                        help='images after which what is done is saved (%(default)s)')
    command.add_image_options(parser)
    command.add_threads(parser)
    command.add_overwrite(parser)
    parser.set_defaults(run=run)


def list_files(folder, recursive, out):
    """The files in a folder, as sorted paths relative to it, bytes; and the folders in it that cannot be listed, each
    with the reason. The file out and the folder beside it are left out."""
    found, failures = [], []
    folder, out = os.fsencode(folder), os.fsencode(os.path.realpath(out))
    beside, own = os.path.dirname(out), {os.path.basename(out), os.path.basename(out) + b'.partial'}

    def failed(error):
        if error.filename == folder:
            raise error
        failures.append((os.path.relpath(error.filename, folder), error.strerror))

    for parent, folders, names in os.walk(folder, onerror=failed):
        if os.path.realpath(parent) == beside:
            folders[:], names = set(folders) - own, set(names) - own
        paths = [os.path.relpath(os.path.join(parent, name), folder) for name in names]
        found += [path.replace(os.fsencode(os.sep), b'/') for path in paths]
        if not recursive:
            break
    return sorted(found), failures


def run(options):
    from aqorb import collection, files
    suffix = files.suffix_of(options.out)
    write = files.write_parquet if suffix == '.parquet' else files.write_database
    if suffix == '.db' and not importlib.util.find_spec('pycolmap'):  # said now rather than at the end
        raise ImportError("No module named 'pycolmap'")
    paths, unlisted = list_files(options.folder, options.recursive, options.out)
    if not paths:
        hint = '' if options.recursive else '; --recursive looks into the folders in it'
        raise files.Refused(f'{options.folder} has no files{hint}')
    detector = aqorb.AdaptiveQuadtreeORB_create(options.num_features)
    how = {'max_size': options.max_size, 'orientation': not options.ignore_orientation}
    metadata = dict(collection.description(detector, **how),
                    files=hashlib.sha256(b'\0'.join(paths)).hexdigest())
    aqorb.setNumThreads(1)  # the images are what is divided among threads

    def make_table(chunk, progress):
        return collection.extract(chunk, functools.partial(command.open_file, os.fsencode(options.folder)), detector,
                                  threads=options.threads, progress=progress, **how)

    failures = files.write_in_parts(options.out, paths, len(paths), 'image', options.part_size, metadata,
                                    options.overwrite, make_table, write)
    failures += [(os.fsdecode(path), reason) for path, reason in unlisted]
    print(f'{options.out}: {command.count_of(len(paths) + len(unlisted) - len(failures), "image")}')
    if failures:
        print(f'{command.count_of(len(failures), "file")} left out:', file=sys.stderr)
        for path, reason in failures:
            print(f'  {command.shown(path)}: {reason}', file=sys.stderr)
