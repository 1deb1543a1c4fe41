# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""aqorb pairs and aqorb search: which images show the same place."""

import concurrent.futures
import functools
import hashlib
import os
import sys

import aqorb
from aqorb import command


def add(commands):
    parser = commands.add_parser('pairs', help='list pairs of images that may show the same place',
                                 description='Writes two paths a line. If it is stopped, the same command goes on where '
                                 'it was.')
    parser.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    parser.add_argument('--retrieval', type=command.positive, required=True, metavar='K',
                        help='each image with the K most similar ones')
    parser.add_argument('--sequential', type=command.positive, metavar='K',
                        help='besides, each image with the next K in the order of their paths')
    parser.add_argument('--out', required=True, metavar='FILE', help='such as pairs.txt')
    parser.add_argument('--scores', action='store_true', help='add the similarity, 0 to 1, to each line')
    parser.add_argument('--part-size', type=command.positive, default=1024, metavar='N',
                        help='images after which what is done is saved (%(default)s)')
    add_word_options(parser)
    add_min_gap(parser)
    command.add_overwrite(parser)
    parser.set_defaults(run=run_pairs)

    parser = commands.add_parser('search', help='find the images that show the same place as a photograph',
                                 description='Prints the images that show the same place as each photograph, best first, '
                                 'with the matches and how many of them agree on one geometry (inliers).')
    parser.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    parser.add_argument('photographs', nargs='+', metavar='PHOTOGRAPH')
    parser.add_argument('--retrieval', type=command.positive, metavar='K',
                        help='the K most similar images are matched (20)')
    parser.add_argument('--top', type=command.positive, default=5, metavar='N', help='images to print (%(default)s)')
    parser.add_argument('--ratio', type=float, default=.8, help='of the ratio test (%(default)s)')
    parser.add_argument('--draw', metavar='FILE', help='draw the best pair')
    parser.add_argument('--folder', default='.', help='where the images of FEATURES are, to draw one (%(default)s)')
    add_word_options(parser)
    command.add_overwrite(parser)
    parser.set_defaults(run=run_search)


def add_word_options(parser):
    parser.add_argument('--words', type=command.positive, metavar='N',
                        help='words, at most (65536); there are at most a quarter as many as features')
    parser.add_argument('--seed', type=command.at_least(0), default=0, metavar='N', help='of the random words (%(default)s)')
    parser.add_argument('--vocabulary', metavar='FILE',
                        help='file of words for a later collection: read if there is one, else written, as .npy')
    command.add_threads(parser)


def add_min_gap(parser):
    parser.add_argument('--min-gap', type=command.positive, default=1, metavar='N',
                        help='leave out images that are nearer than N in the order of paths, for loops of a video')


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


def look_up(images, words, threads):
    """Yields what aqorb.places.words_of gives for each image, of which the path and the descriptors are given."""
    from aqorb import collection, places
    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for _, found in collection.map_ahead(pool, lambda image: places.words_of(image[1], words), images, 4 * threads):
            yield found


def similar_pairs(counts, number, min_gap, sequential=0):
    """The pairs of similar images as rows of two indices, and their vectors. To them come those of each image with the
    next ones."""
    import numpy as np
    from tqdm import tqdm
    from aqorb import places
    total = counts.shape[0]
    weights = places.weigh(counts, places.rarity(counts))

    def blocks():
        with tqdm(total=total, unit='image', desc='comparing', smoothing=.05) as bar:
            for block in places.similar(weights, weights, number, min_gap):
                yield block
                bar.update(len(block[1]))

    neighbours = [np.column_stack([np.arange(total - i), np.arange(i, total)]) for i in range(1, min(sequential + 1, total))]
    return np.unique(np.concatenate([places.pairs(blocks(), total), *neighbours]), axis=0), weights


def check_numbers(number, most, min_gap=1):
    from aqorb import files
    if number > most:
        raise files.Refused(f'similar images must be at most {most}, as many as there are others, got {number}')
    if min_gap > most:
        raise files.Refused(f'--min-gap must be at most {most}, as images are no farther apart, got {min_gap}')


def run_pairs(options):
    import numpy as np
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
        rows = list(look_up(chunk, words, options.threads))
        progress(len(rows))
        columns = [pa.array([row[i] for row in rows], pa.list_(pa.int32())) for i in (0, 1)]
        return pa.Table.from_arrays(columns, names=['word', 'count']), []

    def write(name, tables, metadata, database):
        rows = [tuple(table[column][row].values.to_numpy() for column in ('word', 'count'))
                for table in tables for row in range(len(table))]
        pairs, weights = similar_pairs(places.count(rows, metadata['words']), options.retrieval, options.min_gap,
                                       options.sequential or 0)
        scores = [' %.4f' % value for value in places.similarities(weights, pairs)] if options.scores else [''] * len(pairs)
        with open(name, 'wb') as file:
            for (i, j), score in zip(pairs, scores):
                file.write(b'%s %s%s\n' % (features.paths[i], features.paths[j], score.encode()))
        found.append(len(pairs))

    with files.locked(options.out + '.partial'):
        words = words_for(features, options)
        metadata = {'version': aqorb.__version__, 'features': features.metadata, 'words': len(words),
                    'vocabulary': hashlib.sha256(words).hexdigest()}
        files.join_parts(options.out, options.out + '.partial', images_in(features), len(features.paths), 'image',
                         options.part_size, metadata, make_table, write)
    print(f'{options.out}: {command.count_of(found[0], "pair")}')


def retrieve(features, number, sequential, options):
    """The pairs of aqorb match --pairs retrieval:K."""
    from aqorb import places
    check_numbers(number, len(features.paths) - 1, options.min_gap)
    words = words_for(features, options)
    rows = list(look_up(images_in(features, 'looking up'), words, options.threads))
    return similar_pairs(places.count(rows, len(words)), number, options.min_gap, sequential)[0]


def read_photographs(options, metadata):
    """The features of the photographs that are searched for, made as those of the file were. Others are listed."""
    from aqorb import collection
    detector = aqorb.AdaptiveQuadtreeORB_create()
    for name, value in metadata['parameters'].items():
        getattr(detector, 'set' + name)(value)
    table, failures = collection.extract(
        [os.fsencode(path) for path in options.photographs], functools.partial(command.open_file, b''), detector,
        'cv2' if metadata['reader'].startswith('cv2') else 'pillow', metadata['max size'], metadata['EXIF orientation'],
        options.threads)
    kept = [len(row) > 0 for row in table['x']]
    failures += [(path.as_py(), 'it has no features') for path, is_kept in zip(table['path'], kept) if not is_kept]
    for path, reason in failures:
        print(f'aqorb: {os.fsdecode(path)} is not searched for: {reason}', file=sys.stderr)
    return table.filter(kept)


def run_search(options):
    import numpy as np
    from aqorb import _draw, collection, files, places
    if options.draw and os.path.exists(options.draw) and not options.overwrite:
        raise files.Refused(f'{options.draw} exists; --overwrite replaces it')
    features = files.Features(options.features)
    with files.reading(options.features):
        queries = read_photographs(options, features.metadata)
    if not len(queries):
        sys.exit(1)
    number = min(options.retrieval or 20, len(features.paths))
    check_numbers(options.retrieval or 1, len(features.paths))
    words = words_for(features, options)
    counts = places.count(list(look_up(images_in(features, 'looking up'), words, options.threads)), len(words))
    rarity = places.rarity(counts)
    asked = places.count(list(look_up(places.images_of(queries), words, options.threads)), len(words))
    best = None
    print('photograph\timage\tmatches\tinliers')

    def compare(item):
        query, descriptors, positions, image, (their_positions, their_descriptors) = item
        pairs, _ = aqorb.matchArrays(descriptors, their_descriptors, options.ratio)
        points = positions[pairs[:, 0]], their_positions[pairs[:, 1]]
        inliers, _ = places.verify(*points)
        return len(inliers), len(pairs), query, image, *(side[inliers] for side in points)

    def candidates():
        blocks = places.similar(places.weigh(asked, rarity), places.weigh(counts, rarity), number)
        for start, indices, _ in blocks:
            for query, images in enumerate(indices, start):
                row = queries.slice(query, 1)
                positions = np.column_stack([row[name].combine_chunks().flatten().to_numpy() for name in ('x', 'y')])
                descriptors = collection.descriptors_of(row['descriptors'])
                for image in images:
                    yield query, descriptors, positions, image, features.keypoints(image)

    with features.opened(), concurrent.futures.ThreadPoolExecutor(options.threads) as pool:
        compared = (found for _, found in collection.map_ahead(pool, compare, candidates(), 4 * options.threads))
        for path in queries['path'].to_pylist():
            found = [next(compared) for _ in range(number)]
            found.sort(key=lambda one: -one[0])  # stable: of as many inliers the more similar image comes first
            for inliers, matches, _, image, *_ in found[:options.top]:
                print(f'{os.fsdecode(path)}\t{os.fsdecode(features.paths[image])}\t{matches}\t{inliers}')
            best = max(best or found[0], found[0], key=lambda one: one[0])
    if options.draw:
        _, _, query, image, *ends = best
        how = {'orientation': features.metadata['EXIF orientation']}
        paths = queries['path'][query].as_py(), os.path.join(os.fsencode(options.folder), features.paths[image])
        _draw.save(options.draw, [_draw.read(path, max_size=800, **how) for path in paths], ends)
