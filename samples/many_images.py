#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Computes the features of many photographs, several at a time, and saves those of each in a file NAME.npz with the
arrays keypoints and descriptors. Needs the package aqorb."""

import argparse
import concurrent.futures
import os
import sys
import time

import aqorb
import cv2 as cv
import numpy as np

WAYS = {'threads': concurrent.futures.ThreadPoolExecutor, 'processes': concurrent.futures.ProcessPoolExecutor}


def save_features(name, folder, nfeatures):
    """Decodes a photograph, detects, and saves; all three let other threads run meanwhile. Returns a failure, or how
    many keypoints there are."""
    image = cv.imread(name, cv.IMREAD_GRAYSCALE)
    if image is None:
        return name + ': cannot be read as an image'
    keypoints, descriptors = aqorb.AdaptiveQuadtreeORB_create(nfeatures).detectAndComputeArrays(image)
    path = os.path.join(folder, os.path.splitext(os.path.basename(name))[0] + '.npz')
    np.savez(path, keypoints=keypoints, descriptors=descriptors)
    return len(keypoints)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nfeatures', type=int, default=1000)
    parser.add_argument('--workers', type=int, default=os.cpu_count(), help='photographs that are worked on at a time')
    parser.add_argument('--by', choices=sorted(WAYS), default='threads')
    parser.add_argument('--out', default='.', help='existing folder for the files')
    parser.add_argument('images', nargs='+')
    arguments = parser.parse_args()
    # Each worker has a photograph, so that no work is divided further.
    aqorb.setNumThreads(1)
    cv.setNumThreads(1)

    start = time.perf_counter()
    count = len(arguments.images)
    with WAYS[arguments.by](arguments.workers) as pool:
        results = list(pool.map(save_features, arguments.images, [arguments.out] * count,
                                [arguments.nfeatures] * count))
    failures = [result for result in results if isinstance(result, str)]
    print('{} photographs, {} features, {} {}: {:.2f} s'.format(
        count - len(failures), sum(result for result in results if result not in failures), arguments.workers,
        arguments.by, time.perf_counter() - start))
    sys.exit('\n'.join(failures) or 0)


if __name__ == '__main__':
    main()
