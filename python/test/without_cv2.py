# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What works where NumPy and the package are installed, and nothing else: arrays in, arrays out. The package asks for cv2
when its objects are needed. scripts/python.sh wheel runs the program, and has mypy and pyright check its types."""

import numpy as np
from numpy.typing import NDArray

import aqorb

noise: NDArray[np.uint8] = np.random.RandomState(0).randint(0, 256, (480, 640)).astype(np.uint8)
orb = aqorb.AdaptiveQuadtreeORB_create(300)
keypoints, descriptors = orb.detectAndComputeArrays(noise, noise >= 0)
assert keypoints['pt'].shape == (300, 2) and descriptors.shape == (300, 32)
_, again = orb.compute(noise, keypoints)
assert again is not None and np.array_equal(again, descriptors)
size = noise.shape[::-1]
occupancy: float = aqorb.distributionOccupancy(aqorb.retainUniform(keypoints, size, 100), size, [4, 3])
assert occupancy == 1
pairs, distances = aqorb.matchArrays(descriptors, descriptors, crossCheck=True)
assert pairs.shape == (300, 2) and not distances.any()
try:
    orb.setPatchSize(1)
except aqorb.error as wrong:
    assert isinstance(wrong, ValueError)
try:
    orb.detect(noise)
    print('cv2 is installed')
except ImportError as error:
    assert 'detectAndComputeArrays, which needs no cv2' in str(error)
    print('arrays in, arrays out')
