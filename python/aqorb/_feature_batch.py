# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""detectAndComputeBatch and its result."""

import typing

import numpy

from . import keypoint_dtype


class FeatureBatch(typing.NamedTuple):
    """Features of several images: one array for each field of keypoint_dtype, image after image. The features of image
    i are elements offsets[i] to offsets[i + 1] - 1 of each other array. All arrays are contiguous: float32, int32 for
    octave, uint8 of shape (n, 32) for descriptors, and int64 for offsets, which has one more element than there are
    images."""

    x: numpy.ndarray
    y: numpy.ndarray
    size: numpy.ndarray
    angle: numpy.ndarray
    response: numpy.ndarray
    octave: numpy.ndarray
    descriptors: numpy.ndarray
    offsets: numpy.ndarray

    def rows(self, image):
        """Returns the features of an image as a slice of each array except offsets. A negative number counts from the
        last image."""
        index = range(len(self.offsets) - 1)[image]
        return slice(int(self.offsets[index]), int(self.offsets[index + 1]))

    def keypoints(self, image=None):
        """Returns a copy of the keypoints of an image, or of all images, as an array of keypoint_dtype."""
        rows = slice(None) if image is None else self.rows(image)
        array = numpy.empty(len(self.x[rows]), keypoint_dtype)
        array['pt'] = numpy.stack((self.x[rows], self.y[rows]), axis=1)
        for field in 'size', 'angle', 'response', 'octave':
            array[field] = getattr(self, field)[rows]
        array['class_id'] = -1
        return array


def detectAndComputeBatch(self, images, masks=None):
    """Returns the features of several images, as detectAndComputeArrays gives for each, in a FeatureBatch with one
    array for each field. Images are processed in parallel, each on one thread. There is one mask for each image, or
    none. An error names the image, as images[3]."""
    keypoints, descriptors = self._features_of(images, masks)
    offsets = numpy.cumsum([0] + [len(some) for some in keypoints], dtype=numpy.int64)
    points = numpy.concatenate([numpy.empty(0, keypoint_dtype)] + keypoints)
    columns = [points['pt'][:, 0], points['pt'][:, 1]] + [points[name] for name in FeatureBatch._fields[2:6]]
    rows = numpy.concatenate([numpy.empty((0, 32), numpy.uint8)] + descriptors)
    return FeatureBatch(*map(numpy.ascontiguousarray, columns), rows, offsets)


FeatureBatch.__module__ = 'aqorb'  # its name for pickle
