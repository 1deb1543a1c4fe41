# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of aqorb.places and of the commands pairs, search and match --pairs retrieval:K."""

import os
import shutil
import sqlite3
import time

import numpy as np
import pytest

pytest.importorskip('scipy')
from command_support import Image, noise, pq, pycolmap, refused, run, start  # noqa: E402
from aqorb import files, places  # noqa: E402

COUNT = 24  # images of the clip, which returns to where it began: image i shows what image COUNT - 1 - i shows


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('clip')
    world = np.asarray(Image.fromarray(noise(5, 400, 2400)).rotate(8, Image.BICUBIC), np.int16)[60:340]
    for i in range(COUNT):
        left = 90 + 170 * min(i, COUNT - 1 - i)
        pixels = world[:, left:left + 320] + np.random.RandomState(i).randint(-9, 10, (280, 320))
        Image.fromarray(np.clip(pixels, 0, 255).astype(np.uint8)).save(str(folder / f'{i:02}.png'))
    return folder


@pytest.fixture(scope='module')
def features(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp('features')
    for name in 'features.parquet', 'features.db':
        run('extract', folder, '--out', out / name)
    return out


def images(seed, count):
    random = np.random.RandomState(seed)
    return [(b'%d' % i, random.randint(0, 256, (random.randint(0, 60), 32), np.uint8)) for i in range(count)]


def test_words_do_not_depend_on_the_order_or_the_parts():
    collection = images(0, 600)
    whole = places.words([places.draw(collection, 100, 7)], 100)
    parts = [places.draw(part, 100, 7) for part in (collection[:5:-1], collection[2:6], collection[:2])]
    assert whole.shape == (100, 32) and np.array_equal(places.words(parts, 100), whole)
    assert not np.array_equal(places.words([places.draw(collection, 100, 8)], 100), whole)
    features = sum(len(descriptors) for _, descriptors in collection)
    assert len(places.words([places.draw(collection)])) == features // 4
    with pytest.raises(ValueError, match='3 features, too few'):
        places.words([places.draw([(b'a', np.zeros((3, 32), np.uint8))])])


def test_similar_images_are_those_of_the_definition(monkeypatch):
    collection = images(1, 50)
    words = places.words([places.draw(collection)], 200)
    table = np.zeros((50, len(words)))
    for i, (_, descriptors) in enumerate(collection):
        for row in descriptors:
            table[i, np.unpackbits(row ^ words, axis=1).sum(1).argmin()] += 1
    vectors = np.sqrt(table) * np.log(51 / np.maximum((table > 0).sum(0), 1))
    vectors /= np.maximum(np.linalg.norm(vectors, axis=1), 1e-9)[:, None]
    counts = places.count([places.words_of(descriptors, words) for _, descriptors in collection], len(words))
    weights = places.weigh(counts, places.rarity(counts))
    assert np.array_equal(counts.toarray(), table) and np.allclose(weights.toarray(), vectors, atol=1e-6)
    monkeypatch.setattr(places, 'BLOCK', 7 * 50)
    for min_gap in 0, 1, 9:
        similarity = vectors @ vectors.T
        i, j = np.indices(similarity.shape)
        similarity[abs(i - j) < min_gap] = -1
        blocks = list(places.similar(weights, weights, 6, min_gap))
        assert [start for start, _, _ in blocks] == list(range(0, 50, 7))
        indices, found = (np.concatenate([block[part] for block in blocks]) for part in (1, 2))
        assert np.allclose(found, -np.sort(-similarity, 1)[:, :6], atol=1e-6)
        assert np.allclose(np.take_along_axis(similarity, indices, 1), found, atol=1e-6)
        expected = {(min(a, b), max(a, b)) for a, row in enumerate(indices) for b in row if similarity[a, b] > 1e-6}
        pairs = places.pairs(iter(blocks), 50)
        assert list(map(tuple, pairs)) == sorted(expected)
        assert np.allclose(places.similarities(weights, pairs, 10), similarity[pairs[:, 0], pairs[:, 1]], atol=1e-6)


def test_strongest():
    descriptors = np.arange(5)[:, None]
    assert places.strongest(descriptors, [1, 5, -2, 5, 3], 3).ravel().tolist() == [1, 3, 4]
    assert len(places.strongest(descriptors, None, 3)) == 5


def lines(path):
    return [line.split() for line in path.read_text().splitlines()]


def test_a_loop_is_among_the_pairs(features, tmp_path):
    run('pairs', features / 'features.parquet', '--retrieval', 1, '--min-gap', 4, '--out', tmp_path / 'p.txt')
    found = {tuple(int(name[:2]) for name in line) for line in lines(tmp_path / 'p.txt')}
    assert all(j - i >= 4 for i, j in found)
    assert {(i, COUNT - 1 - i) for i in range(10)} <= found
    run('pairs', features / 'features.parquet', '--retrieval', 1, '--min-gap', 4, '--sequential', 2, '--scores',
        '--out', tmp_path / 's.txt')
    joined = {tuple(int(name[:2]) for name in line[:2]): float(line[2]) for line in lines(tmp_path / 's.txt')}
    assert set(joined) == found | {(i, i + k) for k in (1, 2) for i in range(COUNT - k)}
    assert all(0 <= score <= 1 for score in joined.values()) and joined[0, COUNT - 1] > .3
    # The database has no responses, but few images have more than 500 features.
    finished = run('pairs', features / 'features.db', '--retrieval', 1, '--min-gap', 4, '--out', tmp_path / 'd.txt')
    assert 'features.db has no responses' in finished.stderr


def test_matches_are_verified(features, tmp_path):
    run('match', features / 'features.parquet', '--pairs', 'retrieval:2+sequential:1', '--out', tmp_path / 'm.parquet')
    table = pq.read_table(str(tmp_path / 'm.parquet')).to_pylist()
    rows = {(row['path1'], row['path2']): row for row in table}
    assert len(rows) == len(table) and {(b'%02d.png' % i, b'%02d.png' % (i + 1)) for i in range(COUNT - 1)} <= set(rows)
    same = rows[b'00.png', b'23.png']
    read = files.Features(str(features / 'features.parquet'))
    points = [read.keypoints(image)[0][same[name]] for image, name in ((0, 'index1'), (23, 'index2'))]
    inliers, F = places.verify(*points)
    assert len(inliers) > 100 and same['inliers'] == inliers.tolist() and np.array_equal(same['fundamental'], F.ravel())
    assert np.median(np.abs(points[0] - points[1])[inliers]) < 1  # they show the same place

    run('match', features / 'features.parquet', '--pairs', 'retrieval:2', '--out', tmp_path / 'm.db')
    run('match', features / 'features.parquet', '--pairs', 'retrieval:2', '--no-verify', '--out',
        tmp_path / 'n.parquet')
    assert 'inliers' not in pq.read_schema(str(tmp_path / 'n.parquet')).names
    database = pycolmap.Database.open(str(tmp_path / 'm.db'))
    assert database.num_matched_image_pairs() == pq.read_metadata(str(tmp_path / 'n.parquet')).num_rows
    geometry = database.read_two_view_geometry(1, 24)
    database.close()
    assert np.array_equal(geometry.inlier_matches, np.column_stack([same['index1'], same['index2']])[inliers])
    # COLMAP would begin with what the geometry says of the pose.
    assert geometry.E is None and geometry.H is None and geometry.cam2_from_cam1 is None
    with sqlite3.connect(str(tmp_path / 'm.db')) as connection:
        assert connection.execute('SELECT min(rows) FROM two_view_geometries').fetchone()[0] >= 15


def test_pairs_that_are_killed_go_on(features, tmp_path):
    arguments = ['pairs', features / 'features.parquet', '--retrieval', 3, '--part-size', 1]
    run(*arguments, '--out', tmp_path / 'whole.txt')
    out = tmp_path / 'p.txt'
    process = start(*arguments, '--out', out)
    part = tmp_path / 'p.txt.partial' / 'part-000002.parquet'
    while process.poll() is None and not part.exists():
        time.sleep(.001)
    process.kill()
    process.wait()
    assert not out.exists()
    time_of_part = part.stat().st_mtime_ns
    refused('begun with another value of "vocabulary"', *arguments, '--seed', 1, '--out', out)
    assert part.stat().st_mtime_ns == time_of_part
    run(*arguments, '--out', out)
    assert out.read_bytes() == (tmp_path / 'whole.txt').read_bytes() and not part.parent.exists()
    refused('exists; --overwrite', *arguments, '--out', out)


def test_search(features, folder, tmp_path):
    shutil.copy(str(folder / '05.png'), str(tmp_path / 'new\n.png'))
    (tmp_path / 'text').write_text('no image')
    Image.fromarray(np.full((280, 320), 90, np.uint8)).save(str(tmp_path / 'grey.png'))
    finished = run('search', features / 'features.parquet', tmp_path / 'new\n.png', tmp_path / 'text',
                   tmp_path / 'grey.png', '--top', 2, '--draw', tmp_path / 'best.jpg', '--folder', folder)
    found = [line.split('\t') for line in finished.stdout.splitlines()]
    assert found[0] == ['photograph', 'image', 'matches', 'inliers']
    assert [row[:2] for row in found[1:]] == [[f'{tmp_path}/new\\n.png', name] for name in ('05.png', '18.png')]
    count = len(files.Features(str(features / 'features.parquet')).keypoints(5)[0])
    assert found[1][2:] == [str(count)] * 2 and 100 < int(found[2][3]) <= int(found[2][2]) < count
    assert Image.open(str(tmp_path / 'best.jpg')).size == (640, 280)
    assert 'text is not searched for: it is no image' in finished.stderr
    assert 'grey.png is not searched for: it has no features' in finished.stderr
    finished = run('search', features / 'features.db', tmp_path / 'new\n.png', '--top', 1)
    assert finished.stdout.splitlines()[1].split('\t')[1] == '05.png'


def test_refusals(features, folder, tmp_path):
    Image.fromarray(np.full((280, 320), 90, np.uint8)).save(str(tmp_path / 'grey.png'))
    parquet, photograph, out = features / 'features.parquet', folder / '00.png', tmp_path / 'p.txt'
    refused('grey.png is not searched for: it has no features', 'search', parquet, tmp_path / 'grey.png')
    refused('nothing.png is not searched for: there is no such file', 'search', parquet, tmp_path / 'nothing.png')
    refused("--folder must be where the images of .* are, got '/dev'", 'search', parquet, photograph, '--draw',
            tmp_path / 'drawn.jpg', '--folder', '/dev')
    refused('must be at most 24, .* got 25', 'search', parquet, photograph, '--retrieval', 25)
    refused('must be at most 23, .* got 24', 'pairs', parquet, '--retrieval', 24, '--out', out)
    refused('must be at most 23, .* got 24', 'match', parquet, '--pairs', 'retrieval:24', '--out',
            tmp_path / 'm.parquet')
    refused('--min-gap must be at most 23', 'pairs', parquet, '--retrieval', 2, '--min-gap', 24, '--out', out)
    for words in np.zeros((9, 64), np.uint8), np.zeros((9, 32)), np.zeros((0, 32), np.uint8):
        np.save(str(tmp_path / 'words.npy'), words)
        refused('a vocabulary must be descriptors of 32 bytes', 'search', parquet, photograph, '--vocabulary',
                tmp_path / 'words.npy')
    (tmp_path / 'words.npy').write_bytes(b'no words')
    refused(f'{tmp_path}: Is a directory', 'search', parquet, photograph, '--vocabulary', tmp_path)
    refused('words.npy is damaged', 'search', parquet, photograph, '--vocabulary', tmp_path / 'words.npy')
    (tmp_path / 'pairs.txt').write_text('00.png other.png .5\n')
    refused('pairs.txt, line 1: must be the paths', 'match', parquet, '--pairs', tmp_path / 'pairs.txt', '--out',
            tmp_path / 'm.parquet')
    refused('pairs.txt must end with .parquet or .db', 'search', tmp_path / 'pairs.txt', photograph)
    assert set(os.listdir(str(tmp_path))) == {'grey.png', 'words.npy', 'pairs.txt'}


def test_a_vocabulary_is_kept(features, tmp_path):
    arguments = ['pairs', features / 'features.parquet', '--retrieval', 3, '--vocabulary', tmp_path / 'words.npy']
    run(*arguments, '--words', 500, '--seed', 3, '--out', tmp_path / 'a.txt')
    assert np.load(str(tmp_path / 'words.npy')).shape == (500, 32)
    run(*arguments, '--out', tmp_path / 'b.txt')
    assert (tmp_path / 'a.txt').read_bytes() == (tmp_path / 'b.txt').read_bytes()
    refused('words.npy has 500 words, not 600', *arguments, '--words', 600, '--out', tmp_path / 'c.txt')


def test_exhaustive_says_how_long(features, tmp_path):
    finished = run('match', features / 'features.parquet', '--pairs', 'exhaustive', '--out', tmp_path / 'm.parquet')
    assert finished.stderr.startswith('276 pairs: about a minute') and 'retrieval' not in finished.stderr
