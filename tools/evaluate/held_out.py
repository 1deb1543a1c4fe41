# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The held-out pairs of images, on which no default was tuned.

held_out.csv has a row for each pair: its name, the package, both files in it, their SHA-256, the kind of geometry,
how many SIFT matches there were and how many of them agree with it, and the nine numbers of the matrix, row by row.
The matrices were estimated from SIFT (mutual nearest neighbours that pass a ratio test of 0.8, MAGSAC++), so that no
ORB takes part.
"""

import csv
import hashlib
import os

import cv2
import numpy as np

LIST = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'held_out.csv')


def find(sources, package, name):
    """The file of a package whose path ends so: other releases of a package keep it in other folders."""
    top = os.path.join(sources, package)
    for folder, _, files in sorted(os.walk(top)):
        for file in files:
            path = os.path.join(folder, file)
            if path.endswith('/' + name):
                return path
    raise FileNotFoundError('{}: no {} below it'.format(top, name))


def read(sources, package, name, digest):
    """An image that is not the one of the list is an error."""
    path = find(sources, package, name)
    with open(path, 'rb') as file:
        if hashlib.sha256(file.read()).hexdigest() != digest:
            raise ValueError('{}: not the image that {} has'.format(path, LIST))
    return cv2.imread(path, cv2.IMREAD_GRAYSCALE)


def read_pairs(sources):
    """[(name, image, image, homography or None, fundamental matrix or None)] of a folder with the packages."""
    pairs = []
    with open(LIST, encoding='utf-8', newline='') as file:
        for row in csv.DictReader(file):
            pair = [read(sources, row['package'], row[which], row['sha256_' + which]) for which in ('first', 'second')]
            matrix = np.array([row['m' + i + j] for i in '123' for j in '123'], float).reshape(3, 3)
            is_homography = row['kind'] == 'homography'
            pairs.append((row['name'], *pair, *((matrix, None) if is_homography else (None, matrix))))
    return pairs
