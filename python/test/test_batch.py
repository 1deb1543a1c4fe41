# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of detectAndComputeBatch. What it does while several threads use the package is tested in test_threads.py."""


import numpy as np
import pytest

import aqorb

FIELDS = {'x': np.float32, 'y': np.float32, 'size': np.float32, 'angle': np.float32, 'response': np.float32,
          'octave': np.int32, 'descriptors': np.uint8, 'offsets': np.int64}


@pytest.fixture
def collection(image):
    """Images of all kinds that a single call takes, and masks for some of them."""
    color = np.stack([image, image[::-1], image[:, ::-1]], axis=2)
    images = [image, color[:300], None, np.zeros((90, 80), np.uint8), image[::2, ::3], image[:5, :5], color[..., :1]]
    masks = [None, np.arange(640) % 100 < 60 * np.ones((300, 1)), None, None, image[::2, ::3], None, None]
    return images, masks


@pytest.fixture(params=[1, 2, 3, 4], autouse=True)
def any_number_of_threads(request, threads):
    aqorb.setNumThreads(request.param)


def check(batch, orb, images, masks):
    assert type(batch) is aqorb.FeatureBatch and batch._fields == tuple(FIELDS)
    for name, array in zip(batch._fields, batch):
        assert array.dtype == FIELDS[name] and array.flags.c_contiguous, name
    assert batch.offsets[0] == 0 and len(batch.offsets) == len(images) + 1
    assert batch.descriptors.shape == (batch.offsets[-1], 32)
    assert {len(getattr(batch, name)) for name in batch._fields[:-1]} == {batch.offsets[-1]}
    for i, (image, mask) in enumerate(zip(images, masks)):
        keypoints, descriptors = orb.detectAndComputeArrays(image, mask)
        rows = batch.rows(i)
        assert (rows.start, rows.stop) == (batch.offsets[i], batch.offsets[i + 1])
        assert np.array_equal(batch.descriptors[rows], descriptors)
        assert batch.keypoints(i).dtype == aqorb.keypoint_dtype
        assert np.array_equal(batch.keypoints(i), keypoints)
        assert np.array_equal(np.stack([batch.x, batch.y], 1)[rows], keypoints['pt'])
        for name in 'size', 'angle', 'response', 'octave':
            assert np.array_equal(getattr(batch, name)[rows], keypoints[name])


@pytest.mark.parametrize('count', [0, 1, 2, 7])
def test_equals_a_call_for_each_image(orb, collection, count):
    images, masks = [items[:count] for items in collection]
    check(orb.detectAndComputeBatch(images, masks), orb, images, masks)
    check(orb.detectAndComputeBatch(tuple(images)), orb, images, [None] * count)
    check(orb.detectAndComputeBatch(images=images, masks=[]), orb, images, [None] * count)


def test_the_rows_of_an_image(orb, image):
    batch = orb.detectAndComputeBatch([image, image[:200], None])
    assert batch.rows(-1) == batch.rows(2) == slice(600, 600) and batch.rows(-3) == batch.rows(np.int64(0))
    assert len(batch.keypoints()) == 600 and np.array_equal(batch.keypoints()[batch.rows(1)], batch.keypoints(1))
    for wrong in 3, -4:
        for function in batch.rows, batch.keypoints:
            with pytest.raises(IndexError):
                function(wrong)
    with pytest.raises(TypeError):
        batch.rows(1.5)


def test_arrow_takes_the_arrays_without_a_copy(orb, image):
    arrow = pytest.importorskip('pyarrow')
    batch = orb.detectAndComputeBatch([image, None, image[:200]])
    for array in batch[:6] + batch[7:]:
        assert arrow.array(array).buffers()[1].address == array.ctypes.data
    rows = arrow.FixedSizeBinaryArray.from_buffers(arrow.binary(32), len(batch.x),
                                                   [None, arrow.py_buffer(batch.descriptors)])
    assert rows.buffers()[1].address == batch.descriptors.ctypes.data
    lists = arrow.LargeListArray.from_arrays(arrow.array(batch.offsets), rows)
    assert [len(rows) for rows in lists] == [300, 0, 300]
    assert lists[2][5].as_py() == batch.descriptors[305].tobytes()
