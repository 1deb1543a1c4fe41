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
import shutil

LIST = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'held_out.csv')
GEOMETRY = {'homography': 'H1to2p', 'fundamental': 'F1to2p'}


def find(sources, package, name):
    """The file of a package whose path ends so: other releases of a package keep it in other folders."""
    top = os.path.join(sources, package)
    for folder, _, files in sorted(os.walk(top)):
        for file in files:
            path = os.path.join(folder, file)
            if path.endswith('/' + name):
                return path
    raise FileNotFoundError('{}: no {} below it'.format(top, name))


def lay_out(pair, sources, out):
    """Writes img1, img2 and the geometry between them. An image that is not the one of the list is an error."""
    folder = os.path.join(out, pair['name'])
    os.makedirs(folder, exist_ok=True)
    for image, which in (('img1', 'first'), ('img2', 'second')):
        path = find(sources, pair['package'], pair[which])
        with open(path, 'rb') as file:
            if hashlib.sha256(file.read()).hexdigest() != pair['sha256_' + which]:
                raise ValueError('{}: not the image that {} has'.format(path, LIST))
        shutil.copyfile(path, os.path.join(folder, image + os.path.splitext(path)[1]))
    with open(os.path.join(folder, GEOMETRY[pair['kind']]), 'w', encoding='utf-8') as file:
        for row in '123':
            file.write(' '.join(pair['m' + row + column] for column in '123') + '\n')


def lay_out_all(options):
    with open(LIST, encoding='utf-8', newline='') as file:
        pairs = list(csv.DictReader(file))
    for pair in pairs:
        lay_out(pair, options.sources, options.out)
    print('{} pairs in {}'.format(len(pairs), options.out))
    return True
