# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Does to the command aqorb what a day of bad luck does, and counts what comes of it: flips bits in its files, gives it
files that no command has made, and kills it while it writes. Prints a table, and fails if anything went wrong.

    python hostile.py [--flips=1000] [--kills=50]

Each flipped file is matched by a process of its own. That may end in a sentence or in the matches of the undamaged
file. A database that was killed must be whole, with all its features, and the same command must end as if nothing had
been. Needs aqorb[cli], and takes some five minutes."""

import argparse
import collections
import contextlib
import glob
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from PIL import Image

from aqorb import command

SILENT = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
OUTCOMES = {0: 'the same matches', 10: 'a sentence', 12: 'OTHER MATCHES'}
FEATURES = ('SELECT name, keypoints.data, descriptors.data, cameras.params FROM images JOIN keypoints USING (image_id) '
            'JOIN descriptors USING (image_id) JOIN cameras USING (camera_id) ORDER BY image_id')


def remove(path):
    for name in glob.glob(path + '*'):
        shutil.rmtree(name) if os.path.isdir(name) else os.remove(name)


def outcome(arguments, out, expected):
    """What becomes of a call of the command, in a fork of this process."""
    with tempfile.TemporaryFile('w+', encoding='utf-8', errors='replace') as output:
        child = os.fork()
        if not child:
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
            signal.alarm(60)
            try:
                command.main(arguments)
                os._exit(0 if rows_in(out) == expected else 12)
            except BaseException as ended:
                os._exit(10 if isinstance(ended, SystemExit) and isinstance(ended.code, str) else 11)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        output.seek(0)
        is_traceback = 'Traceback' in output.read()
    remove(out)
    return 'A TRACEBACK' if is_traceback else OUTCOMES.get(code, f'EXIT CODE {code}')


def rows_in(path):
    return pq.read_table(path, use_threads=False).to_pylist()


def flip(content, chance):
    damaged = bytearray(content)
    damaged[chance.randrange(len(damaged))] ^= 1 << chance.randrange(8)
    return bytes(damaged)


def flips(count, chance, source, damaged, arguments, out, expected):
    found, content = collections.Counter(), pathlib.Path(source).read_bytes()
    for _ in range(count):
        os.makedirs(os.path.dirname(damaged), exist_ok=True)
        pathlib.Path(damaged).write_bytes(flip(content, chance))
        found[outcome(arguments, out, expected)] += 1
    return found


def crafted(table):
    """Tables that no command has made, of features that a command has."""
    columns, count = table.to_pydict(), len(table)
    for name, values, kind in (
            ('descriptors', [None] * count, pa.binary()), ('descriptors', [b'short'] * count, pa.binary()),
            ('descriptors', [value + bytes(32) for value in columns['descriptors']], pa.binary()),
            ('x', [[None]] * count, pa.list_(pa.float32())), ('x', columns['x'], pa.list_(pa.float64())),
            ('path', [None] * count, pa.binary()), ('path', [b'twice'] * count, pa.binary()),
            ('octave', [[0]] * count, pa.list_(pa.int32()))):
        yield table.set_column(table.schema.get_field_index(name), name, pa.array(values, kind))
    yield from (table.drop_columns(['y']), table.select(['path']), table.replace_schema_metadata({}))
    for wrong in '[]', 'null', '5', '"text"', 'NaN', b'\xff{':
        yield table.replace_schema_metadata({'aqorb': wrong})


DATABASES = (
    "UPDATE descriptors SET data = 'text'", 'UPDATE descriptors SET data = NULL', 'DELETE FROM descriptors',
    'UPDATE descriptors SET rows = rows + 1', 'UPDATE keypoints SET rows = 1e13', "UPDATE keypoints SET cols = 'x'",
    'DROP TABLE keypoints', 'DROP TABLE images', 'DELETE FROM aqorb', 'UPDATE aqorb SET metadata = NULL',
    "UPDATE aqorb SET metadata = '[]'", "UPDATE aqorb SET metadata = '{'", 'DROP TABLE aqorb')


def odd_files(folder, features, database):
    """Yields the paths of files that no command has made, each of which lasts until the next one."""
    for table in crafted(pq.read_table(features, use_threads=False)):
        path = os.path.join(folder, 'odd.parquet')
        pq.write_table(table, path)
        yield path
    for statement in DATABASES:
        path = shutil.copy(database, os.path.join(folder, 'odd.db'))
        with contextlib.closing(sqlite3.connect(path)) as connection, connection:
            connection.execute(statement)
        yield path


def state(folder):
    """What tells that a file in a folder has changed."""
    with contextlib.suppress(OSError):
        return [(name, os.stat(name).st_mtime_ns) for name in sorted(glob.glob(folder + '/**', recursive=True))]


def features_in(path):
    """The features in a database, or None if it is damaged."""
    with contextlib.suppress(sqlite3.Error), contextlib.closing(sqlite3.connect(path)) as connection:
        if connection.execute('PRAGMA integrity_check').fetchone() == ('ok',):
            return connection.execute(FEATURES).fetchall()


def kills(folder, database, count, chance):
    """Kills a command that matches in place, every second time when the database itself changes, else when any file does."""
    found, path = collections.Counter(), os.path.join(folder, 'killed.db')
    call = [sys.executable, '-m', 'aqorb', 'match', path, '--pairs', 'exhaustive', '--part-size', '500']
    whole = features_in(database)
    for number in range(count):
        remove(path)
        shutil.copy(database, path)
        watched, changes = (path, 1) if number % 2 else (folder, chance.randrange(1, 60))
        before = state(watched)
        with subprocess.Popen(call, **SILENT) as process:
            while process.poll() is None and changes > 0:
                now = state(watched)
                changes, before = changes - (now != before), now
            time.sleep(chance.choice((0, .0005, .002)))  # in the middle
            process.kill()
        intact = features_in(path) == whole
        again = subprocess.run(call, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        intact = intact and (again.returncode == 0 or 'has matches' in again.stderr)
        found['whole, and goes on' if intact else 'DESTROYED'] += 1
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--flips', type=int, default=1000, help='of each kind of file (%(default)s)')
    parser.add_argument('--kills', type=int, default=50)
    options = parser.parse_args()
    chance = random.Random(0)
    with tempfile.TemporaryDirectory() as folder:
        images, killed, features, database, out, again = (os.path.join(folder, name) for name in (
            'images', 'killed', 'f.parquet', 'f.db', 'out.parquet', 'again.parquet'))
        os.mkdir(images)
        os.mkdir(killed)
        for i in range(80):
            pixels = np.random.RandomState(i).randint(0, 256, (15, 20), np.uint8)
            Image.fromarray(np.kron(pixels, np.ones((8, 8), np.uint8))).save(os.path.join(images, f'{i:02}.png'))
        aqorb, match = [sys.executable, '-m', 'aqorb'], ['--pairs', 'sequential:1', '--out', out]
        for call in (['extract', images, '--out', features], ['extract', images, '--out', database],
                     ['match', features, *match]):
            subprocess.run(aqorb + call, check=True, **SILENT)
        matches, table = rows_in(out), rows_in(features)
        remove(out)
        extract, part = ['extract', images, '--out', again, '--part-size', '4'], again + '.partial/part-000000.parquet'
        with subprocess.Popen(aqorb + extract, **SILENT) as process:
            while not os.path.exists(part):
                time.sleep(.0005)
            process.kill()
        found = {'bits flipped in a part': flips(options.flips, chance, part, part, extract, again, table)}
        for path in features, database:
            damaged = os.path.join(folder, 'damaged' + os.path.splitext(path)[1])
            found['bits flipped in a ' + os.path.splitext(path)[1]] = flips(
                options.flips, chance, path, damaged, ['match', damaged, *match], out, matches)
        found['files that no command has made'] = collections.Counter(
            outcome(['match', path, *match], out, matches) for path in odd_files(folder, features, database))
        found['kills while a .db is matched'] = kills(killed, database, options.kills, chance)
    print('| what was done | times | what came of it |\n|---|---|---|')
    for what, counts in found.items():
        listed = ', '.join(f'{name}: {number}' for name, number in counts.most_common())
        print(f'| {what} | {sum(counts.values())} | {listed} |')
    sys.exit(any(name.isupper() for counts in found.values() for name in counts))


if __name__ == '__main__':
    main()
