# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of aqorb_photographs.places and of the commands pairs, search and match --pairs retrieval:K."""

import os
import re
import shutil
import time

import numpy as np
import pytest

from aqorb_photographs import places, store
from conftest import Image, matches_of, noise, parts_of, pq, refused, run, save

COUNT = 24  # images of the clip, which returns to where it began: image i shows what image COUNT - 1 - i shows


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp('clip')
    world = np.asarray(Image.fromarray(noise(5, 400, 2400)).rotate(8, Image.BICUBIC), np.int16)[60:340]
    for i in range(COUNT):
        left = 90 + 170 * min(i, COUNT - 1 - i)
        pixels = world[:, left:left + 320] + np.random.RandomState(i).randint(-9, 10, (280, 320))
        save(folder / f'{i:02}.png', np.clip(pixels, 0, 255).astype(np.uint8))
    return folder


@pytest.fixture(scope='module')
def features(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp('features') / 'f'
    run('extract', folder, '--out', out, '--part-size', 7)
    return out


def images(seed, count):
    random = np.random.RandomState(seed)
    return [(f'{i}', random.randint(0, 256, (random.randint(0, 60), 32), np.uint8)) for i in range(count)]


def test_words_do_not_depend_on_the_order():
    collection = images(0, 600)
    words = places.choose_words(collection, 100, 7)
    assert words.shape == (100, 32) and np.array_equal(places.choose_words(collection[::-1], 100, 7), words)
    assert not np.array_equal(places.choose_words(collection, 100, 8), words)
    assert len(places.choose_words(collection)) == sum(len(descriptors) for _, descriptors in collection) // 4
    with pytest.raises(ValueError, match='3 features, too few'):
        places.choose_words([('a', np.zeros((3, 32), np.uint8))])


def test_similar_images_are_those_of_the_definition(monkeypatch):
    collection = images(1, 50)
    words = places.choose_words(collection, 200)
    table = np.zeros((50, len(words)))
    for i, (_, descriptors) in enumerate(collection):
        for row in descriptors:
            table[i, np.unpackbits(row ^ words, axis=1).sum(1).argmin()] += 1
    vectors = np.sqrt(table) * np.log(51 / np.maximum((table > 0).sum(0), 1))
    vectors /= np.maximum(np.linalg.norm(vectors, axis=1), 1e-9)[:, None]
    counts = places.count_matrix([places.words_of(descriptors, words) for _, descriptors in collection], len(words))
    weights = places.weigh(counts, places.rarity_of(counts))
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
        assert list(map(tuple, places.similar_pairs(counts, 6, min_gap))) == sorted(expected)


def test_strongest():
    descriptors = np.arange(5)[:, None]
    assert places.strongest(descriptors, [1, 5, -2, 5, 3], 3).ravel().tolist() == [1, 3, 4]
    assert len(places.strongest(descriptors, [1] * 5, 5)) == 5


def pairs_in(path):
    return {tuple(int(name[:2]) for name in line.split()) for line in path.read_text().splitlines()}


def test_a_loop_is_among_the_pairs(features, tmp_path):
    run('pairs', features, '--retrieval', 1, '--min-gap', 4, '--out', tmp_path / 'p.txt')
    found = pairs_in(tmp_path / 'p.txt')
    assert all(j - i >= 4 for i, j in found)
    assert {(i, COUNT - 1 - i) for i in range(10)} <= found
    run('pairs', features, '--retrieval', 1, '--min-gap', 4, '--sequential', 2, '--out', tmp_path / 's.txt')
    assert pairs_in(tmp_path / 's.txt') == found | {(i, i + k) for k in (1, 2) for i in range(COUNT - k)}
    refused('exists; --overwrite', 'pairs', features, '--retrieval', 1, '--out', tmp_path / 'p.txt')


def test_matches_are_verified(features, tmp_path):
    run('match', features, '--pairs', 'retrieval:2+sequential:1', '--out', tmp_path / 'm')
    run('match', features, '--pairs', 'sequential:1+retrieval:2', '--out', tmp_path / 'n')
    rows = matches_of(tmp_path / 'm')
    assert rows == matches_of(tmp_path / 'n')
    assert {(f'{i:02}.png', f'{i + 1:02}.png') for i in range(COUNT - 1)} <= set(rows)
    same, read = rows['00.png', '23.png'], store.Features(str(features))
    points = [read.keypoints(image)[0][same[name]] for image, name in ((0, 'index1'), (23, 'index2'))]
    inliers, F = places.verify(*points)
    assert len(inliers) > 100 and same['inliers'] == inliers.tolist() and np.array_equal(same['fundamental'], F.ravel())
    assert np.median(np.abs(points[0] - points[1])[inliers]) < 1  # they show the same place
    run('match', features, '--pairs', 'retrieval:2', '--no-verify', '--out', tmp_path / 'o')
    assert not any(row['inliers'] for row in matches_of(tmp_path / 'o').values())


def test_search(features, folder, tmp_path):
    shutil.copy(folder / '05.png', tmp_path / 'new\n.png')
    (tmp_path / 'text').write_text('no image')
    Image.fromarray(np.full((280, 320), 90, np.uint8)).save(tmp_path / 'grey.png')
    names = 'new\n.png', 'text', 'grey.png', 'no'
    call = ['search', features, *(tmp_path / name for name in names), '--top', 2]
    finished = run(*call, '--draw', tmp_path / 'best.jpg')
    found = [line.split('\t') for line in finished.stdout.splitlines()]
    assert found[0] == ['photograph', 'image', 'matches', 'inliers', 'ahead']
    assert [row[:2] for row in found[1:]] == [[f'{tmp_path}/new\\n.png', name] for name in ('05.png', '18.png')]
    count = len(store.Features(str(features)).keypoints(5)[0])
    assert found[1][2:4] == [str(count)] * 2 and found[2][4] == '-'
    assert 100 < int(found[2][3]) <= int(found[2][2]) < count
    assert Image.open(tmp_path / 'best.jpg').size == (640, 280)
    for reason in 'text: it is no image', 'grey.png: it has no features', 'no: there is no such file':
        assert reason in finished.stderr
    refused('3 photographs not searched for', *call, '--strict')


def test_search_compares_with_another_place(features, folder):
    found = [line.split('\t') for line in run('search', features, folder / '05.png', '--top', 20).stdout.splitlines()]
    read = store.Features(str(features))
    shared = [len(places.match(read.keypoints(5), read.keypoints(read.index[row[1]]), .8)[3]) for row in found[1:]]
    other = next(i for i, count in enumerate(shared, 1) if count < places.MIN_INLIERS)
    assert other > 2 and float(found[1][4]) == round(int(found[1][3]) / max(int(found[other][3]), 1), 1) > 10
    call = run('search', features, folder / '05.png', '--retrieval', 2)  # 05.png and 18.png show one place
    assert [line.split('\t')[4] for line in call.stdout.splitlines()[1:]] == ['-', '-']


def test_a_photograph_of_another_place(features, tmp_path):
    save(tmp_path / 'other.png', noise(77, 280, 320))
    call = ['search', features, tmp_path / 'other.png']
    finished = run(*call)
    assert re.search('probably show no place of the folder:\n.*other.png: no image has 15 inliers', finished.stderr)
    refused('no image has 15 inliers', *call, '--strict')


def index_of(path, **options):
    index = places.Index(store.Features(path, ['name', 'x', 'response', 'descriptors']), **options)
    return index.words, index.counts


def test_the_index_follows_the_parts(features, tmp_path):
    path = str(shutil.copytree(features, tmp_path / 'f'))
    words, counts = index_of(path)
    assert np.array_equal(words, index_of(str(features))[0])
    kept = parts_of(tmp_path / 'f.index')
    assert len(kept) == 5 and np.array_equal(index_of(path)[1].toarray(), counts.toarray())
    table = pq.read_table(path)
    for name in os.listdir(path)[1:]:
        os.remove(os.path.join(path, name))
    rows = {name: counts[i].toarray() for i, name in enumerate(sorted(table['name'].to_pylist()))}
    store.write_part(path, table.slice(3, 9))  # rows of others, and rows that are in the part that is left, too
    assert (index_of(path)[0] == words).all()  # it has shrunk
    read = store.Features(path)
    for i, name in enumerate(read.images):
        assert np.array_equal(index_of(path)[1][i].toarray(), rows[name]), name
    assert {name: time for name, time in parts_of(tmp_path / 'f.index').items() if name in kept}.items() <= kept.items()
    many = table.take(np.arange(100) % len(table)).set_column(0, 'name', [[f'{i}' for i in range(100)]])
    store.write_part(path, many)  # has grown a lot
    grown = index_of(path)
    assert grown[1].shape[0] == 100 + len(read.images) and len(grown[0]) > len(words)


def test_unfinished_parts_of_other_processes(features, tmp_path):
    shutil.copytree(features, tmp_path / 'f')
    index_of(str(tmp_path / 'f'))
    for name, age in ('.new.unfinished', 0), ('.old.unfinished', 7200):
        (tmp_path / 'f.index' / name).touch()
        os.utime(tmp_path / 'f.index' / name, (time.time() - age,) * 2)
    index_of(str(tmp_path / 'f'), seed=1)
    assert list(tmp_path.glob('f.index/.*')) == [tmp_path / 'f.index' / '.new.unfinished']
    assert len(os.listdir(tmp_path / 'f.index')) == 6


def test_an_index_that_is_damaged_or_cannot_be_kept(features, tmp_path):
    path = shutil.copytree(features, tmp_path / 'f')
    (tmp_path / 'f.index').write_text('a file')
    photograph = pq.read_table(str(features))['folder'][0].as_py() + '/05.png'
    finished = run('search', path, photograph, '--top', 1)
    assert '05.png' in finished.stdout and 'f.index cannot be written' in finished.stderr
    (tmp_path / 'f.index').unlink()
    run('search', path, photograph)
    for name in sorted(os.listdir(tmp_path / 'f.index')):
        content = (tmp_path / 'f.index' / name).read_bytes()
        (tmp_path / 'f.index' / name).write_bytes(content[:len(content) // 2])
        assert run('search', path, photograph, '--top', 1).stdout == finished.stdout
    options = ['--words', 500, '--seed', 3]
    run('search', path, photograph, *options)
    words = pq.read_table(tmp_path / 'f.index' / 'words.parquet')
    assert len(words) == 500
    run('search', path, photograph)  # with the words that are there
    assert pq.read_table(tmp_path / 'f.index' / 'words.parquet').equals(words)


def test_refusals(features, folder, tmp_path):
    Image.fromarray(np.full((280, 320), 90, np.uint8)).save(tmp_path / 'grey.png')
    out = tmp_path / 'p.txt'
    refused('grey.png: it has no features', 'search', features, tmp_path / 'grey.png')
    call = ['search', features, folder / '00.png']
    refused('--images must be the folder', *call, '--draw', tmp_path / 'd.jpg', '--images', '/dev')
    refused('d.txt must end with .png', *call, '--draw', tmp_path / 'd.txt')
    refused('must be at most 24, .* got 25', *call, '--retrieval', 25)
    refused('must be at most 23, .* got 24', 'pairs', features, '--retrieval', 24, '--out', out)
    refused('must be at most 23, .* got 24', 'match', features, '--pairs', 'retrieval:24', '--out', tmp_path / 'm')
    refused('--min-gap must be at most 23', 'pairs', features, '--retrieval', 2, '--min-gap', 24, '--out', out)
    refused('there is no such folder', 'search', tmp_path / 'no', folder / '00.png')
    assert os.listdir(tmp_path) == ['grey.png']
