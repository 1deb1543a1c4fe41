# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What the settings of the tutorial's recipes give, on drawn scenes whose geometry is known."""

import aqorb
import cv2
import numpy as np

import images


def detector(kind, n, **settings):
    made = cv2.ORB_create(n) if kind == 'cv::ORB' else aqorb.AdaptiveQuadtreeORB_create(n)
    for name, value in settings.items():
        getattr(made, 'set' + name)(value)
    return made


def right_matches(made, first, second, true_position, masks=(None, None)):
    """How many mutual nearest neighbours lie within 3 pixels of where they belong, and the keypoints of the second."""
    (a, of_a), (b, of_b) = (made.detectAndCompute(*each) for each in zip((first, second), masks))
    if of_a is None or of_b is None:
        return 0, b
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, True).match(of_a, of_b)
    distances = [np.hypot(*(true_position(np.array(a[m.queryIdx].pt)) - b[m.trainIdx].pt)) for m in matches]
    return int(np.sum(np.array(distances) <= 3)), b


def worn(image, seed):
    """Darker, and with noise."""
    noise = np.random.RandomState(seed).normal(0, 5, image.shape)
    return np.clip(.8 * image + noise, 0, 255).astype(np.uint8)


def tiles(pictures, made, is_masked):
    """Right matches of two tiles that overlap by a tenth."""
    found = []
    for seed, image in enumerate(pictures):
        side = int(image.shape[1] / 1.9)
        strip, shift = side // 10, image.shape[1] - side
        first, second = image[:, :side], worn(image[:, shift:], seed)
        masks = np.zeros((2,) + first.shape, np.uint8)
        masks[0, :, -strip:] = masks[1, :, :strip] = 255
        found.append(right_matches(made, first, second, lambda p, s=shift: p - (s, 0),
                                   masks if is_masked else (None, None))[0])
    return '{:.0f}'.format(np.mean(found))


def templates(pictures, made, side):
    """In how many photographs a template is found: at least 8 right matches."""
    found = 0
    for seed, image in enumerate(pictures):
        y, x = (length // 2 - side // 2 for length in image.shape)
        template = np.ascontiguousarray(image[y:y + side, x:x + side])
        found += right_matches(made, template, worn(image, seed), lambda p, corner=(x, y): p + corner)[0] >= 8
    return '{} of {}'.format(found, len(pictures))


def sheet(pictures, made):
    """The share of the keypoints on a printed page in a photograph, and its right matches."""
    page = np.full((380, 270), 235, np.uint8)
    random = np.random.RandomState(1)
    for line in range(20, 370, 18):
        words = ' '.join(''.join(random.choice(list('abcdefghiklmnoprstuvw'), random.randint(2, 9))) for _ in range(9))
        cv2.putText(page, words, (14, line), cv2.FONT_HERSHEY_SIMPLEX, .4, 40, 1, cv2.LINE_AA)
    page[:, -14:] = 235
    shares, counts = [], []
    for seed, image in enumerate(pictures):
        turn = cv2.getRotationMatrix2D((135, 190), 20, .8) + [[0, 0, image.shape[1] // 2 - 135], [0, 0, 100]]
        size = image.shape[::-1]
        on_page = cv2.warpAffine(np.full_like(page, 255), turn, size)
        scene = np.where(on_page > 0, cv2.warpAffine(page, turn, size), image)
        count, keypoints = right_matches(made, page, worn(scene, seed), lambda p: turn @ (*p, 1))
        counts.append(count)
        shares.append(np.mean([on_page[int(k.pt[1]), int(k.pt[0])] > 0 for k in keypoints]))
    return '{:.2f}, {:.0f} right matches'.format(np.mean(shares), np.mean(counts))


def tables(options):
    pictures = [images.read_set(options.datasets, name)[0][0] for name in images.SETS]
    kinds = 'cv::ORB', 'aqorb'
    rows = [['two tiles, 500 features: right matches', kind, how, tiles(pictures, detector(kind, 500), how != 'no mask')]
            for kind in kinds for how in ('no mask', 'masks of the strip')]
    small = dict(EdgeThreshold=8, PatchSize=15)
    rows += [['template of {} pixels, 5000 features: found'.format(side), kind, how,
              templates(pictures, detector(kind, 5000, **settings), side)]
             for side in (48, 64) for kind in kinds
             for how, settings in (('default', {}), ('edgeThreshold 8, patchSize 15', small))]
    rows += [['page in a photograph: share of keypoints', kind, how, sheet(pictures, detector(kind, n, **settings))]
             for kind, how, n, settings in (('cv::ORB', '500 features', 500, {}), ('aqorb', '500 features', 500, {}),
                                            ('aqorb', '2000 features', 2000, {}),
                                            ('aqorb', '2000, StrengthWeight 4', 2000, dict(StrengthWeight=4)))]
    return [('Recipes', ['', 'detector', 'setting', 'here'], rows)]
