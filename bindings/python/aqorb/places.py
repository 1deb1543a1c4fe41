# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Which images show the same place: a bag of words over ORB's descriptors, on NumPy and scipy.sparse.

    words = places.words([places.draw(images)])          # images: pairs of a path, as bytes, and descriptors
    counts = places.count(places.look_up(images, words), len(words))
    pairs, weights = places.similar_pairs(counts, 5)     # each image with the five most similar ones
    inliers, F = places.verify(points1, points2)         # of two images: the matches that agree on a geometry

Words are descriptors of the collection itself, drawn at random. The word of a feature is the nearest one. An image has
a vector with an element for each word: the square root of how often the image has it, times the logarithm of how rare
it is. The similarity of two images is the cosine of their vectors.

What is drawn depends on the seed and on the path of each image, but not on the order of images. A collection can
therefore be drawn from in parts, on several machines."""

import concurrent.futures
import hashlib

import numpy as np
import scipy.sparse

import aqorb
from aqorb import collection

WORDS = 65536
STRONGEST = 500  # features of an image that are looked up: they are found again more often than the others
FEATURES_OF_A_WORD = 4  # at least, on average: a word that is a feature of one image alone connects nothing
CHUNK = 256  # images that are drawn from at a time
QUERIES = 32  # for which the candidates are read at a time
BLOCK = 2**22  # elements of the matrix of similarities that are in memory at a time


def strongest(descriptors, response=None, count=STRONGEST):
    """The descriptors of the keypoints with the greatest responses, in their order; without responses all of them."""
    if response is None or len(response) <= count:
        return descriptors
    return descriptors[np.sort(np.argsort(-np.asarray(response), kind='stable')[:count])]


def images_of(table):
    """Yields the path of each row of a table of aqorb.collection, and the descriptors of its strongest keypoints."""
    for path, response, descriptors in zip(table['path'], table['response'], table['descriptors']):
        rows = np.frombuffer(descriptors.as_buffer(), np.uint8).reshape(-1, 32)
        yield path.as_py(), strongest(rows, response.values.to_numpy())


def draw(images, count=WORDS, seed=0):
    """Draws features at random, all with the same probability. images are pairs of a path, as bytes, and descriptors.
    Returns a random number for each feature that was drawn, their descriptors, and how many features there were."""
    drawn, total, chunk = (np.zeros(0), np.zeros((0, 32), np.uint8)), 0, []

    def merged():
        keys, rows = (np.concatenate(parts) for parts in zip(drawn, *chunk))
        order = np.argsort(keys, kind='stable')[:count]
        return keys[order], rows[order]

    for path, descriptors in images:
        state = hashlib.sha256(b'%d ' % seed + path).digest()
        keys = np.random.RandomState(np.frombuffer(state, '<u4')).random_sample(len(descriptors))
        chunk.append((keys, descriptors))
        total += len(descriptors)
        if len(chunk) == CHUNK:
            drawn, chunk = merged(), []
    return (*merged(), total)


def words(draws, count=WORDS):
    """The words of a collection, an array (n, 32): those of the draws from its parts that are drawn first. There are at
    most count, and at most one for every four features."""
    keys, descriptors, totals = zip(*draws)
    count = min(count, sum(totals) // FEATURES_OF_A_WORD)
    if not count:
        raise ValueError(f'the images have {sum(totals)} features, too few to find similar images by')
    return np.concatenate(descriptors)[np.argsort(np.concatenate(keys), kind='stable')[:count]]


def check_words(words, name='words'):
    """Raises ValueError if an array cannot be words."""
    if words.dtype != np.uint8 or words.ndim != 2 or words.shape[1] != 32 or not len(words):
        raise ValueError(f'{name} must be descriptors of 32 bytes, uint8 of shape (n, 32), got {words.dtype} of shape '
                         f'{words.shape}')


def words_of(descriptors, words):
    """The words of an image, in ascending order, and how often it has each."""
    if not len(descriptors):
        return np.zeros(0, np.int32), np.zeros(0, np.int32)
    nearest, _ = aqorb.knnMatchArrays(descriptors, words, 1)
    found, counts = np.unique(nearest, return_counts=True)
    return found.astype(np.int32), counts.astype(np.int32)


def look_up(images, words, threads=1):
    """Yields what words_of gives for each image. images are pairs of a path and descriptors."""
    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for _, found in collection.map_ahead(pool, lambda image: words_of(image[1], words), images, 4 * threads):
            yield found


def count(images, number):
    """The matrix of what words_of gave for each image: how often it has each word, of which there are that many."""
    images = list(images)
    if not images:
        raise ValueError('there are no images whose words could be counted')
    indices, counts = zip(*images)
    offsets = np.cumsum([0, *map(len, indices)])
    values = np.concatenate(counts).astype(np.float32)
    return scipy.sparse.csr_matrix((values, np.concatenate(indices), offsets), (len(indices), number))


def rarity(counts):
    """The weight of each word: the logarithm of the number of images over the number of those that have it."""
    having = np.bincount(counts.indices, minlength=counts.shape[1])
    return np.log((counts.shape[0] + 1) / np.maximum(having, 1)).astype(np.float32)


def weigh(counts, rarity):
    """The vectors of images, of length 1, as rows of a sparse matrix."""
    weights = counts.copy()
    weights.data = np.sqrt(weights.data) * rarity[weights.indices]
    lengths = np.sqrt(np.bincount(np.repeat(np.arange(weights.shape[0]), np.diff(weights.indptr)),
                                  weights.data.astype(float)**2, weights.shape[0]))
    weights.data /= np.repeat(np.maximum(lengths, 1e-9), np.diff(weights.indptr)).astype(np.float32)
    return weights


def similar(queries, collected, number, min_gap=0, first=0):
    """Yields for blocks of rows of queries the index of the first one, and two arrays with a row for each: the indices
    of the most similar rows collected, that many, best first, and their similarities. With min_gap the query i is row
    first + i of those collected, and rows that are nearer than that, or itself, have the similarity -1."""
    if not 1 <= number <= collected.shape[0]:
        raise ValueError(f'similar images must be from 1 to {collected.shape[0]}, the number of images, got {number}')
    columns = collected.T.tocsr()
    step = max(1, BLOCK // collected.shape[0])
    for start in range(0, queries.shape[0], step):
        table = (queries[start:start + step] @ columns).toarray()
        for i, row in enumerate(table, first + start):
            if min_gap:
                row[max(0, i - min_gap + 1):i + min_gap] = -1
        best = np.argpartition(-table, number - 1, 1)[:, :number]
        values = np.take_along_axis(table, best, 1)
        order = np.lexsort((best, -values))
        yield start, np.take_along_axis(best, order, 1), np.take_along_axis(values, order, 1)


def pairs(blocks, number):
    """The pairs of similar images of a collection with that many, from what similar gave: each once, as rows of two
    indices in ascending order. Images without a word in common make no pair."""
    codes = [np.zeros(0, np.int64)]
    for start, indices, similarities in blocks:
        rows = np.arange(start, start + len(indices))[:, None] + np.zeros_like(indices)
        least, greatest = np.minimum(rows, indices), np.maximum(rows, indices)
        codes.append((least.astype(np.int64) * number + greatest)[similarities > 0])
    return np.column_stack(np.divmod(np.unique(np.concatenate(codes)), max(1, number)))


def similar_pairs(counts, number, min_gap=1, sequential=0, progress=None):
    """The pairs of each image of a collection with that many similar ones, and with so many that follow it: rows of two
    indices in ascending order, each pair once. Returns the vectors, too. Neither grows with the square of the
    collection. progress is called with the number of images that are done."""
    total = counts.shape[0]
    weights = weigh(counts, rarity(counts))

    def blocks():
        for block in similar(weights, weights, number, min_gap):
            yield block
            if progress:
                progress(len(block[1]))

    following = [np.column_stack([np.arange(total - i), np.arange(i, total)])
                 for i in range(1, min(sequential + 1, total))]
    return np.unique(np.concatenate([pairs(blocks(), total), *following]), axis=0), weights


def similarities(weights, pairs, step=4096):
    """The similarity of the two images of each pair."""
    parts = [weights[part[:, 0]].multiply(weights[part[:, 1]]).sum(1) for part in
             np.split(pairs, range(step, len(pairs), step))]
    return np.concatenate([np.asarray(part).ravel() for part in parts])


def verify(points1, points2, max_error=4.):
    """Of matches, given by the positions in pixels in both images, the indices of those that agree with one fundamental
    matrix, and the matrix, or None. It is pycolmap's LO-RANSAC, with a fixed seed."""
    import pycolmap
    if len(points1) < 8:
        return np.zeros(0, np.int32), None
    options = pycolmap.RANSACOptions()
    options.max_error, options.random_seed = max_error, 0
    options.min_num_trials, options.max_num_trials, options.confidence = 100, 1000, .999
    found = pycolmap.estimate_fundamental_matrix(points1, points2, options)
    if found is None:
        return np.zeros(0, np.int32), None
    return np.flatnonzero(found['inlier_mask']).astype(np.int32), found['F']


def match(first, second, ratio=None, max_distance=None):
    """The verified matches of two images, of each of which the positions and the descriptors are given, as a row of the
    file of aqorb match has them: the indices of matches in both images, their distances, the indices of the inliers
    among them, and the elements of the fundamental matrix."""
    matches, distances = aqorb.matchArrays(first[1], second[1], ratio, True, max_distance)
    inliers, F = verify(first[0][matches[:, 0]], second[0][matches[:, 1]])
    return matches[:, 0], matches[:, 1], distances, inliers, () if F is None else F.ravel()


def extract_alike(paths, open_file, metadata, threads=1):
    """The features of images, made as those of a file of which the metadata is given: what aqorb.collection.extract
    returns. An image without features is among those that are not in the table."""
    detector = aqorb.AdaptiveQuadtreeORB_create()
    for name, value in metadata['parameters'].items():
        getattr(detector, 'set' + name)(value)
    table, failures = collection.extract(paths, open_file, detector, metadata['max size'],
                                         metadata['EXIF orientation'], threads)
    kept = [len(row) > 0 for row in table['x']]
    failures += [(path.as_py(), 'it has no features') for path, is_kept in zip(table['path'], kept) if not is_kept]
    return table.filter(np.array(kept, bool)), failures  # a list that is empty has no type


def search(queries, features, words, counts, number, ratio=.8, threads=1):
    """Yields for each row of a table of features a list of that many images of an aqorb.files.Features, those that show
    the same place first: the most similar ones, in the order of their inliers. An element is how many inliers and how
    many matches there are, the index of the image, and the positions of the inliers in both. counts is of the words of
    the features."""
    weight = rarity(counts)
    asked = weigh(count(look_up(images_of(queries), words, threads), len(words)), weight)

    def compare(item):
        image, query, other = item
        index1, index2, _, inliers, _ = match(query, other, ratio)
        return len(inliers), len(index1), image, query[0][index1[inliers]], other[0][index2[inliers]]

    def candidates():
        for start, indices, _ in similar(asked, weigh(counts, weight), number):
            for query, images in enumerate(indices, start):
                if (query - start) % QUERIES == 0:  # in the order of the file, of which reading an image reads many
                    read = {image: features.keypoints(image)
                            for image in np.unique(indices[query - start:query - start + QUERIES])}
                row = queries.slice(query, 1)
                positions = np.column_stack([row[name].combine_chunks().flatten().to_numpy() for name in ('x', 'y')])
                keypoints = positions, collection.descriptors_of(row['descriptors'])
                for image in images:
                    yield image, keypoints, read[image]

    with features.opened(), concurrent.futures.ThreadPoolExecutor(threads) as pool:
        compared = (found for _, found in collection.map_ahead(pool, compare, candidates(), 4 * threads))
        for _ in range(len(queries)):
            # Stable: of images with as many inliers the more similar one comes first.
            yield sorted([next(compared) for _ in range(number)], key=lambda one: -one[0])
