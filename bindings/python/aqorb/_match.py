# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb match: the matches of pairs of images."""

import concurrent.futures
import functools
import hashlib
import itertools
import os
import re

import aqorb
from aqorb import command


def add(commands):
    parser = commands.add_parser('match', help='match the features of pairs of images',
                                 description='Matches descriptors that are the nearest of each other. If it is stopped, '
                                 'the same command goes on where it was.')
    parser.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    parser.add_argument('--pairs', required=True,
                        help='sequential:K, each image with the next K in the order of their paths; exhaustive; or a file '
                        'with two paths a line, with a tab or a space between them')
    parser.add_argument('--out', metavar='FILE', help='.parquet, or .db for COLMAP; FEATURES by default if that is a .db')
    parser.add_argument('--ratio', type=float, help='keep what is nearer than this times the second nearest')
    parser.add_argument('--max-distance', type=command.at_least(0), metavar='N',
                        help='keep what differs in at most so many bits')
    parser.add_argument('--part-size', type=command.positive, default=4096, metavar='N',
                        help='pairs after which what is done is saved (%(default)s)')
    command.add_threads(parser)
    command.add_overwrite(parser)
    parser.set_defaults(run=run)


def pairs_of(text, paths):
    """Pairs of indices of images, and how many they are."""
    from aqorb import files
    count = len(paths)
    if text == 'exhaustive':
        return itertools.combinations(range(count), 2), count * (count - 1) // 2
    sequential = re.fullmatch('sequential:([1-9][0-9]*)', text)
    if sequential:
        reach = int(sequential.group(1))
        pairs = ((i, j) for i in range(count) for j in range(i + 1, min(i + 1 + reach, count)))
        return pairs, sum(min(reach, count - 1 - i) for i in range(count))
    if not os.path.isfile(text):
        raise files.Refused(f'--pairs must be sequential:K, exhaustive or a file, got {text}')
    indices = {path: i for i, path in enumerate(paths)}
    pairs = {}  # by the set of the two, as those in both orders are one
    with open(text, 'rb') as file:
        for number, line in enumerate(file, 1):
            names = line.rstrip(b'\r\n').split(b'\t' if b'\t' in line else b' ')
            if names == [b'']:
                continue
            if len(names) != 2 or not all(name in indices for name in names):
                raise files.Refused(f'{text}, line {number}: must be the paths of two images in the features')
            pairs.setdefault(frozenset(names), (indices[names[0]], indices[names[1]]))
    return iter(pairs.values()), len(pairs)


def run(options):
    import pyarrow as pa
    from aqorb import collection, files
    features = files.Features(options.features)
    out = options.out or options.features
    suffix = files.suffix_of(out)
    is_same = os.path.realpath(out) == os.path.realpath(options.features)
    if suffix == '.parquet' and is_same:
        raise files.Refused('--out must name a file for the matches')
    pairs, total = pairs_of(options.pairs, features.paths)
    metadata = {'version': aqorb.__version__, 'pairs': options.pairs, 'ratio': options.ratio,
                'max distance': options.max_distance, 'features': features.metadata}
    if os.path.isfile(options.pairs):
        with open(options.pairs, 'rb') as file:
            metadata['pairs'] = hashlib.sha256(file.read()).hexdigest()
    aqorb.setNumThreads(1)  # the pairs are what is divided among threads

    def make_table(chunk, progress):
        found = []
        with features.opened(), concurrent.futures.ThreadPoolExecutor(options.threads) as pool:
            described = ((features.descriptors(i), features.descriptors(j)) for i, j in chunk)
            for _, matches in collection.map_ahead(pool, lambda both: aqorb.matchArrays(
                    *both, options.ratio, True, options.max_distance), described, 4 * options.threads):
                found.append(matches)
                progress(1)
        columns = [pa.array([features.paths[pair[i]] for pair in chunk], pa.binary()) for i in (0, 1)]
        columns += [pa.array([matches[:, i] for matches, _ in found], pa.list_(pa.int32())) for i in (0, 1)]
        columns.append(pa.array([distances for _, distances in found], pa.list_(pa.int32())))
        return pa.Table.from_arrays(columns, schema=files.MATCHES), []

    write = (functools.partial(files.write_parquet, schema=files.MATCHES) if suffix == '.parquet' else
             functools.partial(files.write_matches, features=features))
    files.write_in_parts(out, pairs, total, 'pair', options.part_size, metadata, options.overwrite, make_table, write,
                         'matches', is_same)
    print(f'{out}: {command.count_of(files.count_matches(out), "match", "es")} of {command.count_of(total, "pair")}')
