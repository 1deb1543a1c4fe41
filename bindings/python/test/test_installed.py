# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Uses the installed package."""

import numpy as np

import aqorb

image = np.random.RandomState(0).randint(0, 256, (480, 640)).astype(np.uint8)
keypoints, descriptors = aqorb.AdaptiveQuadtreeORB_create(300).detectAndCompute(image)
assert len(keypoints) == 300 and descriptors.shape == (300, 32)
print(len(keypoints), 'keypoints, occupancy %.2f' % aqorb.distributionOccupancy(keypoints, (640, 480)))
