# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb pairs and aqorb search: which images show the same place."""

import functools
import hashlib
import os
import sys

import aqorb
from aqorb import command


def add(commands):
    parser = commands.add_parser('pairs', help='list pairs of images that may show the same place',
                                 description='Writes two paths a line. If it is stopped, the same command goes on.')
    parser.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    parser.add_argument('--retrieval', type=command.positive, required=True, metavar='K', help='the most similar ones')
    parser.add_argument('--sequential', type=command.positive, metavar='K',
                        help='besides, each image with the next K in the order of their paths')
    parser.add_argument('--out', required=True, metavar='FILE', help='such as pairs.txt')
    parser.add_argument('--scores', action='store_true', help='add the similarity, 0 to 1, to each line')
    parser.add_argument('--part-size', type=command.positive, default=1024, metavar='N', help='as of aqorb extract')
    add_word_options(parser)
    command.add_overwrite(parser)
    parser.set_defaults(run=run_pairs)

    parser = commands.add_parser('search', help='find the images that show the same place as a photograph',
                                 description='Prints images that show the same place, best first, with the matches '
                                 'and inliers: those matches that agree on one geometry.')
    parser.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    parser.add_argument('photographs', nargs='+', metavar='PHOTOGRAPH')
    parser.add_argument('--retrieval', type=command.positive, metavar='K', help='match the K most similar ones (20)')
    parser.add_argument('--top', type=command.positive, default=5, metavar='N', help='images to print (%(default)s)')
    parser.add_argument('--ratio', type=float, default=.8, help='of the ratio test (%(default)s)')
    parser.add_argument('--draw', metavar='FILE', help='draw the best pair')
    parser.add_argument('--folder', default='.', help='where the images of FEATURES are, to draw one (%(default)s)')
    add_word_options(parser, has_gap=False)
    command.add_overwrite(parser)
    parser.set_defaults(run=run_search)


def add_word_options(parser, has_gap=True):
    parser.add_argument('--words', type=command.positive, metavar='N',
                        help='words, at most (65536); there are at most a quarter as many as features')
    parser.add_argument('--seed', type=command.at_least(0), default=0, metavar='N', help='of the words (%(default)s)')
    parser.add_argument('--vocabulary', metavar='FILE',
                        help='file of words for a later collection: read if there is one, else written, as .npy')
    if has_gap:
        parser.add_argument('--min-gap', type=command.positive, default=1, metavar='N', help='leave out images nearer '
                            'than N in the order of paths, for the loops of a video')
    command.add_threads(parser)


def images_in(features, label=None):
    """Yields the path of each image and the descriptors that are looked up."""
    from tqdm import tqdm
    from aqorb import places
    with tqdm(total=len(features.paths), unit='image', desc=label, smoothing=.05, disable=not label) as bar:
        for path, descriptors, response in features.images():
            yield path, places.strongest(descriptors, response)
            bar.update()


def words_for(features, options):
    """The words of a file of features, or of the vocabulary."""
    import numpy as np
    from aqorb import files, places
    aqorb.setNumThreads(1)  # the images are what is divided among threads
    if features.path.endswith('.db'):
        print(f'{features.path} has no responses: all features are looked up, not the strongest', file=sys.stderr)
    name = options.vocabulary
    if name and os.path.exists(name):
        with files.reading(name):
            words = np.load(name, allow_pickle=False)
            places.check_words(words, 'a vocabulary')
        if options.words and options.words != len(words):
            raise files.Refused(f'{name} has {len(words)} words, not {options.words}')
        return words
    count = options.words or places.WORDS
    words = places.words([places.draw(images_in(features, 'drawing words'), count, options.seed)], count)
    if name:
        with open(name + '.partial', 'wb') as file:
            np.save(file, words)
        os.replace(name + '.partial', name)
    return words


def similar_pairs(counts, options, number, sequential):
    from tqdm import tqdm
    from aqorb import places
    with tqdm(total=counts.shape[0], unit='image', desc='comparing', smoothing=.05) as bar:
        return places.similar_pairs(counts, number, options.min_gap, sequential or 0, bar.update)


def retrieve(features, number, sequential, options):
    """The pairs of aqorb match --pairs retrieval:K."""
    check_numbers(number, len(features.paths) - 1, options.min_gap)
    return similar_pairs(counts_of(features, options)[1], options, number, sequential)[0]


def counts_of(features, options):
    from aqorb import places
    words = words_for(features, options)
    return words, places.count(places.look_up(images_in(features, 'looking up'), words, options.threads), len(words))


def check_numbers(number, most, min_gap=1):
    if number > most:
        raise ValueError(f'similar images must be at most {most}, as many as there are others, got {number}')
    if min_gap > most:
        raise ValueError(f'--min-gap must be at most {most}, as images are no farther apart, got {min_gap}')


def run_pairs(options):
    import pyarrow as pa
    from aqorb import files, places
    features = files.Features(options.features)
    check_numbers(options.retrieval, len(features.paths) - 1, options.min_gap)
    for path in features.paths:
        if len(path.split()) != 1:
            raise files.Refused(f'the path {os.fsdecode(path)!r} cannot be in a list of pairs, as it has a space: '
                                'aqorb match --pairs retrieval:K needs no list')
    if os.path.exists(options.out) and not options.overwrite:
        raise files.Refused(f'{options.out} exists; --overwrite replaces it')
    found = []

    def make_table(chunk, progress):
        rows = list(places.look_up(chunk, words, options.threads))
        progress(len(rows))
        columns = [pa.array([row[i] for row in rows], pa.list_(pa.int32())) for i in (0, 1)]
        return pa.Table.from_arrays(columns, names=['word', 'count']), []

    def write(name, tables, metadata, database):
        rows = [tuple(table[column][row].values.to_numpy() for column in ('word', 'count'))
                for table in tables for row in range(len(table))]
        pairs, weights = similar_pairs(places.count(rows, metadata['words']), options, options.retrieval,
                                       options.sequential)
        scores = places.similarities(weights, pairs) if options.scores else [None] * len(pairs)
        with open(name, 'wb') as file:
            for (i, j), score in zip(pairs, scores):
                suffix = b' %.4f' % score if options.scores else b''
                file.write(b'%s %s%s\n' % (features.paths[i], features.paths[j], suffix))
        found.append(len(pairs))

    with files.locked(options.out + '.partial'):
        words = words_for(features, options)
        metadata = {'version': aqorb.__version__, 'features': features.metadata, 'words': len(words),
                    'vocabulary': hashlib.sha256(words).hexdigest()}
        files.join_parts(options.out, options.out + '.partial', images_in(features), len(features.paths), 'image',
                         options.part_size, metadata, make_table, write)
    print(f'{options.out}: {command.count_of(found[0], "pair")}')


def run_search(options):
    from aqorb import _draw, files, places
    if options.draw and os.path.exists(options.draw) and not options.overwrite:
        raise files.Refused(f'{options.draw} exists; --overwrite replaces it')
    features = files.Features(options.features)
    if options.draw and not any(os.path.isfile(os.path.join(os.fsencode(options.folder), path))
                                for path in features.paths):
        raise files.Refused(f'--folder must be where the images of {options.features} are, got {options.folder!r}')
    with files.reading(options.features):
        queries, failures = places.extract_alike(
            [os.fsencode(path) for path in options.photographs], functools.partial(command.open_file, b''),
            features.metadata, options.threads)
    for path, reason in failures:
        print(f'aqorb: {command.shown(path)} is not searched for: {reason}', file=sys.stderr)
    if not len(queries):
        sys.exit(1)
    number = options.retrieval or min(20, len(features.paths))
    check_numbers(number, len(features.paths))
    words, counts = counts_of(features, options)
    best, pair = -1, None
    print('photograph\timage\tmatches\tinliers')
    for photograph, found in zip(queries['path'].to_pylist(), places.search(
            queries, features, words, counts, number, options.ratio, options.threads)):
        for inliers, matches, image, *_ in found[:options.top]:
            print(command.shown(photograph), command.shown(features.paths[image]), matches, inliers, sep='\t')
        if found[0][0] > best:
            best, _, image, *ends = found[0]
            pair = photograph, os.path.join(os.fsencode(options.folder), features.paths[image])
    if options.draw:
        images = [_draw.read(path, 640, features.metadata['EXIF orientation']) for path in pair]
        _draw.save(options.draw, images, ends)
