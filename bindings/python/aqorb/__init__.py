# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""ORB features spread uniformly over the image, for programs that use cv2.

    import aqorb
    orb = aqorb.AdaptiveQuadtreeORB_create(1000)    # was: cv2.ORB_create(1000)
    keypoints, descriptors = orb.detectAndCompute(image, None)

The names and signatures are those of cv2.aqorb, which a cv2 has that was built with the module. The detector of this
package is not derived from cv2.Feature2D, so that functions of cv2 do not take it. They do take its keypoints and
descriptors. cv2 is imported when the first of its objects is needed; what takes and returns arrays works without.

Images are numpy arrays of uint8 with any strides. Their shape is (rows, cols) or (rows, cols, channels), with 1 (grey),
3 (BGR) or 4 (BGRA) channels. File names are str, bytes or paths.

A value that is not accepted raises aqorb.error, which is a ValueError and, where there is cv2, a cv2.error. An object
of a wrong type raises TypeError. Both messages name the parameter.

Some names are not in cv2.aqorb: detectAndComputeArrays returns keypoints as one array of keypoint_dtype, and
keypointsToArray and keypointsFromArray convert keypoints. Every function takes such an array for keypoints, and those
that return keypoints then return an array. setNumThreads and getNumThreads are for the threads that a call uses.
"""

from . import _aqorb
from ._aqorb import (AdaptiveQuadtreeORB, AdaptiveQuadtreeORB_BALANCED_SELECTION,
                     AdaptiveQuadtreeORB_RANKED_SELECTION, AdaptiveQuadtreeORB_create, __version__,
                     adaptiveFastThreshold, distributionOccupancy, distributionUniformity, getNumThreads,
                     keypoint_dtype, keypointsFromArray, keypointsToArray, retainUniform, setNumThreads)

__all__ = ['AdaptiveQuadtreeORB', 'AdaptiveQuadtreeORB_BALANCED_SELECTION', 'AdaptiveQuadtreeORB_RANKED_SELECTION',
           'AdaptiveQuadtreeORB_create', 'adaptiveFastThreshold', 'distributionOccupancy', 'distributionUniformity',
           'error', 'getNumThreads', 'keypoint_dtype', 'keypointsFromArray', 'keypointsToArray', 'retainUniform',
           'setNumThreads']


def __getattr__(name):
    if name == 'error':  # its base is a class of cv2
        return _aqorb._error()
    raise AttributeError("module 'aqorb' has no attribute {!r}".format(name))


def __dir__():
    return sorted(list(globals()) + ['error'])
