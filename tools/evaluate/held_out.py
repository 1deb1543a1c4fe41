#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Lays out the held-out pairs of images, on which no default was tuned, for aqorb_evaluate.

SOURCES is a folder with the unpacked packages that held_out.csv names; scripts/held_out.sh fetches them. OUT gets
a folder for each pair with img1, img2 and the geometry between them: H1to2p, a homography, or F1to2p, a fundamental
matrix. An image that is not the very one that was measured is an error.

held_out.csv has a row for each pair: its name, the package, both files in it, their SHA-256, the kind of geometry,
how many SIFT matches there were and how many of them agree with it, and the nine numbers of the matrix, row by row.
With --estimate the matrices are computed again and held_out.csv is written: SIFT with a low contrast threshold, mutual
nearest neighbours that pass a ratio test of 0.8, MAGSAC++, and a look at the result. No ORB takes part in it.
"""

import argparse
import csv
import hashlib
import os
import shutil
import sys

LIST = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'held_out.csv')
COLUMNS = ['name', 'package', 'first', 'second', 'sha256_first', 'sha256_second', 'kind', 'matches', 'inliers']
MATRIX = ['m{}{}'.format(row, column) for row in (1, 2, 3) for column in (1, 2, 3)]
GEOMETRY = {'homography': 'H1to2p', 'fundamental': 'F1to2p'}


def sha256(path):
    with open(path, 'rb') as file:
        return hashlib.sha256(file.read()).hexdigest()


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
    folder = os.path.join(out, pair['name'])
    os.makedirs(folder, exist_ok=True)
    for image, which in (('img1', 'first'), ('img2', 'second')):
        path = find(sources, pair['package'], pair[which])
        if sha256(path) != pair['sha256_' + which]:
            raise ValueError('{}: not the image that {} has'.format(path, LIST))
        shutil.copyfile(path, os.path.join(folder, image + os.path.splitext(path)[1]))
    with open(os.path.join(folder, GEOMETRY[pair['kind']]), 'w', encoding='utf-8') as file:
        numbers = [pair[key] for key in MATRIX]
        file.writelines(' '.join(numbers[row:row + 3]) + '\n' for row in (0, 3, 6))


def estimate(pair, sources):
    """Fills in what is computed of a pair."""
    import cv2
    import numpy as np

    cv2.setRNGSeed(1)
    sift = cv2.SIFT_create(6000, 3, 0.01, 15)
    keypoints, descriptors = [], []
    for which in ('first', 'second'):
        path = find(sources, pair['package'], pair[which])
        pair['sha256_' + which] = sha256(path)
        found = sift.detectAndCompute(cv2.imread(path, cv2.IMREAD_GRAYSCALE), None)
        keypoints.append(found[0])
        descriptors.append(found[1])
    two_best = cv2.BFMatcher().knnMatch(descriptors[0], descriptors[1], k=2)
    back = {match.queryIdx: match.trainIdx for match in cv2.BFMatcher().match(descriptors[1], descriptors[0])}
    matches = [best for best, second in two_best
               if best.distance < 0.8 * second.distance and back[best.trainIdx] == best.queryIdx]
    first = np.float64([keypoints[0][match.queryIdx].pt for match in matches])
    second = np.float64([keypoints[1][match.trainIdx].pt for match in matches])
    if pair['kind'] == 'homography':
        matrix, inliers = cv2.findHomography(first, second, cv2.USAC_MAGSAC, 1.5, maxIters=20000, confidence=0.99999)
    else:
        matrix, inliers = cv2.findFundamentalMat(first, second, cv2.USAC_MAGSAC, 1, 0.99999, 20000)
    pair.update(matches=str(len(matches)), inliers=str(int(inliers.sum())))
    pair.update(zip(MATRIX, ('{:.12g}'.format(number) for number in (matrix / matrix[2, 2]).ravel())))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('sources', metavar='SOURCES')
    parser.add_argument('out', metavar='OUT')
    parser.add_argument('--estimate', action='store_true', help='compute the matrices again and write held_out.csv')
    arguments = parser.parse_args()
    try:
        with open(LIST, encoding='utf-8', newline='') as file:
            pairs = list(csv.DictReader(file))
        for pair in pairs:
            if arguments.estimate:
                estimate(pair, arguments.sources)
            lay_out(pair, arguments.sources, arguments.out)
        if arguments.estimate:
            with open(LIST, 'w', encoding='utf-8', newline='') as file:
                writer = csv.DictWriter(file, COLUMNS + MATRIX, lineterminator='\n')
                writer.writeheader()
                writer.writerows(pairs)
    except (OSError, ValueError) as error:
        sys.exit('held_out.py: {}'.format(error))
    print('{} pairs in {}'.format(len(pairs), arguments.out))


if __name__ == '__main__':
    main()
