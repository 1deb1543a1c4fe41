# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb match: the matches of pairs of images."""

import argparse
import concurrent.futures
import functools
import hashlib
import itertools
import os
import re
import sys
import time

import aqorb
from aqorb import _places, command

RETRIEVAL = r'retrieval:([1-9][0-9]*)(?:\+sequential:([1-9][0-9]*))?'


def add(commands):
    parser = commands.add_parser('match', help='match the features of pairs of images',
                                 description='Matches descriptors that are the nearest of each other. If it is '
                                 'stopped, the same command goes on where it was.')
    parser.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    parser.add_argument('--pairs', required=True,
                        help='sequential:K, each image with the next K in the order of their paths; retrieval:K, with '
                        'the K most similar ones; retrieval:K+sequential:K; exhaustive; or a file with two paths a line, '
                        'with a tab or a space between them')
    parser.add_argument('--out', metavar='FILE', help='.parquet, or .db for COLMAP; FEATURES by default if that is a .db')
    parser.add_argument('--ratio', type=float, help='keep what is nearer than this times the second nearest')
    parser.add_argument('--max-distance', type=command.at_least(0), metavar='N',
                        help='keep what differs in at most so many bits')
    parser.add_argument('--part-size', type=command.positive, default=4096, metavar='N',
                        help='pairs after which what is done is saved (%(default)s)')
    parser.add_argument('--verify', action=argparse.BooleanOptionalAction,
                        help='find the matches that agree on a fundamental matrix; by default of pairs by retrieval alone')
    _places.add_word_options(parser)
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
        raise files.Refused('--pairs must be sequential:K, retrieval:K, retrieval:K+sequential:K, exhaustive or a file, got '
                            + text)
    indices = {path: i for i, path in enumerate(paths)}
    pairs = {}  # by the set of the two, as those in both orders are one
    with open(text, 'rb') as file:
        for number, line in enumerate(file, 1):
            names = line.rstrip(b'\r\n').split(b'\t' if b'\t' in line else b' ')
            if names == [b'']:
                continue
            if len(names) not in (2, 3) or not all(name in indices for name in names[:2]):  # the third is a score
                raise files.Refused(f'{text}, line {number}: must be the paths of two images in the features')
            pairs.setdefault(frozenset(names[:2]), (indices[names[0]], indices[names[1]]))
    return iter(pairs.values()), len(pairs)


def announce(features, total, match_pair, threads, sample=32):
    """Says how many pairs there are, and about how long they take."""
    count = len(features.paths)
    with features.opened():
        both = [(features.keypoints(i), features.keypoints(count - 1 - i)) for i in range(min(count, sample))]
    begin = time.perf_counter()
    for one in both:
        match_pair(one)
    minutes = (time.perf_counter() - begin) / max(1, len(both)) * total / threads / 60
    words = f'{minutes:.0f} minutes' if minutes < 120 else f'{minutes / 60:.0f} hours'
    print(f'{command.count_of(total, "pair")}: about {words if minutes >= 1 else "a minute"}', file=sys.stderr)
    if count > 2000:
        print(f'For {count} images --pairs retrieval:20 takes less: each with the 20 most similar ones', file=sys.stderr)


def run(options):
    import pyarrow as pa
    from aqorb import collection, files
    features = files.Features(options.features)
    out = options.out or options.features
    suffix = files.suffix_of(out)
    is_same = os.path.realpath(out) == os.path.realpath(options.features)
    if suffix == '.parquet' and is_same:
        raise files.Refused('--out must name a file for the matches')
    retrieval = re.fullmatch(RETRIEVAL, options.pairs)
    if retrieval:
        if os.path.exists(out) and not (options.overwrite or is_same or os.path.exists(out + '.partial')):
            raise files.Refused(f'{out} exists; --overwrite replaces it')  # now rather than later
        pairs = _places.retrieve(features, *(int(number or 0) for number in retrieval.groups()), options)
        total = len(pairs)
    else:
        pairs, total = pairs_of(options.pairs, features.paths)
    is_verified = bool(retrieval) if options.verify is None else options.verify
    metadata = {'version': aqorb.__version__, 'pairs': options.pairs, 'ratio': options.ratio,
                'max distance': options.max_distance, 'features': features.metadata}
    if os.path.isfile(options.pairs):
        with open(options.pairs, 'rb') as file:
            metadata['pairs'] = hashlib.sha256(file.read()).hexdigest()
    elif retrieval:
        metadata['pairs'] = hashlib.sha256(pairs).hexdigest()
    schema = files.VERIFIED if is_verified else files.MATCHES
    if is_verified:
        from aqorb import places
        metadata['verified'] = True
    aqorb.setNumThreads(1)  # the pairs are what is divided among threads

    def match_pair(both):
        if is_verified:
            return places.match(*both, options.ratio, options.max_distance)
        (_, descriptors1), (_, descriptors2) = both
        matches, distances = aqorb.matchArrays(descriptors1, descriptors2, options.ratio, True, options.max_distance)
        return matches[:, 0], matches[:, 1], distances

    if options.pairs == 'exhaustive':
        announce(features, total, match_pair, options.threads)

    def make_table(chunk, progress):
        found = []
        with features.opened(), concurrent.futures.ThreadPoolExecutor(options.threads) as pool:
            for part in (chunk[first:first + 1024] for first in range(0, len(chunk), 1024)):
                # In the order of the file, of which reading a single image reads many.
                read = {image: features.keypoints(image) for image in sorted(set(itertools.chain(*part)))}
                described = ((read[i], read[j]) for i, j in part)
                for _, columns in collection.map_ahead(pool, match_pair, described, 4 * options.threads):
                    found.append(columns)
                    progress(1)
        columns = [[features.paths[pair[i]] for pair in chunk] for i in (0, 1)] + list(zip(*found))
        columns = [pa.array(column, field.type) for column, field in zip(columns, schema)]
        return pa.Table.from_arrays(columns, schema=schema), []

    write = (functools.partial(files.write_parquet, schema=schema) if suffix == '.parquet' else
             functools.partial(files.write_matches, features=features))
    files.write_in_parts(out, pairs, total, 'pair', options.part_size, metadata, options.overwrite, make_table, write,
                         'matches', is_same)
    print(f'{out}: {command.count_of(files.count_matches(out), "match", "es")} of {command.count_of(total, "pair")}')
