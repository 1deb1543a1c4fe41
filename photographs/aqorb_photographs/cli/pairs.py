# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb pairs: pairs of images that may show the same place."""

from aqorb_photographs.cli import options
from aqorb_photographs import InputError


def add(commands):
    parser = options.add_command(commands, 'pairs', run, 'list pairs of images that may show the same place',
                                 'Writes two names per line, separated by a tab if a name has a space.')
    parser.add_argument('features', metavar='FEATURES', help='folder of aqorb extract')
    parser.add_argument('--retrieval', type=options.positive, required=True, metavar='K',
                        help='each image with the K most similar images')
    parser.add_argument('--sequential', type=options.positive, default=0, metavar='K',
                        help='also each image with the next K by name')
    parser.add_argument('--min-gap', type=options.positive, default=1, metavar='N',
                        help='skip images less than N apart by name, to find the loops of a video')
    parser.add_argument('--out', required=True, metavar='FILE', help='new file, such as pairs.txt')
    parser.add_argument('--overwrite', action='store_true', help='replace an existing file')
    options.add_words(parser)


def run(given):
    from aqorb_photographs import store
    options.new_file(given.out, given.overwrite)
    features = store.Features(given.features, ['name', 'x', 'response', 'descriptors'])
    features.parameters()
    pairs = similar(given, features, given.retrieval, given.sequential)
    names = list(map(options.shown, features.images))
    gap = '\t' if any(' ' in name for name in names) else ' '
    with store.replacing(given.out) as file:
        for first, second in pairs:
            file.write(f'{names[first]}{gap}{names[second]}\n'.encode())
    options.say(given, f'{given.out}: {options.count_of(len(pairs), "pair")}')
    return int(not len(pairs))


def similar(given, features, number, sequential):
    """Returns the pairs of each image with `number` similar and `sequential` following images."""
    from aqorb_photographs import places
    most = len(features.images) - 1
    if number > most:
        raise InputError(f'similar images must be at most {most}, the number of other images, got {number}')
    if given.min_gap > most:
        raise InputError(f'--min-gap must be at most {most}, the largest distance of images, got {given.min_gap}')
    index = options.index_of(features, given)
    with options.progress(given, len(features.images), 'image', 'comparing') as bar:
        return places.similar_pairs(index.counts, number, given.min_gap, sequential, bar.update)
