# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Finds images of the same place by a bag of words over ORB descriptors, with NumPy and scipy.sparse.

    words = places.choose_words(images)           # images: pairs of a name and descriptors
    counts = places.count_matrix(places.look_up(images, words), len(words))
    pairs = places.similar_pairs(counts, 5)       # each image with the five most similar ones
    inliers, F = places.verify(points1, points2)  # of two images: the matches that agree on a geometry

Words are descriptors of the collection itself, drawn at random. The word of a feature is the nearest word. The
vector of an image has an element for each word: the square root of the word's count in the image, times the
logarithm of the word's rarity. The similarity of two images is the cosine of their vectors.

The draw depends on the seed and on the images' names, but not on the order of images."""

import concurrent.futures
import contextlib
import hashlib
import json
import os
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.sparse

import aqorb
from aqorb_photographs import InputError, map_ahead, store

WORDS = 65536
MIN_INLIERS = 15  # two images with as many inliers probably show the same place
MIN_PLACES = 10  # two images whose grown matches agree at as many places probably show the same thing
CELL = 16  # pixels: matches in one cell are one place
STRONGEST = 500  # features of an image to look up: strong features reappear more often
FEATURES_OF_A_WORD = 4  # at least, on average: a word that is a feature of one image alone connects nothing
CHUNK = 256  # images that are drawn from at a time
QUERIES = 32  # few; the candidates of as many are read at a time
BLOCK = 2**22  # elements of the similarity matrix in memory at a time
GROWTH = 4  # growth of the collection after which words are drawn anew
COUNTS = pa.schema([('word', store.INTEGERS), ('count', store.FLOATS)])  # of the words of each image


def strongest(descriptors, response, count=STRONGEST):
    """Returns the descriptors of the `count` keypoints of highest response, in their order."""
    if len(response) <= count:
        return descriptors
    return descriptors[np.sort(np.argsort(-np.asarray(response), kind='stable')[:count])]


def images_of(table):
    """Yields the name of each row of a table of features, and the descriptors of its strongest keypoints."""
    for name, response, descriptors in zip(table['name'], table['response'], table['descriptors']):
        rows = np.frombuffer(descriptors.as_buffer(), np.uint8).reshape(-1, 32)
        yield name.as_py(), strongest(rows, response.values.to_numpy())


def choose_words(images, count=WORDS, seed=0):
    """Returns the words of a collection, an array (n, 32) of features drawn at random, all with the same probability.
    images are pairs of a name and descriptors. There are at most count words, and at most one for four features."""
    drawn, total, chunk = (np.zeros(0), np.zeros((0, 32), np.uint8)), 0, []

    def merged():
        keys, rows = (np.concatenate(parts) for parts in zip(drawn, *chunk))
        order = np.argsort(keys, kind='stable')[:count]
        return keys[order], rows[order]

    for name, descriptors in images:
        state = hashlib.sha256(f'{seed} {name}'.encode()).digest()
        keys = np.random.RandomState(np.frombuffer(state, '<u4')).random_sample(len(descriptors))
        chunk.append((keys, descriptors))
        total += len(descriptors)
        if len(chunk) == CHUNK:
            drawn, chunk = merged(), []
    count = min(count, total // FEATURES_OF_A_WORD)
    if not count:
        raise InputError(f'the images have {total} features, too few to find similar images')
    return merged()[1]


def words_of(descriptors, words):
    """Returns the words of an image in ascending order, and their counts."""
    nearest, _ = aqorb.knnMatchArrays(descriptors, words, 1)
    found, counts = np.unique(nearest, return_counts=True)
    return found.astype(np.int32), counts.astype(np.int32)


def look_up(images, words, threads=1):
    """Yields words_of for each image. images are pairs of a name and descriptors."""
    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for _, found in map_ahead(pool, lambda image: words_of(image[1], words), images, 4 * threads):
            yield found


def count_matrix(images, number):
    """Returns the sparse matrix of word counts, one row for each result of words_of. number is the number of words."""
    images = list(images)
    if not images:
        raise InputError('there are no images to count words of')
    indices, counts = zip(*images)
    offsets = np.cumsum([0, *map(len, indices)])
    values = np.concatenate(counts).astype(np.float32)
    return scipy.sparse.csr_matrix((values, np.concatenate(indices), offsets), (len(indices), number))


def rarity_of(counts):
    """Returns the weight of each word: the logarithm of the number of images over the number of images with the
    word."""
    having = np.bincount(counts.indices, minlength=counts.shape[1])
    return np.log((counts.shape[0] + 1) / np.maximum(having, 1)).astype(np.float32)


def weigh(counts, rarity):
    """Returns the vectors of images, of length 1, as rows of a sparse matrix."""
    weights, lengths = counts.copy(), np.sqrt(counts @ rarity.astype(float)**2)
    weights.data = np.sqrt(weights.data) * rarity[weights.indices]
    weights.data /= np.repeat(np.maximum(lengths, 1e-9), np.diff(weights.indptr)).astype(np.float32)
    return weights


def similar(queries, collected, number, min_gap=0):
    """Yields, for blocks of queries, the index of the block's first query and two arrays with a row for each query:
    the indices of the `number` most similar rows of collected, the most similar first, and their similarities. With
    min_gap, query i is row i of collected, and rows less than min_gap away from it have the similarity -1."""
    if not 1 <= number <= collected.shape[0]:
        raise InputError(f'similar images must be from 1 to {collected.shape[0]}, the number of images, got {number}')
    few = queries.shape[0] <= QUERIES  # too few to pay for transposing `collected`
    columns = None if few else collected.T.tocsr()
    step = max(1, BLOCK // collected.shape[0])
    for start in range(0, queries.shape[0], step):
        part = queries[start:start + step]
        table = (collected @ part.T.toarray()).T if few else (part @ columns).toarray()
        for i, row in enumerate(table, start):
            if min_gap:
                row[max(0, i - min_gap + 1):i + min_gap] = -1
        best = np.argpartition(-table, number - 1, 1)[:, :number]
        values = np.take_along_axis(table, best, 1)
        order = np.lexsort((best, -values))
        yield start, np.take_along_axis(best, order, 1), np.take_along_axis(values, order, 1)


def similar_pairs(counts, number, min_gap=1, sequential=0, progress=None):
    """Returns the pairs of each image of a collection with its `number` most similar images and with the `sequential`
    images after it: rows of two indices in ascending order, each pair once. Images without a common word are not
    similar. Calls progress with the number of finished images."""
    total = counts.shape[0]
    weights = weigh(counts, rarity_of(counts))
    pairs = [np.column_stack([np.arange(total - i), np.arange(i, total)]) for i in range(1, min(sequential + 1, total))]
    for start, indices, similarities in similar(weights, weights, number, min_gap):
        queries, found = np.nonzero(similarities > 0)
        pairs.append(np.sort(np.column_stack([start + queries, indices[queries, found]])))
        if progress:
            progress(len(indices))
    return np.unique(np.concatenate(pairs), axis=0)


def ransac(max_error, min_trials):
    """Returns the options of pycolmap's RANSAC, with a fixed seed."""
    import pycolmap
    return pycolmap.RANSACOptions(max_error=max_error, random_seed=0, min_num_trials=min_trials, max_num_trials=1000,
                                  confidence=.999)


def estimate(model, points1, points2, max_error):
    """Finds the matches that agree with one matrix, by pycolmap's LO-RANSAC with a fixed seed. The model is 'F', for a
    fundamental matrix, or 'H', for a homography. points1 and points2 are the matches' positions in pixels. Returns the
    indices of the inliers, and the matrix or None."""
    import pycolmap
    function = pycolmap.estimate_fundamental_matrix if model == 'F' else pycolmap.estimate_homography_matrix
    found = function(points1, points2, ransac(max_error, 100)) if len(points1) >= 8 else None
    if found is None:
        return np.zeros(0, np.int32), None
    return np.flatnonzero(found['inlier_mask']).astype(np.int32), found[model]


def verify(points1, points2, max_error=4.):
    """Finds the matches that agree with one fundamental matrix, as estimate does."""
    return estimate('F', points1, points2, max_error)


def count_places(points1, points2):
    """Returns how many places of two images the matches show: cells with a match, in the image that has fewer."""
    return min(len(np.unique(np.floor_divide(points, CELL), axis=0)) for points in (points1, points2))


def grow(pictures, features, ratio=.8):
    """Matches the features of two grey images, finds more matches near these, and returns their positions in both."""
    (keypoints1, descriptors1), (keypoints2, descriptors2) = features
    pairs, _ = aqorb.matchArrays(descriptors1, descriptors2, ratio)
    _, *ends, _ = aqorb.growMatchArrays(pictures[0], keypoints1, pictures[1], keypoints2, pairs)
    return ends


class Agreement(NamedTuple):
    """The grown matches of two images that agree on one geometry, the number of places of those that agree on the
    homography, and both matrices or None."""
    inliers: np.ndarray
    places: int
    homography: np.ndarray
    fundamental: np.ndarray

    @property
    def is_same(self):
        """Whether the images probably show the same thing."""
        return self.places >= MIN_PLACES


def agreement(points1, points2, max_error=1.5):
    """Finds the grown matches that agree. Wrong ones seldom agree on a homography in many places; on a fundamental
    matrix they do. So the homography says whether images show the same thing, and the matrix then has the matches that
    lie beside its plane."""
    inliers, homography = estimate('H', points1, points2, max_error)
    found = Agreement(inliers, count_places(points1[inliers], points2[inliers]), homography, None)
    if not found.is_same:
        return found
    more, fundamental = estimate('F', points1, points2, max_error)
    return found._replace(inliers=max(inliers, more, key=len), fundamental=fundamental)


def match(first, second, ratio=None, max_distance=None, is_verified=True):
    """Matches two images, each given by its positions and descriptors. Returns the columns of aqorb match: indices
    of the matches in both images, their distances, the indices of the inliers, and the elements of the fundamental
    matrix."""
    matches, distances = aqorb.matchArrays(first[1], second[1], ratio, True, max_distance)
    inliers, F = verify(first[0][matches[:, 0]], second[0][matches[:, 1]]) if is_verified else ((), None)
    return matches[:, 0], matches[:, 1], distances, inliers, () if F is None else F.ravel()


class Index:
    """Words of the features in a folder and their counts in each image, kept in a folder beside it. Opening an index
    looks up the images of new parts. It draws words if there are none, if the options differ, or if the collection
    has grown GROWTH times. Calls progress(label, total) for a progress bar."""

    def __init__(self, features, number=None, seed=None, threads=1, progress=None):
        self.folder = os.path.realpath(features.folder) + '.index'
        self._progress, self.is_kept = progress, True
        table = self._read('words.parquet')
        how = json.loads(table.schema.metadata[b'aqorb']) if table else {}
        wanted = {'words': number or how.get('words', WORDS), 'seed': how.get('seed', 0) if seed is None else seed}
        if any(how.get(name) != value for name, value in wanted.items()) or (
                len(features.images) >= GROWTH * how['images']):
            images = self._each(features, range(len(features.names)), 'drawing words')
            words = choose_words(images, wanted['words'], wanted['seed'])
            how = json.dumps(dict(wanted, images=len(features.images)))
            table = pa.table([pa.array(list(map(bytes, words)), pa.binary(32))], ['word'], metadata={'aqorb': how})
            self._keep('words.parquet', table)
        self.words = np.frombuffer(table['word'].combine_chunks().buffers()[1], np.uint8).reshape(-1, 32)
        self.counts = self._read_counts(features, threads)[features.chosen]

    def _read(self, name):
        """Returns a table of the folder, or None if it is missing or damaged."""
        with contextlib.suppress(Exception):
            return pq.read_table(os.path.join(self.folder, name), page_checksum_verification=True)

    def _each(self, features, parts, label):
        """Yields the name and the descriptors of each image of the parts."""
        update = self._progress(label, int(np.isin(features.part, list(parts)).sum())) if self._progress else int
        for part in parts:
            for table in features.groups(part):
                for image in images_of(table):
                    yield image
                    update()

    def _keep(self, name, table):
        try:
            store.write_part(self.folder, table, name, len(table))
        except OSError:  # a full or read-only disk: the next search works again
            self.is_kept = False

    def _read_counts(self, features, threads):
        """Returns the word counts of all rows of the features."""
        digest = hashlib.blake2b(self.words, digest_size=8).hexdigest()
        tables = [self._read(f'{digest}-{name}') for name in features.names]
        new = [part for part, table in enumerate(tables) if table is None]
        found = look_up(self._each(features, new, 'looking up'), self.words, threads)
        for part in new:
            rows = [next(found) for _ in range(int((features.part == part).sum()))]
            words, counts = zip(*rows) if rows else ((), ())
            tables[part] = pa.table([words, counts], schema=COUNTS)
            self._keep(f'{digest}-{features.names[part]}', tables[part])
        with contextlib.suppress(OSError):  # removes tables of parts that are gone
            store.clean(self.folder)
            kept = {'words.parquet', *(f'{digest}-{name}' for name in features.names)}
            for name in set(store.parts_in(self.folder)) - kept:
                os.remove(os.path.join(self.folder, name))
        table = pa.concat_tables([COUNTS.empty_table(), *tables])
        words, counts = (table[name].combine_chunks() for name in COUNTS.names)
        offsets = np.cumsum([0, *words.value_lengths().to_numpy()])
        return scipy.sparse.csr_matrix((counts.flatten().to_numpy(), words.flatten().to_numpy(), offsets),
                                       (len(table), len(self.words)))


def search(queries, features, index, number, ratio=.8, threads=1):
    """Yields, for each row of a table of features, a list of the `number` most similar images, in the order of their
    inliers: images of the same place come first. An element has the numbers of inliers and matches, the index of the
    image, and the positions of the inliers in both images."""
    weight = rarity_of(index.counts)
    asked = weigh(count_matrix(look_up(images_of(queries), index.words, threads), len(index.words)), weight)

    def compare(item):
        image, query, other = item
        index1, index2, _, inliers, _ = match(query, other, ratio)
        return len(inliers), len(index1), image, query[0][index1[inliers]], other[0][index2[inliers]]

    def candidates():
        for start, indices, _ in similar(asked, weigh(index.counts, weight), number):
            for query, images in enumerate(indices, start):
                if (query - start) % QUERIES == 0:
                    read = features.read(indices[query - start:query - start + QUERIES])
                photograph = store.keypoints_of(queries.slice(query, 1))
                for image in images:
                    yield image, photograph, read[image]

    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        compared = (found for _, found in map_ahead(pool, compare, candidates(), 4 * threads))
        for _ in range(len(queries)):
            # A stable sort: among images with equal inliers the more similar image comes first.
            yield sorted([next(compared) for _ in range(number)], key=lambda one: -one[0])


def ahead(found, features, ratio=.8):
    """Returns as text how many times as many inliers the best image of a list of search has as the best image of
    another place, which has fewer than MIN_INLIERS inliers with the best image; - if there is no such image."""
    best = features.keypoints(found[0][2])
    for inliers, _, image, *_ in found[1:]:
        if len(match(best, features.keypoints(image), ratio)[3]) < MIN_INLIERS:
            return f'{found[0][0] / max(inliers, 1):.1f}'
    return '-'
