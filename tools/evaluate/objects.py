# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""How often a known object is located in a scene, and how many places it has in scenes with it and without it.

An object is a square of a photograph. It is drawn into a photograph of another place as a plane that is turned, tilted,
made darker or brighter, and seen by a camera with blur and noise. The drawing leaves out depth, occlusion, curved
surfaces, shadows, gloss, and the change from one camera to another."""

import glob
import os
import time
from typing import NamedTuple

import aqorb
import cv2
import numpy as np

import images
import measures
from methods import Method, is_available

# Photographs by place; Strecha's entry and fountain are of one building. Settings are chosen on the first half, and no
# choice was made on the other one. A scene has the object of another place of its half.
HALVES = [
    ['aero1.jpg', 'baboon.jpg', 'bark/img[1234].png', 'board.jpg', 'butterfly.jpg', '*-P1[01]/images/000[0369].jpg',
     'fruits.jpg', 'graf/img[1234].png', 'left01.jpg', 'messi5.jpg', 'squirrel_cls.jpg', 'starry_night.jpg',
     'trees/img[1234].png'],
    ['aloe[LR].jpg', 'basketball1.png', 'bikes/img[1234].png', 'box_in_scene.png', 'building.jpg', 'chicky_512.png',
     'home.jpg', 'leuven/img[1234].png', 'rubberwhale1.png', 'sudoku.png', 'tsukuba.png', 'ubc/img[1234].png']]
OBJECT, LONGEST = 300, 900  # pixels: the side of an object's picture, and the longer side of a scene
MIN_DEVIATION = 25  # of an object's grey values
CORNERS = np.float32([(0, 0), (OBJECT - 1, 0), (OBJECT - 1, OBJECT - 1), (0, OBJECT - 1)])
RIGHT = 5  # pixels: mean error of the corners
ABSENT = 3  # scenes without each object
FRAMES = 50  # of a clip
MANY = 100  # objects in a frame
CELL = 16  # pixels: inliers in one cell are one place
BELIEVED = 10  # places, by the tutorial on known objects
FALSE = .01  # share of scenes without the object that a bound on places accepts
ORB_SETTINGS = ['orb:edge={}:fast={}'.format(edge, fast) for edge in (31, 16) for fast in (20, 5)]


class Pair(NamedTuple):
    """An object, a scene with it, the homography between them, and the numbers of scenes without it."""
    half: int
    part: np.ndarray
    scene: np.ndarray
    homography: np.ndarray
    absent: list


class Stage(NamedTuple):
    """What is done with the matches, and the estimator of the homography with its threshold in pixels."""
    title: str
    estimator: int
    threshold: float
    grows: bool = False
    both_ways: bool = True
    is_repeated: bool = False  # all keypoints of the object, seen through the homography, are aligned again


USUAL = Stage('RANSAC', cv2.RANSAC, 3)
MATCHED = Stage('as matched', cv2.USAC_MAGSAC, 3)
GROWN = Stage('grown', cv2.USAC_MAGSAC, 1.5, True)
ONE_WAY = GROWN._replace(title='grown one way', both_ways=False)
AGAIN = GROWN._replace(title='grown, all aligned again', is_repeated=True)


class Row(NamedTuple):
    """Names of a method, of which the best one on the first half counts; the ratio of the two nearest distances or None
    for a cross check; and refineMatches' scaleFactor."""
    title: str
    names: list
    ratio: float
    scale: float
    stages: list


ROWS = [Row('cv::ORB', ['orb'], None, 1, [USUAL, MATCHED, GROWN]),
        Row('cv::ORB, best border and threshold', ORB_SETTINGS, None, 1, [MATCHED, GROWN]),
        Row('AKAZE', ['akaze'], None, 5, [MATCHED, GROWN]),
        Row('SIFT, ratio .8', ['sift'], .8, 6.75, [MATCHED, GROWN]),
        Row('aqorb', ['aqorb'], None, 1, [MATCHED, ONE_WAY, GROWN, AGAIN])]
ROWS += [Row('aqorb, StrengthWeight {}'.format(weight), ['aqorb:strength={}'.format(weight)], None, 1, [MATCHED, GROWN])
         for weight in ('.5', '1')]


def folders_of(options):
    return [options.datasets, options.scenes, options.samples, os.path.join(options.datasets, '../../features2d')]


def read_photographs(folders):
    """(half, place, folder, picture) for each photograph."""
    for half, patterns in enumerate(HALVES):
        for place in patterns:
            files = sorted(file for folder in folders for file in glob.glob(os.path.join(folder, place)))
            if not files:
                raise FileNotFoundError('{}: no such photograph in {}'.format(place, ', '.join(folders)))
            yield from ((half, place, os.path.dirname(file), cv2.imread(file, cv2.IMREAD_GRAYSCALE)) for file in files)


def seen(image, random):
    """The image by a camera that blurs and has noise."""
    image = cv2.GaussianBlur(image.astype(np.float32), (0, 0), .6)
    return np.clip(image + random.normal(0, 3, image.shape), 0, 255).astype(np.uint8)


def cut(picture, random):
    """An object of a photograph."""
    for _ in range(1000):
        side = int(random.uniform(.35, .6) * min(picture.shape))
        y, x = (random.randint(0, length - side + 1) for length in picture.shape)
        part = picture[y:y + side, x:x + side]
        if part.std() >= MIN_DEVIATION:
            how = cv2.INTER_AREA if side > OBJECT else cv2.INTER_CUBIC
            return cv2.resize(part, (OBJECT, OBJECT), interpolation=how)
    raise ValueError('a photograph has no object')


def draw(part, background, random):
    """The background with the object, as floating-point numbers, and the homography to it."""
    size = np.array(measures.size_of(background))
    side, angle = random.uniform(.2, .4) * size.min(), random.uniform(0, 2 * np.pi)
    corners = np.array([[-.5, -.5], [.5, -.5], [.5, .5], [-.5, .5]]) * [1, random.uniform(.75, 1)]
    corners += random.uniform(-.12, .12, corners.shape)
    corners = side * corners @ [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    corners += random.uniform(-corners.min(0), size - 1 - corners.max(0))
    return paint(part, background, corners, side, random)


def paint(part, background, corners, side, random):
    """draw, with known corners and the length of a side."""
    size = measures.size_of(background)
    homography = cv2.getPerspectiveTransform(CORNERS, np.float32(corners))
    smooth = cv2.GaussianBlur(part.astype(np.float32), (0, 0), .5 * OBJECT / side)
    on_object = cv2.warpPerspective(np.full_like(part, 255), homography, size) > 127
    moved = cv2.warpPerspective(smooth, homography, size)
    scene = background.astype(np.float32)
    scene[on_object] = np.clip(random.uniform(.6, 1.3) * moved[on_object] + random.uniform(-25, 25), 0, 255)
    return scene, homography


def make_pairs(photographs, backgrounds, number):
    pairs = []
    for i in range(number):
        random = np.random.RandomState(i)
        candidates = [k for k, photograph in enumerate(photographs) if photograph[0] == i % 2]
        half, place, _, picture = photographs[candidates[random.randint(len(candidates))]]
        others = [k for k in random.permutation(candidates) if photographs[k][1] != place]
        part = cut(picture, random)
        scene, homography = draw(part, backgrounds[others[0]], random)
        without = [k for k in others if photographs[k][1] != photographs[others[0]][1]][:ABSENT]
        pairs.append(Pair(half, part, seen(scene, random), homography, without))
    return pairs


def places(first, second):
    """How many places the matches show: cells with a match, in the image that has fewer of them."""
    return min(len(np.unique(points.astype(int) // CELL, axis=0)) for points in (first, second))


def estimate(first, second, stage):
    """The homography or None, and its number of places."""
    if len(first) < 4:
        return None, 0
    homography, inliers = cv2.findHomography(first, second, stage.estimator, stage.threshold)
    if homography is None:
        return None, 0
    inliers = inliers.ravel() > 0
    return homography, places(first[inliers], second[inliers])


def find(row, stage, norm, first, a, second, b):
    """Finds image 1 with features a in image 2 with features b: the homography or None, and its number of places."""
    if len(b.keypoints) < 2:
        return None, 0
    if row.ratio:
        two = cv2.BFMatcher(norm).knnMatch(a.descriptors, b.descriptors, 2)
        matches = measures.indices([best for best, other in two if best.distance < row.ratio * other.distance])
    else:
        matches, _ = aqorb.matchArrays(a.descriptors, b.descriptors, crossCheck=True)
    if not stage.grows:
        return estimate(*measures.points(a, b, matches), stage)
    _, *points, _ = aqorb.growMatchArrays(first, a.keypoints, second, b.keypoints, matches, scaleFactor=row.scale,
                                          bothWays=stage.both_ways)
    homography, count = estimate(*points, stage)
    if stage.is_repeated and homography is not None:
        mapped = aqorb.transformKeypoints(a.keypoints, homography)
        same = np.arange(len(mapped)).repeat(2).reshape(-1, 2)
        _, *points = aqorb.refineMatchArrays(first, a.keypoints, second, mapped, same, scaleFactor=row.scale)
        return estimate(*points, stage)
    return homography, count


def is_right(homography, true):
    if homography is None:
        return False
    errors = measures.transformed(CORNERS, homography) - measures.transformed(CORNERS, true)
    return np.linalg.norm(errors, axis=1).mean() <= RIGHT


def measure(row, name, n, pairs, backgrounds):
    """By stage: whether each pair is right, its number of places and its milliseconds of processor time, with the
    object's features computed before; and the numbers of places without the object."""
    method = Method(name)
    without = [method.compute(background, n) for background in backgrounds]
    found = {stage: ([], [], [], []) for stage in row.stages}
    for pair in pairs:
        part = method.compute(pair.part, n)
        start = time.process_time()
        scene = method.compute(pair.scene, n)
        features = time.process_time() - start
        for stage, (rights, counts, times, absent) in found.items():
            start = time.process_time()
            homography, count = find(row, stage, method.norm, pair.part, part, pair.scene, scene)
            times.append(1000 * (features + time.process_time() - start))
            rights.append(is_right(homography, pair.homography))
            counts.append(count)
            absent += [find(row, stage, method.norm, pair.part, part, backgrounds[k], without[k])[1]
                       for k in pair.absent]
    return {stage: tuple(map(np.array, each)) for stage, each in found.items()}


def share(values):
    """A share with its interval of 95 %."""
    mean = np.mean(values)
    return '{:.3f} ±{:.3f}'.format(mean, 1.96 * np.sqrt(mean * (1 - mean) / len(values)))


def rows(n, pairs, backgrounds):
    held_out = np.array([pair.half == 1 for pair in pairs])
    for row in ROWS:
        if not is_available(row.names[0].partition(':')[0]):
            continue
        tried = [measure(row, name, n, pairs, backgrounds) for name in row.names]
        for stage in row.stages:
            best = max(range(len(tried)), key=lambda i: tried[i][stage][0][~held_out].sum())
            rights, counts, times, absent = tried[best][stage]
            bound = np.quantile(absent, 1 - FALSE, method='higher')
            found = counts > bound
            settings = row.names[best].partition(':')[2] if len(tried) > 1 else ''
            yield [', '.join(filter(None, [row.title, settings, stage.title])), share(rights), share(rights[held_out]),
                   share(found), share(found[held_out]), '{:.0f}'.format(np.median(counts)), str(bound),
                   str(absent.max()), '{:.1f}'.format(np.median(times))]


def clip(part, background):
    """Frames in which the object crosses the photograph, turns by 60 degrees, and comes nearer by a quarter."""
    corners = measures.transformed(CORNERS, draw(part, background, np.random.RandomState(0))[1])
    centre, side = corners.mean(0), np.sqrt(cv2.contourArea(np.float32(corners)))
    for i, t in enumerate(np.linspace(0, 1, FRAMES)):
        turned = cv2.transform(corners[None], cv2.getRotationMatrix2D(tuple(centre), 60 * t, 1 + t / 4))[0]
        turned += t * (np.array(measures.size_of(background)) - 2 * centre)
        scene, homography = paint(part, background, turned, side * (1 + t / 4), np.random.RandomState(0))
        yield seen(scene, np.random.RandomState(i)), homography


def around(homography, shape):
    """A mask of the last outline, a fifth larger, as in the tutorial."""
    if homography is None:
        return None
    outline = measures.transformed(CORNERS, homography)
    outline = outline.mean(0) + 1.2 * (outline - outline.mean(0))
    return cv2.fillConvexPoly(np.zeros(shape, np.uint8), outline.round().astype(int), 255)


def video_rows(n, pairs, small):
    """The object of a clip in each frame, and many objects in each scene, with features of objects computed before."""
    method, row, clips = Method('aqorb'), ROWS[4], pairs[1:20:2]
    for title, is_masked in (('a clip, whole frames', False), ('a clip, around the last outline', True)):
        rights, times = [], []
        for k, pair in enumerate(clips):
            part, last = method.compute(pair.part, n), None
            for frame, true in clip(pair.part, small[pair.absent[0]]):
                start = time.process_time()
                scene = method.compute(frame, n, around(last, frame.shape) if is_masked else None)
                last, count = find(row, GROWN, method.norm, pair.part, part, frame, scene)
                last = last if count >= BELIEVED else None
                times.append(1000 * (time.process_time() - start))
                rights.append(is_right(last, true))
        yield [title, '{:.3f}'.format(np.mean(rights)), '{:.1f}'.format(np.median(times))]
    parts, rights, times = [method.compute(pair.part, n) for pair in pairs[:MANY]], [], []
    for k, pair in enumerate(pairs[:10]):
        start = time.process_time()
        scene = method.compute(pair.scene, n)
        found = [find(row, GROWN, method.norm, pair.part, part, pair.scene, scene) for part in parts]
        times.append(1000 * (time.process_time() - start))
        rights.append(is_right(found[k][0], pair.homography))
    yield ['{} objects in a scene'.format(MANY), '{:.3f}'.format(np.mean(rights)), '{:.1f}'.format(np.median(times))]


def tables(options):
    """(title, head, rows) of each table."""
    cv2.setNumThreads(1)
    aqorb.setNumThreads(1)
    photographs = list(read_photographs(folders_of(options)))
    small = [images.scaled(picture, min(1, LONGEST / max(picture.shape)))[0] for *_, picture in photographs]
    head = ['', 'right', 'held out', 'found', 'held out', 'places', 'without: 99 %', 'most', 'ms a pair']
    backgrounds = [seen(each, np.random.RandomState(k)) for k, each in enumerate(small)]
    pairs = make_pairs(photographs, small, options.pairs)
    for n in options.n:
        title = '{} objects drawn into scenes, {} scenes without them, n = {}'.format(
            len(pairs), sum(len(pair.absent) for pair in pairs), n)
        yield title, head, rows(n, pairs, backgrounds)
        yield 'aqorb in videos, n = {}'.format(n), ['', 'right', 'ms'], video_rows(n, pairs, small)
