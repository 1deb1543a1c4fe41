# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""How many places of two images agree where they show different things, and where they show the same: the bound of the
command aqorb draw."""

import itertools

import aqorb
import cv2
import numpy as np

import images
import objects
from aqorb_photographs import places

DRAWN = 12
ALIKE = {'facades': ['building.jpg', 'home.jpg', '*-P1[01]/images/000[0369].jpg', 'leuven/img[1234].png'],
         'leaves, bark and cloth': ['aloe[LR].jpg', 'bark/img[1234].png', 'squirrel_cls.jpg', 'trees/img[1234].png']}
FONTS = [cv2.FONT_HERSHEY_SIMPLEX, cv2.FONT_HERSHEY_COMPLEX]


def drawn_page(seed):
    """A page of words."""
    random, page = np.random.RandomState(seed), np.full((800, 600), 235, np.uint8)
    for line in range(40, 780, 24):
        words = ' '.join(''.join(random.choice(list('abcdefghiklmnoprstuvw'), random.randint(2, 9))) for _ in range(9))
        cv2.putText(page, words, (25, line), FONTS[seed % 2], .5, 40, 1, cv2.LINE_AA)
    return page


def drawn_board(seed):
    """A chessboard of some number of squares, from some side."""
    random = np.random.RandomState(seed)
    columns, rows, side = random.randint(5, 12), random.randint(5, 12), 50
    board = np.kron(np.indices((rows, columns)).sum(0) % 2, np.full((side, side), 200)) + 30
    corners = np.float32([[0, 0], [columns, 0], [columns, rows], [0, rows]]) * side
    moved = corners * .9 + 60 + random.uniform(-40, 40, (4, 2))
    matrix = cv2.getPerspectiveTransform(corners, np.float32(moved))
    return cv2.warpPerspective(board.astype(np.uint8), matrix, (700, 700), borderValue=128)


def pairs_of(groups, number):
    """By kind, pairs of pictures. A group is the kind, the place, the number and the folder of a picture."""
    def both(pairs):
        return list(pairs) if len(pairs) <= number else [pairs[i] for i in np.random.RandomState(0).permutation(
            len(pairs))[:number]]
    photographs = [group for group in groups if group[0] == 'photographs']
    every = list(itertools.combinations(photographs, 2))
    kinds = {'photographs of different places': both([pair for pair in every if pair[0][1] != pair[1][1]])}
    for kind, alike in ALIKE.items():
        kinds['of these, ' + kind] = [pair for pair in every if pair[0][1] != pair[1][1]
                                      and pair[0][1] in alike and pair[1][1] in alike]
    for kind in 'pages of text', 'chessboards':
        kinds[kind] = list(itertools.combinations([group for group in groups if group[0] == kind], 2))
    kinds['photographs of one place'] = [pair for pair in every if pair[0][1::2] == pair[1][1::2]]
    return kinds


def count(first, second):
    (picture1, features1), (picture2, features2) = first, second
    return places.agreement(*places.grow((picture1, picture2), (features1, features2))).places


def tables(options):
    """(title, head, rows) of each table."""
    aqorb.setNumThreads(1)
    groups, pictures = [], []
    for _, place, folder, picture in objects.read_photographs(objects.folders_of(options)):
        groups.append(('photographs', place, len(pictures), folder))
        pictures.append(images.scaled(picture, min(1, objects.LONGEST / max(picture.shape)))[0])
    for kind, draw in ('pages of text', drawn_page), ('chessboards', drawn_board):
        for seed in range(DRAWN):
            groups.append((kind, seed, len(pictures), ''))
            pictures.append(objects.seen(draw(seed), np.random.RandomState(seed)))
    for n in options.n:
        detector = aqorb.AdaptiveQuadtreeORB_create(n)
        known = [(picture, detector.detectAndComputeArrays(picture)) for picture in pictures]
        rows = []
        for kind, pairs in pairs_of(groups, options.pairs).items():
            found = np.array([count(known[a[2]], known[b[2]]) for a, b in pairs])
            rows.append([kind, str(len(found))]
                        + ['{:.0f}'.format(np.quantile(found, q, method='higher')) for q in (.01, .5, .99, 1)]
                        + ['{:.3f}'.format(np.mean(found >= places.MIN_PLACES))])
        yield 'Places that agree, n = {}'.format(n), ['', 'pairs', '1 %', 'median', '99 %', 'most', 'accepted'], rows
