# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of tracks: aqorb colmap."""

import itertools
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pycolmap
import pytest

from aqorb_photographs import tracks
from conftest import (LINUX, Image, call_of, epipolar_distances, geometries_of, matches_of, noise, parts_of, refused,
                      run, save)

SIZE = 640, 480
FOCAL = 600


# A corner of three textured walls, x = 0, y = 0 and z = 0, seen by cameras that roll

def look_at(center, roll):
    """The rotation from the world to a camera at a centre that looks into the corner."""
    forward = np.subtract([.6, .6, .6], center)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    cosine, sine = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    return [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]] @ np.array([right, np.cross(forward, right), forward])


CAMERAS = {f'{i}.png': (look_at(center, roll), np.array(center)) for i, (center, roll) in enumerate(
    [((4, 3, 2.5), 0), ((3.6, 3.4, 2.6), 180), ((3.3, 3.7, 2.4), 90), ((3, 4, 2.5), 3), ((3.5, 3.5, 2.9), -90)])}


def drawn(rotation, center, textures):
    """The image of the corner. The centre of the first pixel is (0.5, 0.5), and that of the image its principal
    point."""
    columns, rows = np.meshgrid(np.arange(SIZE[0]) + .5, np.arange(SIZE[1]) + .5)
    rays = np.stack([columns - SIZE[0] / 2, rows - SIZE[1] / 2, np.full(columns.shape, FOCAL)], -1) @ rotation
    depths = -center / rays
    wall = np.where(depths > 0, depths, np.inf).argmin(-1)
    points = center + rays * np.take_along_axis(depths, wall[..., None], -1)
    pixels = np.zeros(columns.shape)
    for axis, texture in enumerate(textures):
        u, v = (np.delete(points, axis, -1) * 100 % 255).transpose(2, 0, 1)
        i, j = u.astype(int), v.astype(int)
        value = sum(texture[i + k, j + m] * abs(1 - k - u + i) * abs(1 - m - v + j) for k in (0, 1) for m in (0, 1))
        pixels[wall == axis] = value[wall == axis]
    return pixels.astype(np.uint8)


@pytest.fixture(scope='module')
def corner(tmp_path_factory):
    folder = tmp_path_factory.mktemp('corner')
    textures = [np.asarray(Image.fromarray(noise(seed, 512, 512)).resize((256, 256), Image.BICUBIC), float)
                for seed in range(3)]
    for name, camera in CAMERAS.items():
        save(folder / 'images' / name, drawn(*camera, textures))
    run('extract', folder / 'images', '--out', folder / 'f')
    run('match', folder / 'f', '--pairs', 'exhaustive', '--out', folder / 'm')
    return folder


def colmap_of(folder, path, *options):
    camera = '--camera-mode', 'SINGLE', '--camera-model', 'SIMPLE_PINHOLE', '--camera-params', '600,320,240'
    return ['colmap', folder / 'f', folder / 'm', '--images', folder / 'images', '--database', path, *camera, *options]


def epipolar_errors(path):
    """Distances of the positions of a database from the true epipolar lines, by the pair's names."""
    inverse, errors = np.linalg.inv([[FOCAL, 0, SIZE[0] / 2], [0, FOCAL, SIZE[1] / 2], [0, 0, 1]]), {}
    for names, points, _ in geometries_of(path):
        (rotation1, center1), (rotation2, center2) = (CAMERAS[name] for name in names)
        x, y, z = rotation2 @ (center1 - center2)
        essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation2 @ np.transpose(rotation1)
        errors[names] = epipolar_distances(*points, inverse.T @ essential @ inverse)
    return errors


def test_positions_in_a_drawn_scene(corner, tmp_path):
    medians = {}
    for option in '--no-refine', '--refine':
        run(*colmap_of(corner, tmp_path / option, option))
        errors = epipolar_errors(tmp_path / option)
        assert len(errors) == 10, errors.keys()
        medians[option] = [np.median(each) for each in errors.values()]
    assert max(medians['--refine']) < .03 and max(medians['--refine']) < .2 * min(medians['--no-refine']), medians


def test_distortion(corner):
    """Exact positions of cameras with strong distortion agree on an essential matrix, and only these do."""
    chance = np.random.RandomState(1)
    camera = pycolmap.Camera(model='OPENCV', width=640, height=480, params=[600, 610, 310, 250, .1, -.05, .01, -.01])
    points = chance.uniform([-1, -1, 3], [1, 1, 5], (300, 3))
    turn = np.diag([-1., -1, 1])  # by 180 degrees, where a wrong half pixel makes a whole one
    ends = [camera.img_from_cam(moved) - .5 for moved in (points, (points + [.5, .1, 0]) @ turn)]
    ends[1][200:] += chance.uniform(-9, 9, (100, 2))
    first, second = (tracks.Aligned(np.arange(part.start, part.stop), ends[side][part], ends[1 - side][part])
                     for side, part in enumerate((slice(0, 150), slice(150, 300))))
    *kept, geometry = tracks.verify(first, second, camera, camera, .01)
    assert set(range(200)) <= set(np.concatenate([one.index for one in kept])) and sum(map(len, zip(*kept))) < 210
    assert geometry.E is not None and geometry.config == pycolmap.TwoViewGeometryConfiguration.CALIBRATED
    assert tracks.verify(first, second, camera, camera, .01, min_inliers=300) is None
    camera.params = [600, 610, 310, 250, 0, 0, 0, 0]
    assert tracks.verify(first, second, camera, camera, .01, min_inliers=100) is None


def plain_join(aligned, sizes, apart):
    """What join does, without squares."""
    stars = {}
    for (image, partner), found in aligned.items():
        for index, own, other in zip(*found):
            stars.setdefault((image, index), [own, []])[1].append((partner, other))
    tracks = [[] for _ in sizes]

    def is_free(image, point):
        return all(((point - other)**2).sum() >= apart[image]**2 for _, other in tracks[image])

    order = sorted(stars, key=lambda key: (-len(stars[key][1]), sizes[key[0]][key[1]], key))
    for number, (image, index) in enumerate(order):
        own, found = stars[image, index]
        if is_free(image, own):
            found = [each for each in sorted(found, key=lambda each: each[0]) if is_free(*each)]
            for each, point in [(image, own)] + found if found else ():
                tracks[each].append((number, point))
    return tracks


def test_join():
    chance = np.random.RandomState(1)
    for images, count in ((2, 30), (5, 200), (3, 0)):
        sizes = [chance.randint(0, 3, count) for _ in range(images)]
        points, aligned = chance.uniform(-2, 30, (images, count, 2)), {}
        for image, partner in itertools.permutations(range(images), 2):
            index = np.flatnonzero(chance.uniform(size=count) < .4)
            other = chance.uniform(-2, 30, (len(index), 2))
            aligned[image, partner] = tracks.Aligned(index, points[image][index], other)
        apart = chance.uniform(1, 2, images)
        found = plain_join(aligned, sizes, apart)
        for numbers, positions, expected in zip(*tracks.join(aligned, sizes, apart), found):
            assert numbers.tolist() == [number for number, _ in expected]
            assert np.array_equal(positions, np.reshape([point for _, point in expected], (-1, 2)))
            assert len(numbers) > count / 5 or not count


# Runs

@pytest.fixture(scope='module')
def whole(corner, tmp_path_factory):
    """The database that one thread writes."""
    path = tmp_path_factory.mktemp('whole') / 'x.db'
    run(*colmap_of(corner, path, '--threads', 1))
    return path.read_bytes()


@pytest.fixture
def fresh(corner, tmp_path):
    """The same images, features and matches, without aligned positions."""
    for part in 'images', 'f', 'm':
        shutil.copytree(corner / part, tmp_path / part)
    return tmp_path


def pairs_in(folder):
    return len(matches_of(folder)) if folder.exists() else 0


def test_threads_and_parts(fresh, whole, monkeypatch):
    monkeypatch.setattr(tracks, 'MEMORY', 2 * SIZE[0] * SIZE[1])  # two images
    for number in range(2):
        run(*colmap_of(fresh, fresh / f'{number}.db', '--threads', 3, '--part-size', 3))
        assert (fresh / f'{number}.db').read_bytes() == whole
        assert pairs_in(fresh / 'm.grown') == 20 and len(os.listdir(fresh / 'm.grown')) == 4


def test_two_workers(fresh, whole):
    """Two processes each align every second pair; the command needs to align none."""
    code = """import sys
from aqorb_photographs import colmap, store, tracks
features = store.Features(sys.argv[1] + '/f', colmap.COLUMNS)
matches = store.Matches(sys.argv[1] + '/m', features)
matches.pairs = matches.pairs[int(sys.argv[2])::2]
tracks.grow(features, matches, sys.argv[1] + '/images')"""
    workers = [subprocess.Popen([sys.executable, '-c', code, fresh, str(number)]) for number in (0, 1)]
    assert [worker.wait() for worker in workers] == [0, 0] and pairs_in(fresh / 'm.grown') == 20
    before = parts_of(fresh / 'm.grown')
    run(*colmap_of(fresh, fresh / 'x.db'))
    assert (fresh / 'x.db').read_bytes() == whole and parts_of(fresh / 'm.grown') == before


@LINUX
def test_kills(fresh, whole):
    count, seed, done, full = int(os.environ.get('AQORB_KILLS', 4)), random.randrange(1 << 32), 0, 0
    chance, call = random.Random(seed), call_of(*colmap_of(fresh, fresh / 'x.db', '--part-size', 1))
    for _ in range(count):
        process = subprocess.Popen(call, start_new_session=True)
        time.sleep(chance.uniform(.5, 4))
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        found = pairs_in(fresh / 'm.grown')
        assert found >= done, seed
        if (fresh / 'x.db').exists():
            assert (fresh / 'x.db').read_bytes() == whole, seed
            (fresh / 'x.db').unlink()
        done = found if found < 20 else shutil.rmtree(fresh / 'm.grown') or 0
        full += found == 20
    subprocess.run(call, check=True)
    assert (fresh / 'x.db').read_bytes() == whole, seed
    print(f'{count} kills, {full} of them after all pairs were aligned; seed {seed}')


def counts_in(path):
    """The numbers of keypoints of the images in a database."""
    with pycolmap.Database.open(path) as database:
        return [len(database.read_keypoints(image.image_id)) for image in database.read_all_images()]


def test_what_is_not_as_it_was(fresh):
    shutil.rmtree(fresh / 'f')
    run('extract', fresh / 'images', '--out', fresh / 'f')
    call = colmap_of(fresh, fresh / 'x.db')
    image = fresh / 'images' / '0.png'
    original = image.read_bytes()
    image.unlink()
    refused('0.png is missing: .* run aqorb extract with --out .*/f --prune', *call)
    image.write_bytes(original + b' ')
    refused('0.png has changed .* run aqorb extract with --out .*/f, then aqorb match', *call)
    save(image, noise(9, 480, 640))
    run('extract', fresh / 'images', '--out', fresh / 'f')
    for option in '--refine', '--no-refine':
        refused('m has 4 pairs, such as 0.png and 1.png, whose features have changed since they were matched: run '
                'aqorb match .*/f with --out .*/m$', *call, option)
    run('match', fresh / 'f', '--pairs', 'exhaustive', '--out', fresh / 'm')
    run(*call)
    assert counts_in(fresh / 'x.db')[0] == 0
    refused('absent has no matches of .*/f: run aqorb match', 'colmap', fresh / 'f', fresh / 'absent', *call[3:5],
            '--database', fresh / 'y.db')


def test_images_that_few_positions_connect(fresh):
    """Below the floor an image is connected by its matches as detected."""
    counts = []
    for floor in 40, 1500:
        run(*colmap_of(fresh, fresh / f'{floor}.db', '--min-inliers', floor))
        counts.append(counts_in(fresh / f'{floor}.db'))
    assert min(counts[1]) > 15 and sum(counts[1]) < sum(counts[0])
