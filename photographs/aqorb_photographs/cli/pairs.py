# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb pairs: a list of pairs of images that may show the same place."""

import os

from aqorb_photographs.cli import match, options


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
    parser.add_argument('--scores', action='store_true', help='add the similarity, 0 to 1, to each line')
    parser.add_argument('--overwrite', action='store_true', help='replace an existing file')
    options.add_words(parser)


def run(given):
    from aqorb_photographs import places, store
    options.new_file(given.out, given.overwrite)
    features = store.Features(given.features, ['name', 'x', 'response', 'descriptors'])
    features.parameters()
    pairs, weights = match.similar(given, features, given.retrieval, given.sequential)
    scores = places.similarities_of(weights, pairs) if given.scores else [None] * len(pairs)
    names = list(map(options.shown, features.images))
    gap = '\t' if any(' ' in name for name in names) else ' '
    unfinished = given.out + '.unfinished'
    with open(unfinished, 'w', encoding='utf-8') as file:
        for (first, second), score in zip(pairs, scores):
            print(names[first], names[second], *[f'{score:.4f}'] if given.scores else [], sep=gap, file=file)
    os.replace(unfinished, given.out)
    options.say(given, f'{given.out}: {options.count_of(len(pairs), "pair")}')
    return int(not len(pairs))
