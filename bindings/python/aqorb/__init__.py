# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""ORB features spread uniformly over the image, for programs that use cv2.

    import aqorb
    orb = aqorb.AdaptiveQuadtreeORB_create(1000)    # was: cv2.ORB_create(1000)
    keypoints, descriptors = orb.detectAndCompute(image, None)

The names and signatures are those of cv2.aqorb, which a cv2 has that was built with the module. An object of this
package is no cv2.Feature2D, so cv2's own functions do not take it; its keypoints and descriptors they do. Images are
numpy arrays of uint8, (rows, cols) or (rows, cols, channels) with 1, 3 (BGR) or 4 (BGRA) channels, of any strides.

Values that are not accepted raise aqorb.error, which is a cv2.error and a ValueError; objects of a wrong type raise
TypeError.

Beyond cv2.aqorb: detectAndComputeArrays returns keypoints as one array of keypoint_dtype, and every function takes
such an array for keypoints and returns one if it was given one.
"""

from ._aqorb import (AdaptiveQuadtreeORB, AdaptiveQuadtreeORB_create, adaptiveFastThreshold, distributionOccupancy,
                     distributionUniformity, error, keypoint_dtype, keypointsFromArray, keypointsToArray,
                     retainUniform)

__all__ = ['AdaptiveQuadtreeORB', 'AdaptiveQuadtreeORB_create', 'adaptiveFastThreshold', 'distributionOccupancy',
           'distributionUniformity', 'error', 'keypoint_dtype', 'keypointsFromArray', 'keypointsToArray',
           'retainUniform']
