# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""ORB features spread uniformly over the image, for programs that use cv2.

    import aqorb
    orb = aqorb.AdaptiveQuadtreeORB_create(1000)    # was: cv2.ORB_create(1000)
    keypoints, descriptors = orb.detectAndCompute(image, None)

Names and signatures equal those of cv2.aqorb, the module in a cv2 built with it. Functions of cv2 do not accept the
detector of this package, which is not derived from cv2.Feature2D. They accept its keypoints and descriptors, and
computeImageFeatures2 of this package makes features for cv2.detail. The package imports cv2 when a call first needs
its objects; functions of arrays work without cv2.

Images are numpy arrays or memoryviews of uint8 with any strides. Their shape is (rows, cols) or (rows, cols, channels),
with 1 (grey), 3 (BGR) or 4 (BGRA) channels. File names are str, bytes or paths.

An invalid value raises aqorb.error, which is a ValueError and, with cv2, a cv2.error. An object of a wrong type raises
TypeError. Both messages name the parameter. A lack of memory raises a MemoryError.

HammingMatcher has the methods and the matches of cv2.BFMatcher for binary descriptors, but faster. matchArrays,
knnMatchArrays, matchByPosition and matchGuided return matches as arrays. refineMatches and refineMatchArrays align the
images at each match, and remove wrong matches. matchImages takes two images to exact pairs of points.

Some names are not in cv2.aqorb. detectAndComputeArrays returns keypoints as one array of keypoint_dtype, and
keypointsToArray and keypointsFromArray convert keypoints. Each function accepts an array of keypoints, and then returns
keypoints as an array. detectAndComputeBatch, for many images, returns arrays in a FeatureBatch. setNumThreads and
getNumThreads control the threads of a call.
"""

from . import _aqorb
from ._aqorb import *
from ._aqorb import __version__, _build_information
from ._feature_batch import FeatureBatch, detectAndComputeBatch as _detectAndComputeBatch

AdaptiveQuadtreeORB.detectAndComputeBatch = _detectAndComputeBatch


def computeImageFeatures2(featuresFinder, image, mask=None):
    """Computes the features of an image for the matchers and estimators of cv2.detail, as
    cv2.detail.computeImageFeatures2 does for a cv2.Feature2D."""
    import cv2
    import numpy
    keypoints, descriptors = featuresFinder.detectAndCompute(image, mask)
    # An object to fill in, because the class has no usable constructor.
    features = cv2.detail.computeImageFeatures2(cv2.ORB_create(1), numpy.zeros((32, 32), numpy.uint8))
    features.img_size = (0, 0) if image is None else image.shape[1::-1]
    features.keypoints = keypoints
    features.descriptors = cv2.UMat() if descriptors is None else cv2.UMat(descriptors)
    return features


def refinePoints(image1, points1, image2, points2, size=31, minCorrelation=.8):
    """Refines matches without sizes and angles, such as LoFTR's: points1[i] and points2[i] show the same spot. The
    points are arrays of shape (n, 2) or (n, 1, 2). size is the diameter of the compared patches, in pixels. Returns the
    indices of the remaining points, their positions in image 2, and the standard deviations of these positions."""
    import numpy
    from ._cv2 import error
    keypoints = []
    for name, given in ('points1', points1), ('points2', points2):
        points = numpy.asarray(given, numpy.float32)
        if points.shape[1:] not in ((2,), (1, 2)):
            raise error('{} must be numbers of shape (n, 2) or (n, 1, 2), got the shape {}'.format(name, points.shape))
        keypoints.append(numpy.zeros(len(points), keypoint_dtype))
        keypoints[-1]['pt'], keypoints[-1]['size'], keypoints[-1]['angle'] = points.reshape(-1, 2), size, -1
    if len(keypoints[0]) != len(keypoints[1]):
        raise error('points2 must be as many as points1, {}, got {}'.format(*map(len, keypoints)))
    if not 0 < size < numpy.inf:
        raise error('size must be finite and > 0, got {}'.format(size))
    pairs = numpy.arange(len(keypoints[0])).repeat(2).reshape(-1, 2)
    pairs, _, refined, deviations = refineMatchArraysWithDeviations(image1, keypoints[0], image2, keypoints[1], pairs,
                                                                    minCorrelation)
    return pairs[:, 0], refined, deviations


def _from_text(text):  # in Python, so that pickle takes it
    return _aqorb._from_text(text)


def _matcher(kind, settings, descriptors):
    matcher = kind(*settings)
    matcher.add(descriptors)
    return matcher


def __getattr__(name):
    if name == 'error':  # needs cv2 for its base class
        from ._cv2 import error
        return error
    raise AttributeError("module 'aqorb' has no attribute {!r}".format(name))


def __dir__():
    return sorted(list(globals()) + ['error'])


__all__ = [_name for _name in globals() if _name[0] != '_'] + ['error']
