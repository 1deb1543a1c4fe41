# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Does to the command aqorb what a day of bad luck does, and counts what comes of it: flips bits in its parts, gives it
parts that no command has made, and kills it. A part with a flipped bit may end in a sentence or in the rows of the
undamaged one. What was killed must end with the same rows as if nothing had been, when the same command is called
again. scripts/python.sh hostile prints the counts of more flips and kills, AQORB_FLIPS and AQORB_KILLS."""

import collections
import contextlib
import itertools
import os
import random
import shutil
import sqlite3
import subprocess
import time

import pyarrow as pa

from aqorb_photographs import InputError, store
from conftest import LINUX, call_of, pq

TABLES = 'images', 'cameras', 'keypoints', 'descriptors', 'matches', 'two_view_geometries', 'frame_data', 'rigs'


def content_of(path):
    """What a store or a database has, in an order that does not depend on parts."""
    if os.path.isfile(path):
        with contextlib.closing(sqlite3.connect(path)) as database:
            return [sorted(database.execute('SELECT * FROM ' + table), key=repr) for table in TABLES]
    return sorted(map(repr, pq.read_table(str(path)).to_pylist()))


def read(path):
    """What the command reads of a folder of features."""
    found = store.Features(str(path), ['name', 'x', 'y', 'response', 'descriptors'])
    found.parameters()
    return [(name, *map(bytes, found.keypoints(image))) for image, name in enumerate(found.images)]


def outcome(folder, whole=None):
    """What comes of reading a folder of features."""
    try:
        return 'the same rows' if read(folder) == whole else 'OTHER ROWS'
    except InputError as error:
        return 'a sentence' if str(folder) in str(error) and '\n' not in str(error) else 'NO SENTENCE'


def test_flipped_bits(features, tmp_path):
    count, chance = int(os.environ.get('AQORB_FLIPS', 100)), random.Random(1)
    found, whole, damaged = collections.Counter(), read(features), tmp_path / 'damaged'
    for _ in range(count):
        shutil.copytree(features, damaged)
        part = damaged / chance.choice(sorted(os.listdir(damaged)))
        content = bytearray(part.read_bytes())
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        part.write_bytes(content)
        found[outcome(damaged, whole)] += 1
        shutil.rmtree(damaged)
    print(f'{count} bits flipped in parts: {dict(found)}')
    assert set(found) == {'a sentence', 'the same rows'} and found['a sentence'] > count / 2


def crafted(table):
    """Parts that no command has made, of features that a command has."""
    columns, count = table.to_pydict(), len(table)
    for name, values, kind in (
            ('descriptors', [None] * count, pa.binary()), ('descriptors', [b'short'] * count, pa.binary()),
            ('descriptors', [value + bytes(32) for value in columns['descriptors']], pa.binary()),
            ('x', [[None]] * count, pa.list_(pa.float32())), ('x', columns['x'], pa.list_(pa.float64())),
            ('y', [[0]] * count, pa.list_(pa.float32())), ('width', [0] * count, pa.int32()),
            ('name', [None] * count, pa.string()), ('parameters', ['{'] * count, pa.string()),
            ('parameters', ['5'] * count, pa.string())):
        yield table.set_column(table.schema.get_field_index(name), name, pa.array(values, kind))
    yield from (table.drop_columns(['y']), table.select(['name']), pa.table({'a': [1]}))


def test_parts_that_no_command_has_made(features, tmp_path):
    found = collections.Counter()
    for made in crafted(pq.read_table(str(features))):
        pq.write_table(made, tmp_path / 'odd.parquet')
        found[outcome(tmp_path)] += 1
    print(f'parts that no command has made: {dict(found)}')
    assert set(found) == {'a sentence'}


@LINUX
def test_kills(folder, tmp_path):
    """Kills each of three commands at random moments, in turns, and calls it again until it ends."""
    count, seed = int(os.environ.get('AQORB_KILLS', 9)), random.randrange(1 << 32)
    chance, found, whole, seconds = random.Random(seed), collections.Counter(), {}, {}
    features, matches, database = (tmp_path / name for name in ('features', 'matches', 'x.db'))
    calls = {features: ['extract', folder, '--out', features, '--part-size', 3],
             matches: ['match', features, '--pairs', 'exhaustive', '--no-verify', '--part-size', 50, '--out', matches],
             database: ['colmap', features, matches, '--images', folder, '--database', database, '--no-refine']}
    for out, call in calls.items():
        begin = time.perf_counter()
        subprocess.run(call_of(*call, '--quiet'), check=True)
        seconds[out], whole[out] = time.perf_counter() - begin, content_of(out)
    for out, call in itertools.islice(itertools.cycle(calls.items()), count):
        shutil.rmtree(out) if out.is_dir() else out.unlink()
        process = subprocess.Popen(call_of(*call, '--quiet'))
        time.sleep(chance.uniform(.3, 1) * seconds[out])
        process.kill()
        process.wait()
        was_there = out.exists()
        if out != database or not was_there:  # a database appears when it is complete
            subprocess.run(call_of(*call, '--quiet'), check=True)
        found['the same rows' if content_of(out) == whole[out] else 'OTHER ROWS'] += 1
        found['(in the middle)'] += was_there and out != database
    print(f'{count} kills of extract, match and colmap: {dict(found)}')
    assert found['the same rows'] == count, f'seed {seed}: {found}'
