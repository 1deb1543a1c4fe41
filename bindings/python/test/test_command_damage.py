# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of what the command aqorb does with damaged files, a full disk, little memory, and users who are in a hurry.
hostile.py does more of the first, and takes minutes."""

import os
import random
import resource
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

from command_support import Image, call_of, collection, command, encoded, noise, pq, pycolmap, refused, run, start
from conftest import LINUX

import hostile  # needs what command_support skips without

files = pytest.importorskip('aqorb.files')


def content_of(path):
    found = files.Features(str(path))
    return [(path, *[array.tobytes() for array in found.keypoints(i)]) for i, path in enumerate(found.paths)]


@pytest.mark.parametrize('suffix', ['parquet', 'db'])
def test_flipped_bytes(features, tmp_path, suffix):
    source, damaged = features / f'features.{suffix}', tmp_path / f'damaged.{suffix}'
    expected, chance, refusals = content_of(source), random.Random(1), 0
    for _ in range(150):
        damaged.write_bytes(hostile.flip(source.read_bytes(), chance))
        try:
            assert content_of(damaged) == expected
        except files.Refused as error:
            assert f'damaged.{suffix}' in str(error) and '\n' not in str(error)
            refusals += 1
    assert refusals > 75


def test_a_flipped_part(features, tmp_path):
    table, damaged = pq.read_table(str(features / 'features.parquet')), str(tmp_path / 'part-000000.parquet')
    pq.write_table(table, damaged, write_page_checksum=True)
    with open(damaged, 'rb+') as file:
        file.seek(os.path.getsize(damaged) // 2)
        file.write(b'damage')
    with pytest.raises(files.Refused, match='part-000000.parquet is damaged'):
        list(files.tables_in([damaged]))


def test_files_that_no_command_has_made(features, tmp_path):
    for path in hostile.odd_files(str(tmp_path), str(features / 'features.parquet'), str(features / 'features.db')):
        with pytest.raises(files.Refused, match=r'odd\.(parquet|db) (is damaged|has no features)'):
            content_of(path)
            list(files.Features(path).tables())  # reads the other columns, too


@LINUX
def test_kills_while_a_database_is_matched(features, tmp_path):
    assert set(hostile.kills(str(tmp_path), str(features / 'features.db'), 6, random.Random(2))) == {'whole, and goes on'}


def test_two_at_a_time_on_a_database(features, tmp_path):
    path = shutil.copy(str(features / 'features.db'), str(tmp_path))
    calls = [start('match', path, '--pairs', 'exhaustive') for _ in range(3)]
    errors = [call.communicate()[1] for call in calls]
    assert sum(call.returncode == 0 for call in calls) == 1 and not any('Traceback' in error for error in errors)
    assert all('another process is writing' in error or 'has matches' in error
               for call, error in zip(calls, errors) if call.returncode)
    assert os.listdir(str(tmp_path)) == ['features.db'] and files.count_matches(path)


def test_a_database_that_is_open_in_another_program(features, tmp_path):
    path = shutil.copy(str(features / 'features.db'), str(tmp_path))
    database = pycolmap.Database.open(path)
    refused('features.db cannot be replaced: database is locked', 'match', path, '--pairs', 'sequential:1')
    database.close()
    run('match', path, '--pairs', 'sequential:1')
    assert os.listdir(str(tmp_path)) == ['features.db']


@LINUX
@pytest.mark.parametrize('limit', [20000, 400000])
def test_a_full_disk(folder, features, tmp_path, limit):
    path = shutil.copy(str(features / 'features.db'), str(tmp_path))
    content = (features / 'features.db').read_bytes()

    def cannot_write():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    for arguments in (['extract', folder, '--out', tmp_path / 'f.db'], ['extract', folder, '--out', tmp_path / 'f.parquet'],
                      ['match', path, '--pairs', 'sequential:1']):
        finished = command(*arguments, preexec_fn=cannot_write)
        assert finished.returncode == 1 and 'Traceback' not in finished.stderr, finished.stderr
        assert 'aqorb: ' in finished.stderr.splitlines()[-1]
    assert (tmp_path / 'features.db').read_bytes() == content


def test_formats_that_are_not_read(tmp_path, monkeypatch):
    # Pillow hands an EPS to Ghostscript.
    (tmp_path / 'gs').write_text(f'#!/bin/sh\ntouch {tmp_path}/ran\n')
    (tmp_path / 'gs').chmod(0o755)
    monkeypatch.setenv('PATH', f'{tmp_path}:{os.environ["PATH"]}')
    images = tmp_path / 'images'
    images.mkdir()
    (images / 'a.png').write_bytes(encoded(Image.fromarray(noise(1)).convert('RGB'), 'EPS'))
    for kind in 'TGA', 'PCX', 'ICO':
        (images / f'b.{kind}').write_bytes(encoded(Image.fromarray(noise(1)), kind))
    assert run('extract', images, '--out', tmp_path / 'f.parquet').stderr.count('of a format that is not read') == 4
    assert not (tmp_path / 'ran').exists()


@pytest.mark.parametrize('kind', ['PNG', 'JPEG', 'TIFF', 'WEBP', 'BMP', 'PPM', 'GIF', 'JPEG2000'])
def test_formats_that_are_read(tmp_path, kind):
    (tmp_path / 'image').write_bytes(encoded(Image.fromarray(noise(1)), kind))
    with open(str(tmp_path / 'image'), 'rb') as file:
        assert np.abs(collection.read_image(file)[0].astype(int) - noise(1)).mean() < 8


@LINUX
def test_memory_does_not_grow_with_large_images(tmp_path):
    (tmp_path / 'images').mkdir()
    Image.new('RGB', (6000, 5000)).save(str(tmp_path / 'images' / '0.png'), compress_level=1)
    for i in range(1, 12):
        os.symlink('0.png', str(tmp_path / 'images' / f'{i}.png'))
    process = start('extract', tmp_path / 'images', '--threads', 2, '--out', tmp_path / 'f.parquet')
    _, status, usage = os.wait4(process.pid, 0)
    assert status == 0 and usage.ru_maxrss < 750e3  # 1.1 GB if all images were held; a thread has one


@pytest.mark.skipif(os.name == 'nt', reason='signals of Unix')
def test_ctrl_c_at_any_moment(folder, tmp_path, monkeypatch):
    monkeypatch.setenv('PYTHONPROFILEIMPORTTIME', '1')
    codes = set()
    for i in range(12):
        out = tmp_path / f'{i}.parquet'
        # A shell without job control has what it starts in the background ignore Ctrl-C.
        process = start('extract', folder, '--out', out, '--part-size', 1,
                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        assert any('aqorb._stop' in line for line in process.stderr)  # the first module of the package
        time.sleep(.08 * i)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=300)
        assert 'Traceback' not in errors and 'No module' not in errors, errors
        assert (process.returncode, out.exists()) in ((130, False), (0, True)), errors
        assert ('40 images' in output) == (process.returncode == 0)
        codes.add(process.returncode)
    assert 130 in codes


@pytest.mark.parametrize('stream', ['>&-', '>/dev/full', '2>&-', '>&- 2>&-', '| true'])
def test_outputs_that_cannot_be_written(folder, tmp_path, stream, monkeypatch):
    extract = call_of('extract', folder, '--out', tmp_path / 'f.parquet')
    finished = subprocess.run(['sh', '-c', f'"$@" {stream}', 'sh', *extract], stderr=subprocess.PIPE, text=True)
    assert 'Traceback' not in finished.stderr and 'ignored' not in finished.stderr
    assert finished.returncode == (1 if 'full' in stream else 0) and (tmp_path / 'f.parquet').exists()
    for unbuffered in '', '1':
        monkeypatch.setenv('PYTHONUNBUFFERED', unbuffered)
        finished = subprocess.run(['sh', '-c', f'"$@" {stream}', 'sh', *call_of('--help')], stderr=subprocess.PIPE,
                                  text=True)
        assert 'Traceback' not in finished.stderr and ('No space left' in finished.stderr) == ('full' in stream)


@pytest.mark.parametrize('name', ["it's a?b#c%20", 'new\nline', 'Zwölf', '-dash'])
def test_odd_paths(features, tmp_path, monkeypatch, name):
    monkeypatch.setenv('LC_ALL', 'C')
    (tmp_path / name).mkdir()
    shutil.copy(str(features / 'features.db'), str(tmp_path / name / f'{name}.db'))
    monkeypatch.chdir(str(tmp_path / name))
    assert '39 pairs' in run('match', '--pairs', 'sequential:1', '--', f'{name}.db').stdout
    assert '39 pairs' in run('match', '--pairs', 'sequential:1', f'--out={name}.parquet', '--', f'{name}.db').stdout
    assert sorted(os.listdir('.')) == sorted([f'{name}.db', f'{name}.parquet'])
