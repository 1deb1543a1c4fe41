# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of aqorb extract, and of what all sub-commands have in common."""

import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import PIL
import pyarrow as pa
import pyarrow.dataset as dataset
import pytest

import aqorb
from aqorb_photographs import images, store
from conftest import (LINUX, Image, call_of, command, encoded, expected, noise, parts_of, peak_memory, pq, refused,
                      rows, run, save, start)
from test_damage import content_of

COMMANDS = {'extract': ['--out', 'f'], 'match': ['f', '--pairs', 'exhaustive'], 'pairs': ['f', '--retrieval', '1'],
            'search': ['f'], 'colmap': ['f', '--images', '.'], 'draw': ['a.png']}


def test_rows(folder, features):
    found = rows(features)
    assert sorted(found) == sorted(os.listdir(folder)) and len(os.listdir(features)) == 6
    for i, name in enumerate(sorted(found)):
        row, status = found[name], os.stat(folder / name)
        assert row.items() >= dict(expected(noise(i)), folder=str(folder), file_size=status.st_size, orientation=1,
                                   file_time=status.st_mtime_ns, make=None, latitude=None).items()
        assert row['version'] == f'aqorb {aqorb.__version__}, Pillow {PIL.__version__}'
        assert '"MaxFeatures": 1000' in row['parameters']


@pytest.mark.parametrize('name', COMMANDS)
def test_help_and_an_argument_too_few(name):
    assert 'usage: aqorb ' + name in run(name, '--help').stdout
    finished = command(name, *COMMANDS[name])
    assert finished.returncode == (1 if name == 'extract' else 2) and 'Traceback' not in finished.stderr
    assert 'nothing to extract' in finished.stderr or 'arguments are required' in finished.stderr


def test_a_package_that_is_missing(tmp_path):
    code = 'import sys; sys.modules["pyarrow"] = None; from aqorb_photographs.__main__ import main; main()'
    finished = subprocess.run([sys.executable, '-c', code, 'extract', tmp_path, '--out', 'f'], stderr=subprocess.PIPE,
                              text=True)
    assert finished.returncode == 1 and 'in a clone of aqorb: pip install . ./photographs' in finished.stderr
    assert '[cli]' not in finished.stderr and 'Traceback' not in finished.stderr


def test_importing_installs_nothing():
    code = 'import signal; before = signal.getsignal(2); import aqorb; assert signal.getsignal(2) is before'
    subprocess.run([sys.executable, '-c', code], check=True, env=dict(os.environ, PYTHONPATH=os.environ['PYTHONPATH']))


def test_numbers_that_are_refused(folder, tmp_path):
    for option, number in ('--num-features', 0), ('--threads', 2**31), ('--part-size', 2**64), ('--max-size', -1):
        finished = command('extract', folder, '--out', tmp_path / 'f', option, number)
        assert finished.returncode == 2 and f'{number} is not from 1 to 2147483647' in finished.stderr


def test_properties_of_the_detector(folder, tmp_path):
    out = ['--out', tmp_path / 'f']
    values = {'StrengthWeight': .5, 'EdgeThreshold': 25, 'SubPixel': 0}
    run('extract', folder / '00.png', *out, *(f'--set={name}={value}' for name, value in values.items()))
    assert json.loads(rows(tmp_path / 'f')['00.png']['parameters']).items() >= values.items()
    refused('--set Nonsense: the detector has .*StrengthWeight', 'extract', folder, *out, '--set', 'Nonsense=1')
    refused("--set EdgeThreshold: must be a number, got '1.5'", 'extract', folder, *out, '--set', 'EdgeThreshold=1.5')


def test_what_is_refused(folder, features, tmp_path):
    (tmp_path / 'f.parquet').write_text('of 0.4')
    refused('must be a folder of parts; .* extracted anew', 'extract', folder, '--out', tmp_path / 'f.parquet')
    refused('No such file', 'extract', folder, '--list', tmp_path / 'absent', '--out', tmp_path / 'f')
    refused(r'must be a name in UTF-8', 'extract', folder, '--out', f'{tmp_path}/\udcff')
    refused('there is no such folder', 'match', tmp_path / 'f', '--pairs', 'exhaustive', '--out', tmp_path / 'm')
    for option, what in (('--num-features=9', 'MaxFeatures 1000, not 9'), ('--max-size=50', 'max_size None, not 50'),
                         ('--stretch', 'stretch False, not')):
        refused(f'was made with {what}', 'extract', folder, '--out', features, option)
    before = pq.read_table(str(features))
    shutil.copytree(features, tmp_path / 'mixed')
    other = before.set_column(before.schema.get_field_index('parameters'), 'parameters', [['{}'] * len(before)])
    pq.write_table(other.slice(0, 1), tmp_path / 'mixed' / 'other.parquet')
    refused('has features of different parameters', 'pairs', tmp_path / 'mixed', '--retrieval', 1, '--out', 'p.txt')


# A collection that grows

def test_what_is_new_or_changed(folder, tmp_path):
    source, out = tmp_path / 'images', tmp_path / 'out'
    shutil.copytree(folder, source)
    (source / 'bad.png').write_bytes(b'no image')
    assert 'bad.png: it is no image' in run('extract', source, '--out', out).stderr
    before = parts_of(out)
    assert '40 images, 0 of them new' in run('extract', source, '--out', out).stdout and parts_of(out) == before
    shutil.copy(folder / '01.png', source / 'bad.png')
    save(source / '00.png', noise(99))
    save(source / 'new.png', noise(98))
    (source / '02.png').unlink()
    assert '42 images, 3 of them new' in run('extract', source, '--out', out).stdout
    found = pq.read_table(str(out))['name'].to_pylist()
    assert sorted(found) == sorted(set(os.listdir(source)) | {'02.png'})  # each once, in no order
    assert rows(out)['00.png']['descriptors'] == expected(noise(99))['descriptors']
    assert '41 images, 0 of them new; 1 gone' in run('extract', source, '--out', out, '--prune').stdout
    assert set(rows(out)) == set(os.listdir(source)) and not list(out.glob('.*'))


def test_parts_of_several_machines(folder, features, tmp_path):
    out = shutil.copytree(features, tmp_path / 'out')
    (tmp_path / 'images').mkdir()
    for name in '03.png', 'x.png':
        shutil.copy2(folder / '03.png', tmp_path / 'images' / name)
    run('extract', tmp_path / 'images', '--out', tmp_path / 'second', '--part-size', 1)
    for part in os.listdir(tmp_path / 'second'):
        shutil.copy(tmp_path / 'second' / part, out / ('0_' + part))  # as other programs name them
    assert '41 images, 0 of them new' in run('extract', folder, '--out', out).stdout
    assert sorted(pq.read_table(str(out))['name'].to_pylist()) == sorted([*os.listdir(folder), 'x.png'])
    save(tmp_path / 'images' / '04.png', noise(99))
    refused('04.png is in .* and in .* give --root', 'extract', tmp_path / 'images', '--out', out)


def test_other_programs_read_the_parts(features):
    assert dataset.dataset(str(features)).to_table(['name']).num_rows == 40
    schema = pq.read_schema(str(next(features.iterdir())))
    assert {str(schema.field(name).type) for name in ('name', 'folder', 'make', 'parameters', 'digest')} == {'string'}


def test_two_at_once(folder, features, tmp_path):
    calls = [start('extract', folder, '--out', tmp_path / 'out', '--part-size', 3) for _ in range(3)]
    for call in calls:
        assert call.communicate()[1] == '' and call.returncode == 0
    run('extract', folder, '--out', tmp_path / 'out')
    assert content_of(tmp_path / 'out') == content_of(features)


@LINUX
def test_a_full_disk(folder, features, tmp_path):
    for call in (['extract', folder, '--out', tmp_path / 'f'],
                 ['match', features, '--pairs', 'exhaustive', '--out', tmp_path / 'm'],
                 ['pairs', features, '--retrieval', 39, '--out', tmp_path / 'p.txt'],
                 ['draw', folder / '00.png', folder / '00.png', '--out', tmp_path / 'x.bmp'],
                 ['colmap', features, '--images', folder, '--database', tmp_path / 'x.db']):
        finished = command(*call, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
        assert finished.returncode == 1 and 'Traceback' not in finished.stderr, finished.stderr
        assert 'aqorb: ' in finished.stderr.splitlines()[-1]
    assert not [name for _, _, names in os.walk(tmp_path) for name in names]


@pytest.mark.parametrize('name, where', [('scale_up', 'extract'), ('clean', 'extract'), ('to_matches', 'match')])
def test_faults_of_our_own(features, tmp_path, monkeypatch, name, where):
    monkeypatch.setattr(store, name, lambda *_: np.zeros(2) + np.zeros(3))  # a ValueError of numpy
    save(tmp_path / 'new.png', noise(99))
    arguments = {'extract': [tmp_path / 'new.png', '--out', shutil.copytree(features, tmp_path / 'f')],
                 'match': [features, '--pairs', 'sequential:1', '--out', tmp_path / 'm']}[where]
    for value in '', '1':
        monkeypatch.setenv('AQORB_TRACEBACK', value)
        errors = command(where, *arguments).stderr
        assert re.search('unforeseen .*Error: .*. Please report this fault of aqorb', errors), errors
        assert ('Traceback' in errors) == bool(value)


@pytest.mark.skipif(os.name == 'nt', reason='signals of Unix')
def test_ctrl_c(folder, tmp_path):
    codes = set()
    for i in range(6):
        # A shell without job control has what it starts in the background ignore Ctrl-C.
        process = start('extract', folder, '--out', tmp_path / str(i), '--part-size', 1,
                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        while not (tmp_path / str(i)).exists() and process.poll() is None:
            time.sleep(.001)
        time.sleep(.02 * i)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=300)
        assert 'Traceback' not in errors and ('stopped' in errors) == (process.returncode == 130), errors
        codes.add(process.returncode)
    assert 130 in codes and codes <= {0, 130}


@pytest.mark.parametrize('stream', ['>&-', '>/dev/full', '2>&-', '>&- 2>&-', '| true'])
def test_outputs_that_cannot_be_written(folder, features, tmp_path, stream):
    for call in ['extract', folder, '--out', tmp_path / 'f'], ['--help'], ['search', features, folder / '00.png']:
        # Without a buffer, argparse says nothing of a text of help that it cannot write.
        script = f'unset PYTHONUNBUFFERED; "$@" {stream}'
        finished = subprocess.run(['sh', '-c', script, 'sh', *call_of(*call)], stderr=subprocess.PIPE, text=True)
        assert 'Traceback' not in finished.stderr and 'ignored' not in finished.stderr
        assert finished.returncode == (1 if 'full' in stream else 0), finished.stderr


def test_exit_codes_and_quiet(folder, tmp_path):
    (tmp_path / 'images').mkdir()
    out = ['--out', tmp_path / 'f']
    assert command('extract', tmp_path / 'images', *out).returncode == 1  # nothing was done
    (tmp_path / 'images' / 'text').write_text('no image')
    assert command('extract', tmp_path / 'images', *out).returncode == 1
    shutil.copy(folder / '00.png', tmp_path / 'images')
    finished = command('extract', tmp_path / 'images', '--strict', '--quiet', *out)
    assert finished.returncode == 1 and finished.stdout == '' and '1 file left out' in finished.stderr
    assert '%' not in finished.stderr  # no progress but on a terminal
    assert command('extract', tmp_path / 'images', *out).returncode == 0


# Which files

def test_files_that_are_left_out(tmp_path):
    source = tmp_path / 'images'
    (source / 'deeper').mkdir(parents=True)
    good = Image.fromarray(noise(9))
    png = encoded(good)
    contents = {b'empty.jpg': b'', b'text.png': b'no image', b'cut.png': png[:len(png) // 2], b'zeros.tif': bytes(1000),
                b'head.jpg': encoded(good, 'JPEG')[:3], b'cut.tif': encoded(good, 'TIFF')[:500],
                b'garbled.gif': encoded(good, 'GIF')[:60] + bytes(50)}
    kept = {b'jpeg.txt': encoded(good, 'JPEG'), b'no suffix': png, b'bytes\xff\xfe\n.png': png,
            b'deeper/gif.jpg': encoded(good, 'GIF'), b'one\tpixel.png': encoded(good.crop((0, 0, 1, 1))),
            'Zwölf \x1b#'.encode(): png}
    for name, content in {**contents, **kept}.items():
        (source / os.fsdecode(name)).write_bytes(content)
    os.symlink('absent', source / 'dangling.png')
    os.mkfifo(source / 'fifo.png')
    out = source / 'features'  # is in the folder itself
    finished = run('extract', source, '--out', out)
    assert sorted(rows(out)) == sorted(name.decode('utf-8', 'backslashreplace') for name in kept)
    listed = finished.stderr.split(f'{len(contents) + 2} files left out:\n')[1]
    for name, reason in (('empty.jpg', 'the file is empty'), ('text.png', 'it is no image, or its format'),
                         ('fifo.png', 'it is not a regular file'), ('dangling.png', 'there is no such file')):
        assert f'  {name}: {reason}' in listed, listed
    again = run('extract', source, '--out', out, '--prune')
    assert listed == again.stderr.split('left out:\n')[1] and f'{len(kept)} images, 0 of them new\n' in again.stdout
    run('match', out, '--pairs', 'exhaustive', '--out', tmp_path / 'm')
    run('pairs', out, '--retrieval', 2, '--out', tmp_path / 'p.txt')
    run('match', out, '--pairs', tmp_path / 'p.txt', '--out', tmp_path / 'm')


def test_which_files_are_listed(tmp_path):
    for name in ('a/1.jpg', 'a/b/2.JPG', 'a/b/3.png', 'a/._1.jpg', 'a/.DS_Store', 'a/@eaDir/1.jpg', 'a/Thumbs.db',
                 'a/.Trash-1000/x.jpg', 'a/.thumbnails/1.png', 'a/masks/1.jpg.png', 'elsewhere/5.jpg',
                 'f/part-1.parquet'):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    os.symlink(tmp_path / 'elsewhere', tmp_path / 'a' / 'linked')
    os.symlink('..', tmp_path / 'a' / 'b' / 'loop')
    os.symlink('linked', tmp_path / 'a' / 'again')

    def listed(*names, **options):
        found, left_out, failures = images.list_files([str(tmp_path / name) for name in names], **options)
        assert not failures
        return sorted(os.path.relpath(path, tmp_path) for path in found), left_out

    usual = ['a/1.jpg', 'a/again/5.jpg', 'a/b/2.JPG', 'a/b/3.png']
    assert listed('a') == (usual, 7)
    assert listed('a', 'a/b', 'a/._1.jpg', 'a/1.jpg') == (sorted([*usual, 'a/._1.jpg']), 7)  # what is named is taken
    assert listed('a', include=['*.jpg', '*.JPG'], exclude=['again', 'linked'])[0] == ['a/1.jpg', 'a/b/2.JPG']
    assert listed('.', out=str(tmp_path / 'a'))[0] == ['elsewhere/5.jpg']


def test_a_folder_without_permission(tmp_path, monkeypatch):
    (tmp_path / 'closed').mkdir()
    (tmp_path / 'image').touch()
    scandir = os.scandir

    def closed(path):
        if path.endswith('closed'):
            raise PermissionError(13, 'Permission denied', path)
        return scandir(path)

    monkeypatch.setattr(os, 'scandir', closed)
    assert images.list_files([str(tmp_path)]) == (
        [f'{tmp_path}/image'], 0, [(f'{tmp_path}/closed', 'Permission denied')])


def test_lists_and_several_folders(folder, tmp_path):
    for name in 'a', 'b':
        (tmp_path / name).mkdir()
        shutil.copy(folder / '00.png', tmp_path / name / 'x y.png')
    (tmp_path / 'list').write_bytes(b'\xef\xbb\xbf' + os.fsencode(tmp_path / 'a' / 'x y.png') + b'\r\n')
    for call, names in (([tmp_path / 'a', tmp_path / 'b'], ['a/x y.png', 'b/x y.png']),
                        (['--list', tmp_path / 'list'], ['x y.png']),
                        (['--list', '-', '--root', tmp_path], ['a/x y.png'])):
        with open(tmp_path / 'list', 'rb') as stream:
            assert command('extract', *call, '--out', tmp_path / 'f', '--quiet', stdin=stream).returncode == 0
        assert sorted(rows(tmp_path / 'f')) == names
        shutil.rmtree(tmp_path / 'f')


def test_masks(tmp_path):
    exif = Image.Exif()
    exif[0x0112] = 6
    save(tmp_path / 'images' / 'a.jpg', noise(1, 240, 320), quality=95, exif=exif)
    run('extract', tmp_path / 'images', '--out', tmp_path / 'f')
    mask = np.zeros((240, 320), np.uint8)
    mask[:, :160] = 255  # of the image in the file: the upper half of the upright one
    save(tmp_path / 'masks' / 'a.jpg.png', mask)
    arguments = ['extract', tmp_path / 'images', '--masks', tmp_path / 'masks', '--out', tmp_path / 'f']
    assert '1 image, 1 of them new' in run(*arguments).stdout  # it has a mask now
    row = rows(tmp_path / 'f')['a.jpg']
    assert (row['width'], row['height']) == (240, 320) and len(row['y']) > 100 and max(row['y']) < 160
    save(tmp_path / 'masks' / 'a.jpg.png', mask[1:])
    assert 'has another size' in command(*arguments).stderr


@LINUX
def test_memory_does_not_grow_with_large_images(tmp_path):
    save(tmp_path / 'images' / '0.png', np.zeros((5000, 6000, 3), np.uint8), compress_level=1)
    for i in range(1, 12):
        os.symlink('0.png', tmp_path / 'images' / f'{i}.png')
    memory = peak_memory('extract', tmp_path / 'images', '--threads', 2, '--out', tmp_path / 'f')
    assert memory < 750e3  # 1.1 GB if all images were held; a thread has one


@LINUX
def test_memory_does_not_grow_with_many_images(tmp_path):
    memory = []
    for count in 300, 2300:
        for i in range(count):
            save(tmp_path / str(count) / f'{i:05}.bmp', noise(i, 96, 128))
        memory.append(peak_memory('extract', tmp_path / str(count), '--out', tmp_path / f'{count}-features'))
    assert memory[1] < memory[0] + 10e3, memory  # 2,000 files have some 20 MB of features


def test_the_function_for_spark(folder, features):
    page = pathlib.Path(__file__).resolve().parent.parent / 'many_images.md'
    if not page.exists():
        pytest.skip('there are no documents')
    names, paths = {}, [str(path) for path in sorted(folder.iterdir())] + [__file__]
    exec(page.read_text().split('mapInArrow`:\n\n```python\n')[1].split('# Spark begins here.')[0], names)
    files = pa.table({'path': paths, 'content': [pathlib.Path(path).read_bytes() for path in paths]})
    found = pa.Table.from_batches(names['extract'](iter(files.to_batches(max_chunksize=9))))
    expected = pq.read_table(str(features)).sort_by('name')
    assert found.select(['x', 'descriptors', 'digest']).equals(expected.select(['x', 'descriptors', 'digest']))
    assert found['name'].to_pylist() == paths[:-1]
