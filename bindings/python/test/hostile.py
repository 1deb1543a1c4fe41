# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Does to the command aqorb what a day of bad luck does, and counts what comes of it: flips bytes in its files, gives it files
that no command has made, and kills it while it writes. Prints a table, and fails if anything went wrong.

    python hostile.py [--flips=1000] [--kills=50] [--seed=0]

Each flipped file is matched by a process of its own. That may end in a sentence or in the matches of the undamaged
file. A database that was killed must be whole, with all its features, and the same command must end as if nothing had
been. Needs aqorb[cli], and takes some five minutes."""

import argparse
import collections
import hashlib
import json
import os
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

SAME, SENTENCE, OTHER, TRACEBACK = 'the same matches', 'a sentence', 'OTHER MATCHES', 'A TRACEBACK'
FEATURES_SQL = ('SELECT name, keypoints.data, descriptors.data, cameras.params FROM images JOIN keypoints USING (image_id) '
                'JOIN descriptors USING (image_id) JOIN cameras USING (camera_id) ORDER BY image_id')


def outcome(arguments, out, expected):
    """What becomes of a call of the command, in a fork of this process."""
    with tempfile.TemporaryFile('w+', encoding='utf-8', errors='replace') as output:
        child = os.fork()
        if not child:
            try:
                for stream in 1, 2:
                    os.dup2(output.fileno(), stream)
                signal.alarm(60)
                try:
                    command.main(arguments)
                except SystemExit as ended:
                    os._exit(10 if isinstance(ended.code, str) and print(ended.code, flush=True) is None else 11)
                os._exit(0 if matches_in(out) == expected else 12)
            except BaseException as error:
                print('Traceback', repr(error), flush=True)
                os._exit(11)
        _, status = os.waitpid(child, 0)
        output.seek(0)
        text = output.read()
    for name in os.listdir(os.path.dirname(out)):
        if name.startswith(os.path.basename(out)):
            path = os.path.join(os.path.dirname(out), name)
            shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)
    if os.WIFSIGNALED(status):
        return 'SIGNAL {}'.format(os.WTERMSIG(status))
    if 'Traceback' in text:
        return TRACEBACK
    return {0: SAME, 10: SENTENCE, 12: OTHER}.get(os.WEXITSTATUS(status), TRACEBACK)


def matches_in(path):
    table = pq.read_table(path, use_threads=False)
    return hashlib.sha256(repr(table.to_pylist()).encode()).hexdigest()


def flip(content, chance):
    damaged = bytearray(content)
    for _ in range(chance.choice((1, 1, 4))):
        damaged[chance.randrange(len(damaged))] ^= 1 << chance.randrange(8)
    return bytes(damaged)


def flips(count, chance, content, damaged, arguments, out, expected):
    found = collections.Counter()
    for _ in range(count):
        os.makedirs(os.path.dirname(damaged), exist_ok=True)
        with open(damaged, 'wb') as file:
            file.write(flip(content, chance))
        found[outcome(arguments, out, expected)] += 1
    return found


def crafted(table):
    """Files that no command has made, of features that a command has."""
    columns, metadata = table.to_pydict(), json.loads(table.schema.metadata[b'aqorb'])
    longer = [value + bytes(32) for value in columns['descriptors']]
    for number, (name, values, kind) in enumerate([
            ('descriptors', [None] * len(table), pa.binary()), ('descriptors', longer, pa.binary()),
            ('descriptors', [value[:-1] for value in columns['descriptors']], pa.binary()),
            ('descriptors', ['text'] * len(table), pa.string()), ('x', [[None]] * len(table), pa.list_(pa.float32())),
            ('x', columns['y'][1:] + columns['y'][:1], pa.list_(pa.float64())), ('path', [None] * len(table), pa.binary()),
            ('path', [b'twice'] * len(table), pa.binary()), ('octave', [[0]] * len(table), pa.list_(pa.int32()))]):
        position = table.schema.get_field_index(name)
        yield f'column{number}', table.set_column(position, name, pa.array(values, kind))
    yield 'missing', table.drop_columns(['y'])
    yield 'matches', table.select(['path'])
    for number, wrong in enumerate([[], None, 5, 'text', [metadata], float('nan')]):
        yield f'metadata{number}', table.replace_schema_metadata({'aqorb': json.dumps(wrong)})
    yield 'no metadata', table.replace_schema_metadata({})
    yield 'not JSON', table.replace_schema_metadata({'aqorb': b'\xff{'})


DATABASES = ["UPDATE descriptors SET data = 'text'", 'UPDATE descriptors SET data = NULL', 'DELETE FROM descriptors',
             'UPDATE descriptors SET rows = rows + 1', 'UPDATE descriptors SET cols = 16', 'UPDATE keypoints SET rows = 1e13',
             "UPDATE keypoints SET rows = 'x', cols = 'y'", 'DROP TABLE keypoints', 'DROP TABLE images', 'DELETE FROM aqorb',
             'UPDATE aqorb SET metadata = NULL', "UPDATE aqorb SET metadata = '[]'", "UPDATE aqorb SET metadata = '{'",
             "UPDATE images SET name = x'ff' || image_id", 'DROP TABLE aqorb']


def odd_files(folder, features, database, out, expected):
    found = collections.Counter()
    for name, table in crafted(pq.read_table(features, use_threads=False)):
        path = os.path.join(folder, name + '.parquet')
        pq.write_table(table, path)
        found[outcome(['match', path, '--pairs', 'sequential:1', '--out', out], out, expected)] += 1
    for number, statement in enumerate(DATABASES):
        path = shutil.copy(database, os.path.join(folder, f'odd{number}.db'))
        with sqlite3.connect(path) as connection:
            connection.execute(statement)
        connection.close()
        found[outcome(['match', path, '--pairs', 'sequential:1', '--out', out], out, expected)] += 1
    return found


def state(folder):
    found = []
    for parent, _, names in os.walk(folder):
        for name in names:
            try:
                status = os.stat(os.path.join(parent, name))
                found.append((name, status.st_size, status.st_mtime_ns))
            except OSError:
                pass
    return sorted(found)


def kills(folder, database, count, chance):
    """Kills a command that matches in place, when files change."""
    found = collections.Counter()
    path = os.path.join(folder, 'killed.db')
    call = [sys.executable, '-m', 'aqorb', 'match', path, '--pairs', 'exhaustive', '--part-size', '500']
    whole = sqlite3.connect(database).execute(FEATURES_SQL).fetchall()
    for number in range(count):
        for name in os.listdir(folder):
            if name.startswith('killed.db'):
                other = os.path.join(folder, name)
                shutil.rmtree(other) if os.path.isdir(other) else os.remove(other)
        shutil.copy(database, path)
        before, time_of, changes = state(folder), os.stat(path).st_mtime_ns, chance.randrange(1, 60)
        process = subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while process.poll() is None:
            now = state(folder)
            changes -= now != before
            before = now
            if (number % 2 and os.stat(path).st_mtime_ns != time_of) or (not number % 2 and changes <= 0):
                time.sleep(chance.choice((0, .0005, .002)))  # in the middle
                process.kill()
                break
        process.wait()
        try:
            connection = sqlite3.connect(path)
            intact = (connection.execute('PRAGMA integrity_check').fetchone() == ('ok',) and
                      connection.execute(FEATURES_SQL).fetchall() == whole)
            connection.close()
        except sqlite3.Error:
            intact = False
        if intact:
            again = subprocess.run(call, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            intact = again.returncode == 0 or 'has matches' in again.stderr
        found['whole, and goes on' if intact else 'DESTROYED'] += 1
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--flips', type=int, default=1000, help='of each kind of file (%(default)s)')
    parser.add_argument('--kills', type=int, default=50)
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        images, features, database = (os.path.join(folder, name) for name in ('images', 'f.parquet', 'f.db'))
        out, again = (os.path.join(folder, name, name + '.parquet') for name in ('out', 'again'))
        for place in images, os.path.dirname(out), os.path.dirname(again):
            os.mkdir(place)
        for i in range(80):
            pixels = np.random.RandomState(i).randint(0, 256, (15, 20), np.uint8)
            Image.fromarray(np.kron(pixels, np.ones((8, 8), np.uint8))).save(os.path.join(images, f'{i:02}.png'))
        extract = ['extract', images, '--out', again, '--part-size', '4']
        for arguments in (['extract', images, '--out', features], ['extract', images, '--out', database],
                          ['match', features, '--pairs', 'sequential:1', '--out', out]):
            subprocess.run([sys.executable, '-m', 'aqorb', *arguments], check=True, stderr=subprocess.DEVNULL)
        matches, table = matches_in(out), matches_in(features)
        os.remove(out)
        part = again + '.partial/part-000000.parquet'
        process = subprocess.Popen([sys.executable, '-m', 'aqorb', *extract], stderr=subprocess.DEVNULL)
        while not os.path.exists(part):
            time.sleep(.0005)
        process.kill()
        process.wait()
        with open(part, 'rb') as file:
            content = file.read()
        shutil.rmtree(again + '.partial')

        found = {'bytes flipped in a part': flips(options.flips, chance, content, part, extract, again, table)}
        for path in features, database:
            damaged = os.path.join(folder, 'damaged' + os.path.splitext(path)[1])
            with open(path, 'rb') as file:
                content = file.read()
            found['bytes flipped in a ' + os.path.splitext(path)[1]] = flips(
                options.flips, chance, content, damaged, ['match', damaged, '--pairs', 'sequential:1', '--out', out], out,
                matches)
        found['files that no command has made'] = odd_files(folder, features, database, out, matches)
        found['kills while a .db is matched'] = kills(os.path.join(folder, 'out'), database, options.kills, chance)
    print('| what was done | times | what came of it |\n|---|---|---|')
    for what, counts in found.items():
        listed = ', '.join(f'{name}: {count}' for name, count in counts.most_common())
        print(f'| {what} | {sum(counts.values())} | {listed} |')
    sys.exit(any(name.isupper() or name.startswith('SIGNAL') for counts in found.values() for name in counts))


if __name__ == '__main__':
    main()
