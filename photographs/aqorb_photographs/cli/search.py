# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb search: images of the same place as a photograph."""

import functools
import os

import aqorb
from aqorb_photographs.cli import draw, options
from aqorb_photographs import InputError, images


def add(commands):
    parser = options.add_command(
        commands, 'search', run, 'find images of the same place as a photograph',
        'Prints images of the same place, the best first, with their numbers of matches and of inliers, which agree on '
        'one geometry. In the column ahead stands, for the best image, how many times as many inliers it has as the '
        'best image of another place; - if there is none.')
    parser.add_argument('features', metavar='FEATURES', help='folder of aqorb extract')
    parser.add_argument('photographs', nargs='+', metavar='PHOTOGRAPH')
    parser.add_argument('--retrieval', type=options.positive, metavar='K', help='match the K most similar images (20)')
    parser.add_argument('--top', type=options.positive, default=5, metavar='N', help='images to print (%(default)s)')
    parser.add_argument('--ratio', type=float, default=.8, help='ratio of the ratio test (%(default)s)')
    parser.add_argument('--draw', metavar='FILE', help='draw the best pair')
    parser.add_argument('--images', metavar='FOLDER', help='present folder of the images, for --draw')
    parser.add_argument('--strict', action='store_true',
                        help='exit with 1 if a photograph failed, or probably shows no place of the folder')
    parser.add_argument('--overwrite', action='store_true', help='replace an existing file')
    options.add_words(parser)


def run(given):
    from aqorb_photographs import places, store
    if given.draw:
        options.new_file(given.draw, given.overwrite, draw.suffixes())
    features = store.Features(given.features, ['name', 'x', 'y', 'response', 'descriptors'])
    if not features.images:
        raise InputError(f'{given.features} has no images')
    number = given.retrieval or min(20, len(features.images))
    if number > len(features.images):
        raise InputError(f'similar images must be at most {len(features.images)}, the number of images, got {number}')
    if given.draw and not any(os.path.isfile(features.path(i, given.images)) for i in range(len(features.images))):
        raise InputError(f'--images must be the folder of the images of {given.features}')
    detector, how = store.detector_of(features.parameters())
    aqorb.setNumThreads(1)  # one thread for each image
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
    print('photograph\timage\tmatches\tinliers\tahead')
    rows = pa.concat_tables([row for _, row in queries])
    for (name, _), found in zip(queries, places.search(rows, features, index, number, given.ratio, given.threads)):
        ahead = places.ahead(found, features, given.ratio)
        for inliers, matches, image, *_ in found[:given.top]:
            print(options.shown(name), options.shown(features.images[image]), matches, inliers, ahead, sep='\t')
            ahead = '-'
        if found[0][0] < places.MIN_INLIERS:
            unknown.append((name, f'no image has {places.MIN_INLIERS} inliers'))
        if found[0][0] > best[0]:
            best = found[0][0], name, found[0][2], found[0][3:]
    if given.draw:
        reading = how._replace(max_size=640)
        paths = best[1], features.path(best[2], given.images)
        draw.save(given.draw, [images.read_file(path, reading) for path in paths], best[3])
    options.list_failures(unknown, 'Photographs that probably show no place of the folder')
    return int(bool(given.strict and failures + unknown))
