# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tracks: positions of a spot in several images, all aligned to one patch, for an exact bundle adjustment.

Each track is a star: a keypoint, the reference, with its aligned positions in other images. Aligning keypoints pair by
pair would give each keypoint positions that differ by .1 to .2 pixels between pairs.

    aligned = tracks.align(image1, keypoints1, image2, keypoints2, pairs)     # both ways, for each pair of images
    kept, matrix = tracks.verify(*aligned, camera1, camera2, .25)             # of pycolmap.Camera
    tracks, positions = tracks.join({(0, 1): kept[0], (1, 0): kept[1], ...}, sizes, [1.5] * len(sizes))

Keypoints may be those of any detector that gives sizes and angles. Positions are in OpenCV's pixel coordinates."""

import concurrent.futures
import os
import typing

import numpy as np
import pyarrow as pa
import scipy.sparse
import scipy.sparse.csgraph

import aqorb
from aqorb_photographs import InputError, images, map_ahead, places, store

# In pixels of the image that the features were detected in, which may be reduced:
UNCERTAIN = .35  # a position of a larger standard deviation is left out
MAX_ERROR = .25  # distance from the epipolar line
DETECTED = 4.  # the same of a match as detected
APART = 1.5  # least distance of two tracks
MIN_INLIERS = 40  # of a pair of images, with both directions
MEMORY = 2**30  # bytes of decoded images
PART_SIZE = 1024  # pairs after which aligned positions are saved
PARAMETERS = {'max_deviation': UNCERTAIN}
GROWN = pa.schema([*store.MATCHES][:5] + [('index', store.INTEGERS), ('x', store.FLOATS), ('y', store.FLOATS)])


class Aligned(typing.NamedTuple):
    """Keypoints of an image that were found in another one: their indices, their positions, and their positions in the
    other image, arrays (n, 2)."""

    index: np.ndarray
    own: np.ndarray
    other: np.ndarray

    def of(self, kept):
        return Aligned(*(column[kept] for column in self))


class Grown(store.Matches):
    """Aligned positions in a folder. A row has the indices of keypoints of the first image, and their positions in the
    second one. Each pair of images has two rows, one for each order."""

    kind, schema = 'aligned positions', GROWN

    def codes(self, pairs):
        return pairs[:, 0] * np.int64(self._count) + pairs[:, 1]


def align(image1, keypoints1, image2, keypoints2, pairs, scale_factor=1.):
    """Grows matches both ways. pairs are indices of keypoints, arrays of aqorb.keypoint_dtype, and scale_factor is that
    of growMatchArrays. Returns the Aligned of both images."""
    def one_way(image1, keypoints1, image2, keypoints2, pairs):
        found, own, other, deviations = aqorb.growMatchArrays(image1, keypoints1, image2, keypoints2, pairs,
                                                              scaleFactor=scale_factor, bothWays=False)
        return Aligned(found[:, 0], own, other).of(deviations <= UNCERTAIN)

    return (one_way(image1, keypoints1, image2, keypoints2, pairs),
            one_way(image2, keypoints2, image1, keypoints1, np.ascontiguousarray(pairs[:, ::-1])))


def verify(first, second, camera1, camera2, max_error, is_known=True, min_inliers=MIN_INLIERS):
    """Finds the positions of both Aligned of a pair that agree within max_error pixels on an essential matrix or, if
    the intrinsics of the pycolmap.Camera of both images are not known, on a fundamental matrix. Returns both Aligned
    with these positions and COLMAP's two-view geometry, or None if there are fewer than min_inliers."""
    import pycolmap
    # The centre of the first pixel is (0.5, 0.5) for COLMAP.
    points1, points2 = (np.concatenate(ends) + .5 for ends in
                        ((first.own, second.other), (first.other, second.own)))
    if len(points1) < max(8, min_inliers):
        return None
    options = places.ransac(max_error, 30)
    if is_known:
        found = pycolmap.estimate_essential_matrix(points1, points2, camera1, camera2, options)
    else:
        found = pycolmap.estimate_fundamental_matrix(points1, points2, options)
    kept = found['inlier_mask'] if found else np.zeros(len(points1), bool)
    if kept.sum() < min_inliers:
        return None
    kind = 'CALIBRATED' if is_known else 'UNCALIBRATED'
    geometry = pycolmap.TwoViewGeometry(config=getattr(pycolmap.TwoViewGeometryConfiguration, kind),
                                        E=found.get('E'), F=found.get('F'))
    return first.of(kept[:len(first.own)]), second.of(kept[len(first.own):]), geometry


class Squares:
    """Positions in an image, in squares whose side is the least distance of two positions."""

    def __init__(self, side):
        self._side, self._squares = side, {}

    def is_free(self, x, y):
        column, row = x // self._side, y // self._side
        return all((x - other_x)**2 + (y - other_y)**2 >= self._side**2
                   for i in (column - 1, column, column + 1) for j in (row - 1, row, row + 1)
                   for other_x, other_y in self._squares.get((i, j), ()))

    def add(self, x, y):
        self._squares.setdefault((x // self._side, y // self._side), []).append((x, y))


def join(aligned, sizes, apart):
    """Joins positions to tracks. aligned has an Aligned for ordered pairs of images, sizes an array of the sizes of
    each image's keypoints, and apart the least distance of two tracks in each image, in pixels.

    The keypoint with the most partners comes first; among several the smallest one, then that of the first image. It is
    the reference of a track with its positions in its partners. Positions near one of an earlier track are left out,
    and with a reference its track. Returns for each image the numbers of its tracks, ascending, and its positions in
    them."""
    first = np.cumsum([0, *map(len, sizes)])
    ends = [pair for pair in sorted(aligned) if len(aligned[pair].index)]
    tracks, positions, taken = [[] for _ in sizes], [[] for _ in sizes], list(map(Squares, apart))
    if ends:
        reference = np.concatenate([aligned[pair].index + first[pair[0]] for pair in ends])
        order = np.lexsort((reference, np.concatenate(sizes)[reference], -np.bincount(reference)[reference]))
        image1, image2 = np.repeat(ends, [len(aligned[pair].index) for pair in ends], 0)[order].T
        own, other = (np.concatenate([getattr(aligned[pair], name) for pair in ends])[order]
                      for name in ('own', 'other'))
        starts = np.flatnonzero(np.diff(reference[order], prepend=-1, append=-1)).tolist()
        for track, (start, stop) in enumerate(zip(starts, starts[1:])):
            image, point = int(image1[start]), tuple(own[start].tolist())
            if taken[image].is_free(*point):
                found = [(image, point)] + [
                    (partner, tuple(place)) for partner, place in
                    zip(image2[start:stop].tolist(), other[start:stop].tolist()) if taken[partner].is_free(*place)]
                for image, point in found if len(found) > 1 else ():
                    taken[image].add(*point)
                    tracks[image].append(track)
                    positions[image].append(point)
    return [np.array(each, int) for each in tracks], [np.reshape(each, (-1, 2)) for each in positions]


def shared(tracks, geometries):
    """Yields the pairs of images that share at least places.MIN_INLIERS tracks of join: both indices, and COLMAP's
    two-view geometry with the matches. geometries has those of verify."""
    for (i, j), geometry in geometries.items():
        rows = np.column_stack(np.intersect1d(tracks[i], tracks[j], True, True)[1:])
        if len(rows) >= places.MIN_INLIERS:
            geometry.inlier_matches = rows.astype(np.uint32)
            yield i, j, geometry


# Of the pairs of a collection

def check_files(features, folder):
    """Raises InputError unless the folder has the images of the features. Copies of these may be of another time."""
    for image, (size, time) in enumerate(zip(features.value('file_size'), features.value('file_time'))):
        path, original = features.path(image, folder), features.path(image)
        if not os.path.exists(path):
            raise InputError(f'{path} is missing: to forget it, run aqorb extract with --out {features.folder} --prune')
        state = os.stat(path)
        is_original = os.path.exists(original) and os.path.samefile(path, original)
        if size not in (None, state.st_size) or is_original and time not in (None, state.st_mtime_ns):
            raise InputError(f'{path} has changed since its features were extracted: run aqorb extract with --out '
                             f'{features.folder}, then aqorb match')


def scales_of(features, how):
    """Returns the sizes of images, and the scale of both axes in detection."""
    sizes = list(zip(features.value('width'), features.value('height')))
    return sizes, [np.divide(images.smaller(size, how.max_size), size) for size in sizes]


def keypoints_of(found, scale):
    """Returns keypoints from the columns of an image's features, in pixels of the reduced image of their detection."""
    keypoints = np.zeros(len(found['x']), aqorb.keypoint_dtype)
    keypoints['pt'] = (np.column_stack([found['x'], found['y']]) + .5) * scale - .5
    keypoints['size'] = found['size'] * scale.mean()
    keypoints['angle'], keypoints['octave'] = found['angle'], found['octave']
    return keypoints


def grow(features, matches, folder, threads=1, part_size=PART_SIZE, progress=None):
    """Aligns the keypoints of each pair of matches. Saves them after part_size pairs in a folder beside the matches;
    later calls, by other processes too, do what is missing there. folder has the images. progress(total) returns a
    function to call after each pair."""
    check_files(features, folder)
    how = store.detector_of(features.parameters())[1]
    sizes, scales = scales_of(features, how)
    out, wanted = folder_of(matches), np.sort(matches.pairs, 1)
    grown = Grown(out, features)
    grown.agree(PARAMETERS)
    new = wanted[~np.isin(grown.codes(wanted), grown.known)]
    # The images of a block of pairs are in memory.
    half = max(1, MEMORY // 2 // max(int(np.prod(size * scale)) for size, scale in zip(sizes, scales)))
    new = new[np.lexsort((*new.T[::-1], *(new // half).T[::-1]))]
    update = progress(len(new)) if progress else int
    aqorb.setNumThreads(1)  # one thread for each pair

    def read(image, found):
        path = features.path(image, folder)
        picture = images.read_file(path, how)
        if picture.size != sizes[image]:
            raise InputError(f'{path} must have {" x ".join(map(str, sizes[image]))} pixels, like its features: run '
                             f'aqorb extract with --out {features.folder}, then aqorb match')
        return picture.pixels, keypoints_of(found, scales[image]), found['descriptors']

    def align_pair(pair):
        first, second = (decoded[image].result() for image in pair)
        both = align(*first[:2], *second[:2], aqorb.matchArrays(first[2], second[2], crossCheck=True)[0])
        return [(one.index, *((one.other + .5) / scales[partner] - .5).astype(np.float32).T)
                for one, partner in zip(both, pair[::-1])]

    def save(ends, found):
        if ends:
            pairs = np.array([order for i, j in ends for order in ((i, j), (j, i))])
            store.write_part(out, store.to_matches(features, pairs, found, PARAMETERS, GROWN))
        return [], []

    decoded, (ends, found) = {}, ([], [])
    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for block in np.split(new, np.flatnonzero(np.diff(new // half, axis=0).any(1)) + 1):
            decoded = {image: decoded.get(image) or pool.submit(read, image, features.of(image))
                       for image in np.unique(block).tolist()}
            for pair, both in map_ahead(pool, align_pair, block.tolist(), 4 * threads):
                ends.append(pair)
                found += both
                update()
                if len(ends) == part_size:
                    ends, found = save(ends, found)
    save(ends, found)
    Grown(out, features).tidy()


def folder_of(matches):
    return os.path.realpath(matches.folder) + '.grown'


def build(features, matches, turns, cameras, is_known=False, min_inliers=MIN_INLIERS, threads=1, progress=None):
    """Builds tracks from what grow has saved. turns are colmap.turn_of of the images, and cameras their
    pycolmap.Camera, or None for an image to leave out. is_known tells that their intrinsics are exact. Returns the
    positions of each image's tracks in its file, and what shared yields.

    Pairs below min_inliers count only where no others connect their images: by their matches as detected."""
    scales = scales_of(features, store.detector_of(features.parameters())[1])[1]
    grown, keypoints, sizes = Grown(folder_of(matches), features), [], []
    row_of = {pair: row for row, pair in enumerate(map(tuple, grown.pairs.tolist()))}
    for image, (matrix, shift) in enumerate(turns):
        found = features.of(image)
        keypoints.append(np.column_stack([found['x'], found['y']]) @ matrix.T + shift)
        sizes.append(found['size'] * scales[image].mean())
    pairs = {tuple(sorted(pair)): row for row, pair in enumerate(matches.pairs.tolist())
             if cameras[pair[0]] and cameras[pair[1]]}
    update = progress(len(pairs)) if progress else int
    kept, geometries = {}, {}

    def load(i, j):
        found = grown.of(row_of[i, j])
        other = np.column_stack([found['x'], found['y']]) @ turns[j][0].T + turns[j][1]
        return Aligned(found['index'], keypoints[i][found['index']], other)

    def detected(i, j):
        found, is_first = matches.of(pairs[i, j]), matches.pairs[pairs[i, j], 0] == i
        ends = (found['index1'], found['index2']) if is_first else (found['index2'], found['index1'])
        own = keypoints[i][ends[0]], keypoints[j][ends[1]]
        return Aligned(ends[0], *own), Aligned(ends[1], *own[::-1])

    def keep(items, max_error, *how):
        def verify_pair(item):
            (i, j), both = item
            return verify(*both, cameras[i], cameras[j], max_error / min(scales[i].min(), scales[j].min()), *how)

        for ((i, j), _), found in map_ahead(pool, verify_pair, items, 4 * threads):
            if found:
                kept[i, j], kept[j, i], geometries[i, j] = found
            update()

    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        keep((((i, j), (load(i, j), load(j, i))) for i, j in sorted(pairs)), MAX_ERROR, is_known, min_inliers)
        edges = np.array(list(kept), int).reshape(-1, 2).T
        graph = scipy.sparse.coo_matrix((np.ones(len(kept)), edges), 2 * [len(turns)])
        part = scipy.sparse.csgraph.connected_components(graph, False)[1]
        keep((((i, j), detected(i, j)) for i, j in sorted(pairs) if part[i] != part[j]), DETECTED, False,
             2 * places.MIN_INLIERS)
    tracks, positions = join(kept, sizes, [APART / scale.min() for scale in scales])
    return positions, shared(tracks, geometries)
