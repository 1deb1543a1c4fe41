# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of aqorb match and aqorb draw."""

import itertools
import os
import re
import shutil
import sqlite3

import numpy as np
import pytest

import aqorb
from command_support import Image, collection, expected, noise, pq, pycolmap, refused, rows, run


def matches_of(path):
    return {(row['path1'], row['path2']): row for row in pq.read_table(str(path)).to_pylist()}


def test_match(features, tmp_path):
    found = rows(features / 'features.parquet')
    names = list(found)
    (tmp_path / 'pairs.txt').write_text('03.png 01.png\n05.png\t05.png\n')
    near = [(names[i], names[j]) for i in range(40) for j in (i + 1, i + 2) if j < 40]
    for pairs, expected_pairs in (('sequential:2', near), ('exhaustive', list(itertools.combinations(names, 2))),
                                  (tmp_path / 'pairs.txt', [(b'03.png', b'01.png'), (b'05.png', b'05.png')])):
        run('match', features / 'features.parquet', '--pairs', pairs, '--out', tmp_path / 'm.parquet', '--overwrite',
            '--part-size', 50)
        matched = matches_of(tmp_path / 'm.parquet')
        assert list(matched) == expected_pairs
        for (first, second), row in matched.items():
            descriptors = [np.frombuffer(found[name]['descriptors'], np.uint8).reshape(-1, 32) for name in (first, second)]
            expected_matches, distances = aqorb.matchArrays(*descriptors, crossCheck=True)
            assert (row['index1'], row['index2']) == tuple(expected_matches.T.tolist())
            assert row['distance'] == distances.tolist()
    (tmp_path / 'pairs.txt').write_text('03.png 01.png\n03.png\n')
    for pairs in 'sequential:x', 'sequential:0', 'all':
        refused('pairs must be sequential:K, retrieval:K, .* exhaustive or a file', 'match', features / 'features.parquet', '--pairs',
                pairs, '--out', tmp_path / 'x.parquet')
    refused('ratio must be finite and at least 0, got -1', 'match', features / 'features.parquet', '--pairs', 'exhaustive', '--ratio', -1, '--out',
            tmp_path / 'x.parquet')
    refused('pairs.txt, line 2: must be the paths of two images', 'match', features / 'features.parquet', '--pairs',
            tmp_path / 'pairs.txt', '--out', tmp_path / 'x.parquet')


def test_match_options(features, tmp_path):
    run('match', features / 'features.db', '--pairs', 'sequential:1', '--out', tmp_path / 'm.parquet', '--ratio', '.9',
        '--max-distance', 70)
    found = rows(features / 'features.parquet')
    descriptors = [np.frombuffer(found[name]['descriptors'], np.uint8).reshape(-1, 32) for name in (b'00.png', b'01.png')]
    pairs, distances = aqorb.matchArrays(*descriptors, ratio=.9, crossCheck=True, maxDistance=70)
    assert matches_of(tmp_path / 'm.parquet')[b'00.png', b'01.png']['distance'] == distances.tolist()


def test_match_into_a_database(features, tmp_path):
    run('match', features / 'features.parquet', '--pairs', 'sequential:2', '--out', tmp_path / 'm.parquet')
    expected_matches = matches_of(tmp_path / 'm.parquet')
    copied = shutil.copy(str(features / 'features.db'), str(tmp_path / 'copied.db'))
    run('match', copied, '--pairs', 'sequential:2')
    for name in 'parquet', 'db':
        run('match', features / f'features.{name}', '--pairs', 'sequential:2', '--out', tmp_path / f'{name}.db')
    for path in copied, str(tmp_path / 'parquet.db'), str(tmp_path / 'db.db'):
        database = pycolmap.Database.open(path)
        ids = {image.name.encode(): image.image_id for image in database.read_all_images()}
        assert database.num_matched_image_pairs() == len(expected_matches) == 77
        for (first, second), row in expected_matches.items():
            pairs = database.read_matches(ids[first], ids[second])
            assert pairs.tolist() == [list(pair) for pair in zip(row['index1'], row['index2'])]
        database.close()
    refused('has matches; --overwrite', 'match', copied, '--pairs', 'sequential:3')
    refused('exists; --overwrite', 'match', features / 'features.db', '--pairs', 'sequential:2', '--out', copied)
    run('match', copied, '--pairs', 'sequential:1', '--overwrite')
    with sqlite3.connect(copied) as connection:
        assert connection.execute('SELECT count(*) FROM matches').fetchone() == (39,)


@pytest.mark.parametrize('suffix', ['parquet', 'db'])
def test_pairs_that_are_named_twice(features, tmp_path, suffix):
    (tmp_path / 'pairs.txt').write_text('00.png 01.png\n01.png 00.png\n\n02.png 01.png\n00.png 01.png\n')
    out = tmp_path / f'm.{suffix}'
    assert 'matches of 2 pairs' in run('match', features / 'features.parquet', '--pairs', tmp_path / 'pairs.txt', '--out', out).stdout
    if suffix == 'parquet':
        assert list(matches_of(out)) == [(b'00.png', b'01.png'), (b'02.png', b'01.png')]


def test_features_are_not_changed(features, tmp_path):
    content = (features / 'features.db').read_bytes()
    copied = tmp_path / 'f.db'
    copied.write_bytes(content)
    os.chmod(str(copied), 0o400)
    run('match', copied, '--pairs', 'sequential:1', '--out', tmp_path / 'm.parquet')
    assert copied.read_bytes() == content
    run('match', features / 'features.parquet', '--pairs', 'sequential:1', '--out', tmp_path / 'n.parquet')
    assert list(matches_of(tmp_path / 'm.parquet').values()) == list(matches_of(tmp_path / 'n.parquet').values())


def test_matches_of_another_program(features, tmp_path):
    copied = shutil.copy(str(features / 'features.db'), str(tmp_path))
    database = pycolmap.Database.open(copied)
    database.write_matches(1, 2, np.zeros((1, 2), np.uint32))
    database.close()
    refused('features.db has matches; --overwrite', 'match', copied, '--pairs', 'sequential:1')
    run('match', copied, '--pairs', 'sequential:1', '--overwrite')


@pytest.mark.skipif(os.name == 'nt', reason='needs symbolic links and permissions')
def test_a_database_keeps_its_permissions_and_its_place(features, tmp_path):
    copied, link = tmp_path / 'features.db', tmp_path / 'link.db'
    shutil.copy(str(features / 'features.db'), str(copied))
    link.symlink_to(copied)
    copied.chmod(0o400)
    refused('link.db is write-protected', 'match', link, '--pairs', 'sequential:1')
    copied.chmod(0o600)
    run('match', link, '--pairs', 'sequential:1')
    assert link.is_symlink() and copied.stat().st_mode & 0o777 == 0o600
    refused('features.db has matches', 'match', copied, '--pairs', 'sequential:1')


def test_files_without_features(features, tmp_path):
    run('match', features / 'features.parquet', '--pairs', 'sequential:1', '--out', tmp_path / 'm.parquet')
    refused('m.parquet has no features', 'match', tmp_path / 'm.parquet', '--pairs', 'sequential:1', '--out', tmp_path / 'n.parquet')
    for suffix in 'parquet', 'db':
        content = (features / f'features.{suffix}').read_bytes()
        for size in 0, len(content) // 2:
            (tmp_path / f'cut.{suffix}').write_bytes(content[:size])
            refused('aqorb: ', 'match', tmp_path / f'cut.{suffix}', '--pairs', 'exhaustive', '--out', tmp_path / 'n.parquet')


def test_a_table_has_room_for_its_descriptors():
    batch = aqorb.FeatureBatch(*[np.zeros(0)] * 7, np.array([0, 2**26]))
    with pytest.raises(ValueError, match='at most 67108863 features, got 67108864'):
        collection.to_table([b'image'], [(1, 1)], batch)


def test_lists_of_pairs(tmp_path):
    from aqorb import colmap
    colmap.write_pairs(str(tmp_path / 'pairs.txt'), [('a.png', b'b\xff.png')])
    assert (tmp_path / 'pairs.txt').read_bytes() == b'a.png b\xff.png\n'
    with pytest.raises(ValueError, match='name b.a b.png'):
        colmap.write_pairs(str(tmp_path / 'pairs.txt'), [('a b.png', 'c.png')])


def test_draw(folder, tmp_path):
    picture = tmp_path / 'matches.png'
    finished = run('draw', folder / '00.png', folder / '00.png', '--out', picture)
    count = len(expected(noise(0))['x'])
    assert re.search(rf'{count} and {count} features', finished.stdout) and Image.open(str(picture)).size == (320, 120)
    assert int(re.search(r': (\d+) matches', finished.stdout).group(1)) > count / 2
    refused('exists; --overwrite', 'draw', folder / '00.png', folder / '01.png', '--out', picture)
    (tmp_path / 'text').write_text('no image')
    refused('text: it is no image', 'draw', folder / '00.png', tmp_path / 'text', '--out', tmp_path / 'x.png')
