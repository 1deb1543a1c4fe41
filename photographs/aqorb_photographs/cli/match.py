# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb match: the matches of pairs of images."""

import argparse
import concurrent.futures
import itertools
import os
import re

import numpy as np

import aqorb
from aqorb_photographs.cli import options
from aqorb_photographs.cli.pairs import similar
from aqorb_photographs import InputError, map_ahead

AT_A_TIME = 1024  # pairs whose images are in memory


def add(commands):
    parser = options.add_command(
        commands, 'match', run, 'match the features of pairs of images',
        'Matches mutually nearest descriptors by a ratio test. Run again, the command matches new pairs, and pairs '
        'whose features have changed.')
    parser.add_argument('features', metavar='FEATURES', help='folder of aqorb extract')
    parser.add_argument('--pairs', required=True,
                        help='sequential:K, each image with the next K by name; retrieval:K, each image with the K '
                        'most similar images; both, joined by a +; exhaustive; or a file with two names per line, '
                        'separated by a tab or spaces; - is standard input')
    parser.add_argument('--out', required=True, metavar='FOLDER', help='folder of Parquet files for the matches')
    parser.add_argument('--ratio', type=float, default=.8,
                        help='limit of the distance over the second nearest distance (%(default)s)')
    parser.add_argument('--max-distance', type=options.at_least(0), metavar='N',
                        help='limit of the distance in bits')
    parser.add_argument('--min-gap', type=options.positive, default=1, metavar='N',
                        help='retrieval skips images less than N apart by name, to find the loops of a video')
    parser.add_argument('--verify', action=argparse.BooleanOptionalAction, default=True,
                        help='find the matches that agree on a fundamental matrix; COLMAP needs them (the default)')
    parser.add_argument('--part-size', type=options.positive, default=4096, metavar='N',
                        help='pairs after which matches are saved (%(default)s)')
    options.add_words(parser)


def run(given):
    from aqorb_photographs import places, store
    out = options.store_at(given.out)
    if os.path.realpath(out) == os.path.realpath(given.features):
        raise InputError('--out must name another folder than the features')
    features = store.Features(given.features, ['name', 'x', 'y', 'response', 'descriptors'])
    features.parameters()
    pairs, total = pairs_of(given, features)

    def match_pair(both):
        return places.match(*both, given.ratio, given.max_distance, given.verify)

    matches = store.Matches(out, features)
    parameters = {'ratio': given.ratio, 'max_distance': given.max_distance, 'verified': given.verify}
    matches.agree(parameters)
    aqorb.setNumThreads(1)  # one thread for each pair
    done = count = 0
    with options.progress(given, total, 'pair') as bar, concurrent.futures.ThreadPoolExecutor(given.threads) as pool:
        for chunk in chunks_of(pairs, given.part_size):
            new = chunk[~np.isin(matches.codes(chunk), matches.known)]
            bar.update(len(chunk) - len(new))
            found = []
            for start in range(0, len(new), AT_A_TIME):
                part = new[start:start + AT_A_TIME]
                read = features.read(part)
                for _, columns in map_ahead(pool, match_pair, ((read[i], read[j]) for i, j in part), 4 * given.threads):
                    found.append(columns)
                    bar.update()
            if found:
                store.write_part(out, store.to_matches(features, new, found, parameters))
                done += len(found)
                count += sum(len(columns[0]) for columns in found)
    matches = store.Matches(out, features)
    matches.tidy()
    options.say(given, f'{out}: {options.count_of(len(matches.pairs), "pair")}, {done} of them new with '
                f'{options.count_of(count, "match", "es")}')
    return int(not total)


def pairs_of(given, features):
    """Returns the pairs of images, and their number."""
    count = len(features.images)
    kinds = dict(re.findall(r'(sequential|retrieval):([1-9][0-9]*)', given.pairs))
    if '+'.join(f'{kind}:{reach}' for kind, reach in kinds.items()) == given.pairs and 'retrieval' in kinds:
        pairs = similar(given, features, int(kinds['retrieval']), int(kinds.get('sequential', 0)))
        return pairs.tolist(), len(pairs)
    if kinds and given.pairs == f'sequential:{kinds.get("sequential")}' or given.pairs == 'exhaustive':
        reach = min(int(kinds.get('sequential', count)), max(count - 1, 0))
        pairs = ((i, j) for i in range(count) for j in range(i + 1, min(i + reach + 1, count)))
        return pairs, reach * count - reach * (reach + 1) // 2
    if given.pairs != '-' and not os.path.isfile(given.pairs):
        raise InputError('--pairs must be sequential:K, retrieval:K, both joined by a +, exhaustive or a file, got '
                         + given.pairs)
    pairs = list_of(given.pairs, features)
    return pairs, len(pairs)


def list_of(path, features):
    """Returns the pairs in a list of names: the first two names of each line, which may also have a score."""
    indices = {options.shown(name): index for name, index in features.index.items()}
    indices.update(features.index)
    pairs = {}  # by the set of both images: the order does not count
    lines = options.content_of(path).decode('utf-8-sig', 'surrogateescape').split('\n')
    for number, line in enumerate(lines, 1):
        line = line.rstrip('\r')
        names = [name.strip(' ') for name in line.split('\t')] if '\t' in line else line.split()
        both = [indices.get(name, indices.get(os.path.normpath(name))) for name in names[:2]]
        if not names or names == [''] or line.startswith('#') and None in both:
            continue
        if len(names) not in (2, 3) or None in both:
            raise InputError(f'{path}, line {number}: must have the names of two images in the features')
        if both[0] == both[1]:
            raise InputError(f'{path}, line {number}: {options.shown(names[0])} cannot be matched with itself')
        pairs.setdefault(frozenset(both), both)
    return list(pairs.values())


def chunks_of(pairs, size):
    """Yields arrays of `size` pairs; the last one may have fewer."""
    pairs = iter(pairs)
    while chunk := list(itertools.islice(pairs, size)):
        yield np.array(chunk)
