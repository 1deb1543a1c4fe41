#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Matches each image with the most similar ones, as aqorb match --pairs retrieval:K does, by a pipeline of Ray Data.
The features are those of ray_features.py or of aqorb extract. The result is a folder of parts, as aqorb match writes
them, with the same rows. Needs aqorb-photographs and ray[data], on each machine of a cluster."""

import argparse
import os
import sys

import numpy as np
try:
    import pyarrow as pa
    import ray
    import ray.data
except ImportError as error:
    sys.exit(f"{error}. This sample also needs: pip install 'ray[data]'")

import aqorb
from aqorb_photographs import places, store


def draw(batch, count, seed):
    """A sample of the descriptors of a batch of images: a row."""
    keys, descriptors, total = places.draw(places.images_of(batch), count, seed)
    return pa.table({'keys': [keys.tobytes()], 'descriptors': [descriptors.tobytes()], 'total': [total]})


def merge(draws, count):
    """Goes through draws so that the samples of two of them are in memory at a time."""
    keys, descriptors, total = np.zeros(0), np.zeros((0, 32), np.uint8), 0
    for row in draws:
        keys = np.concatenate([keys, np.frombuffer(row['keys'])])
        descriptors = np.concatenate([descriptors, np.frombuffer(row['descriptors'], np.uint8).reshape(-1, 32)])
        order = np.argsort(keys, kind='stable')[:count]
        keys, descriptors, total = keys[order], descriptors[order], total + row['total']
    return places.choose_words([(keys, descriptors, total)], count)


def look_up(batch, words):
    """The words of each image of a batch, and how often it has them."""
    aqorb.setNumThreads(1)  # a task has a processor
    words = ray.get(words)
    images = list(places.images_of(batch))
    found = list(zip(*(places.words_of(descriptors, words) for _, descriptors in images)))
    return pa.table({'name': [name for name, _ in images], 'words': found[0], 'counts': found[1]})


@ray.remote
def similar(weights, first, rows, number, min_gap):
    """The pairs of the images first to first + rows - 1."""
    blocks = places.similar(weights[first:first + rows], weights, number, min_gap, first)
    return places.pairs_of(((first + start, *found) for start, *found in blocks), weights.shape[0])


def match(batch, folder, ratio):
    """The verified matches of a batch of pairs of names, whose features are read from the parts."""
    aqorb.setNumThreads(1)
    features = store.Features(folder)
    pairs = np.array([[features.index[name] for name in batch[side].to_pylist()] for side in ('name1', 'name2')]).T
    read = {image: features.keypoints(image) for image in np.unique(pairs)}
    found = [places.match(read[first], read[second], ratio) for first, second in pairs]
    return store.to_matches(features, pairs, found, {'ratio': ratio, 'max_distance': None, 'verified': True})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--address', help='of a cluster, such as auto or ray://head:10001; this machine by default')
    parser.add_argument('--out', required=True, metavar='FOLDER', help='new folder for the result')
    parser.add_argument('--retrieval', type=int, default=20, metavar='K', help='most similar images (%(default)s)')
    parser.add_argument('--min-gap', type=int, default=1)
    parser.add_argument('--words', type=int, default=places.WORDS)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--ratio', type=float, default=.8)
    parser.add_argument('--batch', type=int, default=4096, help='images or pairs of a task (%(default)s)')
    parser.add_argument('features', metavar='FEATURES', help='folder that all machines can read')
    options = parser.parse_args()
    if os.path.exists(options.out):
        sys.exit(f'{options.out} exists')
    ray.init(options.address)
    how = {'batch_size': options.batch, 'batch_format': 'pyarrow'}
    folder = os.path.abspath(options.features)
    features = ray.data.read_parquet(folder, columns=['name', 'response', 'descriptors'])

    draws = features.map_batches(draw, fn_args=(options.words, options.seed), **how)
    words = merge(draws.iter_rows(), options.words)
    looked_up = features.map_batches(look_up, fn_args=(ray.put(words),), **how)
    rows = sorted(((row['name'], row['words'], row['counts']) for row in looked_up.iter_rows()), key=lambda row: row[0])
    names = [row[0] for row in rows]
    counts = places.count_matrix([row[1:] for row in rows], len(words))
    weights = ray.put(places.weigh(counts, places.rarity_of(counts)))

    blocks = [similar.remote(weights, first, options.batch, options.retrieval, options.min_gap)
              for first in range(0, len(names), options.batch)]
    pairs = np.unique(np.concatenate(ray.get(blocks)), axis=0)
    columns = [pa.array([names[i] for i in side]) for side in pairs.T]
    named = ray.data.from_arrow(pa.table(columns, ['name1', 'name2'])).repartition(max(1, len(pairs) // options.batch))
    named.map_batches(match, fn_args=(folder, options.ratio), **how).write_parquet(options.out)


if __name__ == '__main__':
    main()
