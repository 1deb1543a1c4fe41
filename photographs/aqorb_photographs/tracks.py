# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tracks: keypoints of several images that show the same spot, refined against one reference keypoint.

refineMatches refines each pair of images by itself, and the positions of a keypoint differ by .1 to .2 pixels between
pairs. A bundle adjustment needs one position for each keypoint, so refine aligns all keypoints of a track with the same
reference."""

import functools

import numpy as np
import scipy.sparse.csgraph

import aqorb
from aqorb_photographs import InputError, images, places, store

IN_MEMORY = 64  # images
MAX_ERROR = 1.  # distance of a refined position from its epipolar line, in pixels of the reduced image


def refine(features, matches, folder):
    """Joins the inliers of verified matches to tracks, and aligns each keypoint with the reference of its track.
    folder has the images. Returns the positions of each image's keypoints and, for each pair of images, the refined
    matches that agree on one fundamental matrix, and this matrix or None."""
    if not (matches.parameters() or {}).get('verified'):
        raise InputError(f'{matches.folder} must have verified matches, for --refine')
    how = store.detector_of(features.parameters())[1]
    sizes = list(zip(features.value('width'), features.value('height')))
    scales = [np.divide(images.smaller(size, how.max_size), size) for size in sizes]
    keypoints = [keypoints_of(features.of(image), scale) for image, scale in enumerate(scales)]
    first = np.cumsum([0, *map(len, keypoints)])  # keypoints are numbered through all images
    edges = [inliers_of(matches.of(pair)) + first[ends] for pair, ends in enumerate(matches.pairs)]
    positions = np.concatenate([found['pt'] for found in keypoints])
    is_refined = np.zeros(len(positions), bool)

    @functools.lru_cache(IN_MEMORY)
    def read(image):
        return images.read_file(features.path(image, folder), how).pixels

    references = references_of(np.concatenate(edges), np.concatenate([found['octave'] for found in keypoints]))
    for base, other, references, moved in by_images(references, first):
        pairs = np.column_stack([references, moved]) - first[[base, other]]
        pairs, _, points = aqorb.refineMatchArrays(read(base), keypoints[base], read(other), keypoints[other], pairs)
        aligned = pairs + first[[base, other]]
        positions[aligned[:, 1]] = points
        is_refined[aligned] = True
    for image, scale in enumerate(scales):
        part = slice(*first[image:image + 2])
        positions[part] = (positions[part] + .5) / scale - .5

    def verified(ends, rows):
        rows = rows[is_refined[rows].all(1)]
        max_error = MAX_ERROR / min(scales[end].min() for end in ends)
        agree, fundamental = places.verify(positions[rows[:, 0]], positions[rows[:, 1]], max_error)
        return rows[agree] - first[ends], fundamental

    return np.split(positions, first[1:-1]), [verified(*pair) for pair in zip(matches.pairs, edges)]


def keypoints_of(found, scale):
    """Returns keypoints from the columns of an image's features, in pixels of the reduced image of their detection."""
    keypoints = np.zeros(len(found['x']), aqorb.keypoint_dtype)
    keypoints['pt'] = (np.column_stack([found['x'], found['y']]) + .5) * scale - .5
    keypoints['size'] = found['size'] * scale.mean()
    keypoints['angle'], keypoints['octave'] = found['angle'], found['octave']
    return keypoints


def inliers_of(found):
    """Returns the inliers of a pair of images, as rows of two indices."""
    return np.column_stack([found['index1'], found['index2']])[found['inliers']].astype(np.int64)


def references_of(edges, octaves):
    """Returns the reference of each keypoint's track: the keypoint with the most matches; among several, the one on the
    finest octave. edges are the matches of all images, as rows of two keypoint numbers."""
    count = len(octaves)
    graph = scipy.sparse.coo_matrix((np.ones(len(edges), bool), tuple(edges.T)), (count, count))
    track = scipy.sparse.csgraph.connected_components(graph, False)[1]
    order = np.lexsort((octaves, -np.bincount(edges.ravel(), minlength=count), track))
    return order[np.flatnonzero(np.diff(track[order], prepend=-1))][track]


def by_images(references, first):
    """Yields, for pairs of images, both indices, references in the first image, and the keypoints of the second image
    that refer to these."""
    image_of = np.repeat(np.arange(len(first) - 1), np.diff(first))
    moved = np.flatnonzero(image_of[references] != image_of)
    moved = moved[np.lexsort((image_of[moved], image_of[references[moved]]))]
    ends = np.column_stack([image_of[references[moved]], image_of[moved]])
    for part in np.split(moved, np.flatnonzero(np.diff(ends, axis=0).any(1)) + 1):
        if len(part):
            yield image_of[references[part[0]]], image_of[part[0]], references[part], part
