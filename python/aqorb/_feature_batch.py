# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What detectAndComputeBatch returns."""

import typing

import numpy

from . import keypoint_dtype


class FeatureBatch(typing.NamedTuple):
    """The features of several images: one array for each field, with the features of one image after those of another.
    Those of image i are at offsets[i] to offsets[i + 1] - 1 in each of the other arrays. The fields are those of
    keypoint_dtype. All arrays are contiguous: float32, int32 for octave, uint8 of shape (n, 32) for descriptors, and
    int64 for offsets, which has one element more than there are images."""

    x: numpy.ndarray
    y: numpy.ndarray
    size: numpy.ndarray
    angle: numpy.ndarray
    response: numpy.ndarray
    octave: numpy.ndarray
    descriptors: numpy.ndarray
    offsets: numpy.ndarray

    def rows(self, image):
        """Returns the features of an image as a slice of each array but offsets. A negative number counts from the last
        image."""
        index = range(len(self.offsets) - 1)[image]
        return slice(int(self.offsets[index]), int(self.offsets[index + 1]))

    def keypoints(self, image=None):
        """Returns the keypoints of an image, or of all of them, as an array of keypoint_dtype. It is a copy."""
        rows = slice(None) if image is None else self.rows(image)
        array = numpy.empty(len(self.x[rows]), keypoint_dtype)
        array['pt'] = numpy.stack((self.x[rows], self.y[rows]), axis=1)
        for field in 'size', 'angle', 'response', 'octave':
            array[field] = getattr(self, field)[rows]
        array['class_id'] = -1
        return array


def join(keypoints, descriptors):
    """A FeatureBatch of the keypoints of each image, as arrays of keypoint_dtype, and descriptors as arrays of rows."""
    offsets = numpy.cumsum([0] + [len(some) for some in keypoints], dtype=numpy.int64)
    points = numpy.concatenate([numpy.empty(0, keypoint_dtype)] + keypoints)
    columns = [points['pt'][:, 0], points['pt'][:, 1]] + [points[name] for name in FeatureBatch._fields[2:6]]
    rows = numpy.concatenate([numpy.empty((0, 32), numpy.uint8)] + descriptors)
    return FeatureBatch(*map(numpy.ascontiguousarray, columns), rows, offsets)


FeatureBatch.__module__ = 'aqorb'  # the name by which it is pickled
