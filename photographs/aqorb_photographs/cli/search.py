# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb search: the images that show the same place as a photograph."""

import functools
import json
import os

import aqorb
from aqorb_photographs.cli import draw, options
from aqorb_photographs import Refused, images


def add(commands):
    parser = options.add_command(
        commands, 'search', run, 'find the images that show the same place as a photograph',
        'Prints images that show the same place, best first, with the matches and inliers: those matches that agree '
        'on one geometry.')
    parser.add_argument('features', metavar='FEATURES', help='folder of aqorb extract')
    parser.add_argument('photographs', nargs='+', metavar='PHOTOGRAPH')
    parser.add_argument('--retrieval', type=options.positive, metavar='K', help='match the K most similar ones (20)')
    parser.add_argument('--top', type=options.positive, default=5, metavar='N', help='images to print (%(default)s)')
    parser.add_argument('--ratio', type=float, default=.8, help='of the ratio test (%(default)s)')
    parser.add_argument('--json', action='store_true', help='print an object a line')
    parser.add_argument('--draw', metavar='FILE', help='draw the best pair')
    parser.add_argument('--images', metavar='FOLDER', help='where the images are now, to draw one')
    parser.add_argument('--strict', action='store_true',
                        help='exit with 1 if a photograph failed, or is probably of no place in the folder')
    parser.add_argument('--overwrite', action='store_true', help='replace a file that exists')
    options.add_words(parser)


def run(given):
    from aqorb_photographs import places, store
    if given.draw:
        options.new_file(given.draw, given.overwrite, draw.suffixes())
    features = store.Features(given.features, ['name', 'x', 'y', 'response', 'descriptors'])
    if not features.images:
        raise Refused(f'{given.features} has no images')
    number = given.retrieval or min(20, len(features.images))
    if number > len(features.images):
        raise Refused(f'similar images must be at most {len(features.images)}, the number of images, got {number}')
    if given.draw and not any(os.path.isfile(features.path(i, given.images)) for i in range(len(features.images))):
        raise Refused(f'--images must be the folder where the images of {given.features} are now')
    detector, how = store.detector_of(features.parameters())
    aqorb.setNumThreads(1)  # the images are what is divided among threads
    files = [store.File(path, functools.partial(images.open_file, path)) for path in given.photographs]
    queries, failures = [], []
    for file, row, note in store.extract(files, detector, how, given.threads):
        if row is None or not len(row['x'][0]):
            failures.append((file.name, note or 'it has no features'))
        else:
            queries.append((file.name, row))
    options.list_failures(failures, f'{options.count_of(len(failures), "photograph")} not searched for')
    if not queries:
        return 1
    import pyarrow as pa
    index = options.index_of(features, given)
    best, unknown = (-1, None, None, ()), []
    if not given.json:
        print('photograph\timage\tmatches\tinliers')
    rows = pa.concat_tables([row for _, row in queries])
    for (name, _), found in zip(queries, places.search(rows, features, index, number, given.ratio, given.threads)):
        for inliers, matches, image, *_ in found[:given.top]:
            values = [name, features.images[image], matches, inliers]
            if given.json:
                print(json.dumps(dict(zip(('photograph', 'image', 'matches', 'inliers'), values))))
            else:
                print(*map(options.shown, values[:2]), matches, inliers, sep='\t')
        if found[0][0] < places.MIN_INLIERS:
            unknown.append((name, f'no image has {places.MIN_INLIERS} inliers'))
        if found[0][0] > best[0]:
            best = found[0][0], name, found[0][2], found[0][3:]
    if given.draw:
        reading = how._replace(max_size=640)
        paths = best[1], features.path(best[2], given.images)
        draw.save(given.draw, [images.read_file(path, reading) for path in paths], best[3])
    options.list_failures(unknown, 'Probably of no place in the folder')
    return int(bool(given.strict and failures + unknown))
