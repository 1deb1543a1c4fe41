# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of aqorb match, aqorb colmap and aqorb draw."""

import itertools
import json
import os
import re
import shutil

import numpy as np
import pycolmap
import pytest

import aqorb
from aqorb_photographs import colmap, store
from aqorb_photographs.cli import draw
from conftest import (Image, command, epipolar_distances, expected, geometries_of, matches_of, noise, parts_of, pq,
                      refused, rows, run, save)

# A focal length, and a place.
PLACE = {0x8769: {0xa405: 28}, 0x8825: {1: 'N', 2: (47., 30., 0.), 3: 'E', 4: (8., 15., 0.), 6: 400.}}


def descriptors_of(found, *names):
    return [np.frombuffer(found[name]['descriptors'], np.uint8).reshape(-1, 32) for name in names]


def test_match(features, tmp_path):
    found = rows(features)
    every = list(itertools.combinations(sorted(found), 2))
    near = [(first, second) for first, second in every if int(second[:2]) - int(first[:2]) <= 2]
    (tmp_path / 'pairs.txt').write_text('03.png 01.png\n')
    for pairs, pairs_expected in (('sequential:2', near), ('exhaustive', every),
                                  (tmp_path / 'pairs.txt', [('03.png', '01.png')])):
        out = tmp_path / str(len(pairs_expected))
        finished = run('match', features, '--pairs', pairs, '--no-verify', '--out', out, '--part-size', 50)
        assert f'{len(pairs_expected)} pair' in finished.stdout
        matched = matches_of(out)
        assert sorted(matched) == sorted(pairs_expected) and len(parts_of(out)) >= len(pairs_expected) // 100
        for (first, second), row in list(matched.items())[:99]:
            matches, distances = aqorb.matchArrays(*descriptors_of(found, first, second), .8, crossCheck=True)
            assert (row['index1'], row['index2']) == tuple(matches.T.tolist())
            assert row['distance'] == distances.tolist() and row['digest1'] == found[first]['digest']
    run('match', features, '--pairs', 'sequential:1', '--out', tmp_path / 'm', '--ratio', '.9', '--max-distance', 70)
    _, distances = aqorb.matchArrays(*descriptors_of(found, '00.png', '01.png'), .9, crossCheck=True, maxDistance=70)
    assert matches_of(tmp_path / 'm')['00.png', '01.png']['distance'] == distances.tolist()
    refused('ratio 0.9, not 0.8', 'match', features, '--pairs', 'sequential:2', '--out', tmp_path / 'm')


def test_pairs_that_are_new_or_changed(folder, tmp_path):
    source, out, matches = shutil.copytree(folder, tmp_path / 'images'), tmp_path / 'f', tmp_path / 'm'
    run('extract', source, '--out', out)
    run('match', out, '--pairs', 'sequential:1', '--out', matches)
    before = parts_of(matches)
    assert '39 pairs, 0 of them new' in run('match', out, '--pairs', 'sequential:1', '--out', matches).stdout
    assert parts_of(matches) == before
    assert '77 pairs, 38 of them new' in run('match', out, '--pairs', 'sequential:2', '--out', matches).stdout
    save(source / '05.png', noise(99))
    (source / '39.png').unlink()
    run('extract', source, '--out', out, '--prune')
    assert '75 pairs, 4 of them new' in run('match', out, '--pairs', 'sequential:2', '--out', matches).stdout
    digests = {name: row['digest'] for name, row in rows(out).items()}
    table = pq.read_table(str(matches)).to_pylist()
    assert len(table) == 75 and all(digests[row['name1']] == row['digest1'] for row in table)


def test_lists_of_pairs(features, tmp_path):
    text = ('\ufeff# a comment\r\n./00.png   01.png\n01.png 00.png\n\n02.png\t01.png\t.5\n').encode()
    (tmp_path / 'pairs.txt').write_bytes(text)
    for pairs in tmp_path / 'pairs.txt', '-':
        with open(tmp_path / 'pairs.txt', 'rb') as stream:
            finished = command('match', features, '--pairs', pairs, '--out', tmp_path / 'm', stdin=stream)
        assert finished.returncode == 0 and '2 pairs' in finished.stdout, finished.stderr
    assert sorted(matches_of(tmp_path / 'm')) == [('00.png', '01.png'), ('02.png', '01.png')]
    call = ['match', features, '--out', tmp_path / 'x', '--pairs']
    for line, message in (('03.png 01.png\n03.png', 'line 2: must have the names of two images'),
                          ('00.png other.png', 'line 1: must have the names'),
                          ('05.png 05.png', 'line 1: 05.png cannot be matched with itself')):
        (tmp_path / 'pairs.txt').write_text(line)
        refused(message, *call, tmp_path / 'pairs.txt')
    for pairs in 'sequential:x', 'sequential:0', 'all', 'retrieval:2+sequential:3+x', 'sequential:2+':
        refused('pairs must be sequential:K, retrieval:K, .* exhaustive or a file', *call, pairs)
    refused('ratio must be finite and at least 0, got -1', *call, 'exhaustive', '--ratio', -1)
    refused('out must name another folder', 'match', features, '--pairs', 'exhaustive', '--out', features)


@pytest.mark.parametrize('names', [('a b.png', 'a.png', 'b.png'), ('#.png', 'b\t\n\x1b[2J.png', 'c.png')])
def test_names_in_lists_of_pairs(tmp_path, names):
    for name in names:
        save(tmp_path / 'images' / name, noise(1))
    run('extract', tmp_path / 'images', '--out', tmp_path / 'f')
    run('pairs', tmp_path / 'f', '--retrieval', 2, '--out', tmp_path / 'p.txt')
    text = (tmp_path / 'p.txt').read_text()
    assert len(text.splitlines()) == 3 and '\x1b' not in text
    run('match', tmp_path / 'f', '--pairs', tmp_path / 'p.txt', '--out', tmp_path / 'm')
    assert set(itertools.chain(*matches_of(tmp_path / 'm'))) == set(names)


# COLMAP

@pytest.fixture(scope='module')
def phone(tmp_path_factory):
    """Photographs of one scene, as a phone has them, and their features and matches."""
    folder = tmp_path_factory.mktemp('phone')
    world = np.asarray(Image.fromarray(noise(5, 400, 560)).resize((1120, 800), Image.BICUBIC))
    save(folder / 'images' / 'x.webp', world[:600, :800])
    (folder / 'images' / 'a b').mkdir()
    stored = {1: None, 2: 0, 3: 3, 4: 1, 5: 5, 6: 2, 7: 6, 8: 4}
    for orientation, turn in stored.items():
        left = 10 * orientation
        image = Image.fromarray(world[20 * (orientation % 3):][:600, left:left + 800])
        exif = Image.Exif()
        exif[0x0112], exif[0x010f], exif[0x0110] = orientation, 'Maker', 'Phone'
        for tag, values in PLACE.items():
            exif[tag] = exif._ifds[tag] = values
        name = f'{orientation}.{"tif" if orientation == 8 else "jpg"}'
        (image if turn is None else image.transpose(turn)).convert('RGB').save(
            folder / 'images' / ('a b' if orientation == 3 else '.') / name, exif=exif)
    run('extract', folder / 'images', '--out', folder / 'f', '--num-features', 300)
    run('match', folder / 'f', '--pairs', 'exhaustive', '--out', folder / 'm')
    return folder


def test_export(phone, tmp_path):
    path = tmp_path / 'x.db'
    finished = run('colmap', phone / 'f', phone / 'm', '--images', phone / 'images', '--database', path, '--no-refine')
    assert os.listdir(tmp_path) == ['x.db'] and '8 images, 28 pairs' in finished.stdout
    assert 'x.webp: COLMAP cannot read it' in finished.stderr
    found, matches = rows(phone / 'f'), matches_of(phone / 'm')
    assert sum(len(row['inliers']) >= 15 for row in matches.values()) > 20  # without them the mapper finds no model
    with pycolmap.Database.open(path) as database:
        images = {image.name: image for image in database.read_all_images()}
        assert database.num_frames() == 8 and database.num_pose_priors() == 8
        assert all(np.allclose(prior.position, [47.5, 8.25, 400]) for prior in database.read_all_pose_priors())
        for name, image in images.items():
            row, camera = found[name], database.read_camera(image.camera_id)
            positions = database.read_keypoints(image.image_id)[:, :2]
            bitmap = pycolmap.Bitmap.read(phone / 'images' / name, False)
            size = (800, 600) if row['orientation'] < 5 else (600, 800)
            assert (camera.width, camera.height) == (bitmap.width, bitmap.height) == size
            assert camera.has_prior_focal_length and abs(camera.params[0] - 1000 * 28 / 43.2666) < 1
            assert database.read_descriptors(image.image_id).data.tobytes() == row['descriptors']
            # Each keypoint is where the same detector finds it in the image as it is in its file.
            pixels = np.ascontiguousarray(bitmap.to_array())
            stored = aqorb.AdaptiveQuadtreeORB_create(300).detectAndComputeArrays(pixels)[0]
            distance = np.hypot(*(positions[:, None] - (stored['pt'] + .5)).transpose(2, 0, 1)).min(1)
            assert np.mean(distance < .01) > (.9 if row['orientation'] == 1 else .3), (name, np.mean(distance < .01))
            assert (positions >= 0).all() and (positions <= size).all()
        for names in itertools.combinations(images, 2):
            pairs = database.read_matches(*(images[name].image_id for name in names))
            assert pairs.T.tolist() == [matches[names]['index1'], matches[names]['index2']]
    geometries = list(geometries_of(path))
    assert [names for names, _, _ in geometries] == [
        names for names in itertools.combinations(images, 2) if len(matches[names]['inliers']) >= 15]
    for names, points, geometry in geometries:
        row = matches[names]
        pairs = np.column_stack([row['index1'], row['index2']])
        assert geometry.inlier_matches.tolist() == pairs[row['inliers']].tolist()
        # COLMAP would begin with what the geometry says of the pose.
        assert geometry.E is None and geometry.H is None and geometry.cam2_from_cam1 is None
        assert np.median(epipolar_distances(*points, geometry.F)) < 4


def test_tracks_of_turned_images(phone, tmp_path):
    run('colmap', phone / 'f', phone / 'm', '--images', phone / 'images', '--database', tmp_path / 'x.db')
    errors = []
    for names, points, _ in geometries_of(tmp_path / 'x.db'):
        both = []
        for name, positions in zip(names, points):
            orientation = int(os.path.basename(name)[0])
            matrix, shift = colmap.turn_of(orientation, (800, 600))
            both.append((positions - .5 - shift) @ matrix + [10 * orientation, 20 * (orientation % 3)])
        errors.append(np.hypot(*(both[0] - both[1]).T))
    assert len(errors) > 20 and max(map(np.median, errors)) < .1, list(map(np.median, errors))


def test_cameras_of_the_command(phone, tmp_path):
    path = tmp_path / 'x.db'
    call = ['colmap', phone / 'f', phone / 'm', '--images', phone / 'images', '--database', path, '--no-refine',
            '--quiet']
    run(*call, '--camera-mode', 'PER_IMAGE', '--camera-model', 'PINHOLE', '--camera-params', '700,700,400,300')
    refused('x.db exists', *call)
    with pycolmap.Database.open(path) as database:
        cameras = [(camera.model.name, camera.params.tolist()) for camera in database.read_all_cameras()]
    assert cameras == [('PINHOLE', [700, 700, 400, 300])] * 8
    refused('COLMAP read none of the images', *call[:3], '--images', tmp_path, '--database', tmp_path / 'none.db',
            '--no-refine')


def test_what_colmap_still_needs(phone, tmp_path):
    call = ['colmap', phone / 'f', '--images', phone / 'images', '--database']
    assert 'COLMAP cannot match these features: run aqorb match, then' in run(*call, tmp_path / 'x.db').stdout
    run('match', phone / 'f', '--pairs', 'sequential:1', '--no-verify', '--out', tmp_path / 'm')
    call.insert(2, tmp_path / 'm')
    assert "run COLMAP's geometric_verification" in run(*call, tmp_path / 'y.db', '--no-refine').stdout


# Pictures

def test_draw(folder, tmp_path):
    picture = tmp_path / 'matches.png'
    finished = run('draw', folder / '00.png', folder / '00.png', '--out', picture)
    agree, count = map(int, re.search(r': (\d+) of (\d+) matches agree', finished.stdout).groups())
    assert agree == count > len(expected(noise(0))['x']) / 2 and Image.open(picture).size == (320, 120)
    refused('exists; --overwrite', 'draw', folder / '00.png', folder / '01.png', '--out', picture)
    refused('x.txt must end with .png', 'draw', 'absent.png', 'absent.png', '--out', tmp_path / 'x.txt')
    (tmp_path / 'text').write_text('no image')
    refused('text: it is no image', 'draw', folder / '00.png', tmp_path / 'text', '--out', tmp_path / 'x.png')


def is_red(picture):
    return (np.asarray(Image.open(picture)) == [255, 0, 0]).all(2).any()


def test_draw_verifies(folder, tmp_path):
    pixels = np.asarray(Image.fromarray(noise(5, 480, 640)).resize((960, 720), Image.BICUBIC))
    second = np.roll(pixels, 9, 1)
    second[100:240, 100:240] = pixels[140:280, 160:300]  # no geometry has both squares
    second[400:540, 600:740] = pixels[460:600, 560:700]
    for name, image in ('a.png', pixels), ('b.png', second):
        Image.fromarray(image).save(tmp_path / name)
    call = ['draw', tmp_path / 'a.png', tmp_path / 'b.png', '--num-features', 2000, '--out']
    finished = run(*call, tmp_path / 'x.png')
    agree, count = map(int, re.search(r': (\d+) of (\d+) matches agree', finished.stdout).groups())
    assert 100 < agree < count - 5 and not is_red(tmp_path / 'x.png') and finished.stderr == ''
    assert f': {agree} of {count} matches agree, ' in run(*call, tmp_path / 'all.png', '--all').stdout
    assert is_red(tmp_path / 'all.png')
    finished = command('draw', folder / '00.png', folder / '01.png', '--out', tmp_path / 'x.png', '--overwrite')
    assert re.search(r'x.png: the images probably do not show the same thing: .*, fewer than 10\n$', finished.stderr)
    assert finished.stdout == ''


def coloured(path):
    picture = np.asarray(Image.open(path)).astype(int)
    return (picture.max(2) - picture.min(2) > 30).sum()


def test_draw_spreads_few_lines(folder, tmp_path):
    same = folder / '00.png', folder / '00.png', '--num-features', 4000, '--out'
    few, every, framed = (tmp_path / name for name in ('few.png', 'all.png', 'framed.png'))
    assert run('draw', *same, few).stderr == run('draw', *same, every, '--all').stderr == ''
    result = json.loads(run('draw', *same, framed, '--outline', '--json').stdout)
    assert coloured(few) < coloured(every) and coloured(framed) > coloured(few) + 100
    assert result['same'] and len(result['matches'][0]) == 4 and result['places'] >= 20
    assert np.allclose(np.divide(result['homography'], result['homography'][2][2]), np.eye(3), atol=.01)
    assert len(draw.spread(np.array(result['matches'])[:, :2], (160, 120), 100)) == 100
    nothing = json.loads(command('draw', folder / '00.png', folder / '01.png', '--out', framed, '--overwrite',
                                 '--outline', '--json').stdout)
    assert not nothing['same'] and nothing['places'] < 10 and nothing['fundamental_matrix'] is None


def test_draw_does_not_contradict_itself(tmp_path):
    pictures = os.path.join(os.environ.get('OPENCV_TEST_DATA_PATH', ''), 'cv/shared')
    if not os.path.exists(os.path.join(pictures, 'box_in_scene.png')):
        pytest.skip('OPENCV_TEST_DATA_PATH does not name the testdata of opencv_extra')
    call = ['draw', os.path.join(pictures, 'box.png'), os.path.join(pictures, 'box_in_scene.png'), '--out']
    for number in 500, 1000:
        finished = run(*call, tmp_path / f'{number}.png', '--num-features', number)
        assert finished.stderr == '' and finished.stdout.count('\n') == 1 and 'probably show' in finished.stdout
    other = command('draw', os.path.join(pictures, 'fruits.png'), *call[2:], tmp_path / 'other.png')
    assert other.stdout == '' and other.stderr.count('\n') == 1 and 'probably do not show' in other.stderr


def test_an_image_has_room_for_its_descriptors():
    batch = aqorb.FeatureBatch(*[np.zeros(2**26)] * 7, np.array([0, 2**26]))
    with pytest.raises(ValueError, match='at most 67108863 features, got 67108864'):
        store.to_row(None, None, batch, '')
