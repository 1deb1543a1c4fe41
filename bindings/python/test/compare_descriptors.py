# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Prints how many descriptors equal, to the bit, those that cv2.ORB computes for the same keypoints, and how many bits
the others differ in."""

import cv2 as cv
import numpy as np

import aqorb


def scenes():
    for seed in range(10):
        rng = np.random.RandomState(seed)
        image = np.full((480, 640), 128, np.uint8)
        for _ in range(1500):
            side, x, y = rng.randint(5, 40), rng.randint(0, 640), rng.randint(0, 480)
            image[y:y + side, x:x + side] = rng.randint(0, 256)
        yield cv.GaussianBlur(image, (0, 0), 0.3 + 0.1 * seed)


def compare():
    """The number of descriptors, of those that are equal, and of bits that differ."""
    count = equal = bits = 0
    orb = cv.ORB_create(edgeThreshold=16)
    for image in scenes():
        keypoints = aqorb.AdaptiveQuadtreeORB_create(1000).detect(image)
        kept, theirs = orb.compute(image, keypoints)
        kept, ours = aqorb.AdaptiveQuadtreeORB_create(1000).compute(image, kept)
        assert len(ours) == len(theirs)
        differences = np.unpackbits(ours ^ theirs, axis=1).sum(axis=1)
        count += len(ours)
        equal += int((differences == 0).sum())
        bits += int(differences.sum())
    return count, equal, bits


if __name__ == '__main__':
    count, equal, bits = compare()
    print('{} of {} equal, {} bits differ'.format(equal, count, bits))
