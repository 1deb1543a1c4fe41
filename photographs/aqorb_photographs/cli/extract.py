# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb extract: the features of photographs."""

import functools
import os

import numpy as np

import aqorb
from aqorb_photographs.cli import options
from aqorb_photographs import InputError, images


def add(commands):
    parser = options.add_command(
        commands, 'extract', run, 'detect the features of photographs',
        'Reads folders and their subfolders. Run again, the command extracts new and changed files, and retries failed '
        'files.')
    parser.add_argument('sources', nargs='*', metavar='FOLDER', help='folder or file')
    parser.add_argument('--out', required=True, metavar='FOLDER', help='folder of Parquet files for the features')
    parser.add_argument('--list', metavar='FILE', help='list of files to extract, one per line; - is standard input')
    parser.add_argument('--root', metavar='FOLDER',
                        help='root folder of the names; by default FOLDER, or the common parent of several')
    parser.add_argument('--include', action='append', default=[], metavar='PATTERN', help='only these files, as *.jpg')
    parser.add_argument('--exclude', action='append', default=[], metavar='PATTERN', help='leave out files and folders')
    parser.add_argument('--masks', metavar='FOLDER', help='folder of masks, named as for COLMAP: photograph.jpg.png')
    parser.add_argument('--prune', action='store_true', help='remove the features of deleted files')
    parser.add_argument('--strict', action='store_true', help='exit with 1 if an image failed')
    parser.add_argument('--part-size', type=options.positive, default=256, metavar='N',
                        help='images after which features are saved (%(default)s)')
    options.add_reading(parser)
    options.add_threads(parser)


def run(given):
    from aqorb_photographs import store
    out = options.store_at(given.out)
    sources = given.sources + (listed(given.list) if given.list else [])
    if not sources:
        raise InputError('there is nothing to extract: name a folder or a file')
    paths, left_out, unlisted = images.list_files(sources, given.include, given.exclude, out)
    root = os.path.abspath(given.root or root_of(sources))
    detector, how = options.detector_of(given), options.reading_of(given)
    before = store.Features(out) if os.path.isdir(out) else None
    if before:
        store.clean(out)
        before.agree(store.parameters_of(detector, how))
    files = files_of(paths, root, given.masks, before)
    aqorb.setNumThreads(1)  # one thread for each image
    failures, notes, rows, done, features = [], [], [], 0, 0
    with options.progress(given, len(files), 'image') as bar:
        for file, row, note in store.extract(files, detector, how, given.threads):
            bar.update()
            if row is None:
                failures.append((file.name, note))
                continue
            notes += [(file.name, note)] if note else []
            rows.append(row)
            features += len(row['x'][0])
            if len(rows) == given.part_size or features >= 2**22:
                done += store.write_rows(out, rows)
                rows, features = [], 0
        done += store.write_rows(out, rows)
    failures += [(store.name_of(path, root), reason) for path, reason in unlisted]
    gone = forget(out, given.prune) if os.path.isdir(out) else 0
    total = len(store.Features(out).images) if os.path.isdir(out) else 0
    options.list_failures(notes, 'Damaged files, read as far as possible')
    options.list_failures(failures, f'{options.count_of(len(failures), "file")} left out')
    if left_out:
        options.say(given, f'{options.count_of(left_out, "name")} passed over: not included, or of other programs')
    options.say(given, f'{out}: {options.count_of(total, "image")}, {done} of them new' +
                (f'; {gone} gone' if gone else ''))
    return int(bool(given.strict and failures) or not done and len(files) == len(paths))


def listed(path):
    """Returns the names in a list, one per line."""
    lines = options.content_of(path).removeprefix(b'\xef\xbb\xbf').splitlines()
    return [os.fsdecode(line) for line in lines if line]


def root_of(sources):
    folders = [os.path.abspath(source if os.path.isdir(source) else os.path.dirname(source)) for source in sources]
    return os.path.commonpath(folders)


def files_of(paths, root, masks, before):
    """Returns the files that are new or have changed."""
    from aqorb_photographs import store
    columns = ('folder', 'file_size', 'file_time', 'mask')
    known = dict(zip(before.images, zip(*map(before.value, columns)))) if before else {}
    files = {}
    for path in paths:
        name = store.name_of(path, root)
        mask = images.mask_of(masks, name) if masks else None
        size = time = None
        if os.path.exists(path):
            size, time = os.stat(path).st_size, os.stat(path).st_mtime_ns
        file = store.File(name, functools.partial(images.open_file, path), root, size, time, mask,
                          os.stat(mask).st_mtime_ns if mask else 0)
        folder, *state = known.get(name, [None])
        if state and state[0] == size and state[1] in (time, None) and state[2] == file.mask_time:
            continue
        if state and folder not in (root, None) and os.path.exists(store.path_of(folder, name)):
            raise InputError(f'{options.shown(name)} is in {folder} and in {root}: give --root a folder that has both')
        files[name] = file
    return list(files.values())


def forget(out, prune):
    """Rewrites parts without superseded rows and, to prune, without deleted images. Returns the number of the
    latter."""
    from aqorb_photographs import store
    features = store.Features(out)
    kept, gone = np.zeros(len(features.head), bool), 0
    folders = features.value('folder')
    for image, row in enumerate(features.chosen):
        is_gone = prune and os.path.isdir(folders[image] or '') and not os.path.exists(features.path(image))
        kept[row] = not is_gone
        gone += is_gone
    features.keep(kept)
    return gone
