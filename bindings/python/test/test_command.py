# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of aqorb extract. The long form, with 10,000 images and Ray, is samples/collection/test_collection.py."""

import json
import os
import random
import re
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest

import aqorb
from aqorb import _extract, colmap
from command_support import PIL, Image, command, encoded, expected, noise, pq, pycolmap, refused, rows, run, start


def test_parquet(folder, features):
    found = rows(features / 'features.parquet')
    assert list(found) == [os.fsencode(name) for name in sorted(os.listdir(str(folder)))]
    for i, row in enumerate(found.values()):
        assert row == dict(expected(noise(i)), path=b'%02d.png' % i)


def test_database(features, tmp_path):
    found = rows(features / 'features.parquet')
    # A copy, as a file that is opened gets other bytes.
    database = pycolmap.Database.open(shutil.copy(str(features / 'features.db'), str(tmp_path)))
    assert database.num_cameras() == 1 and database.num_images() == database.num_frames() == 40
    for image in database.read_all_images():
        row = found[image.name.encode()]
        keypoints = database.read_keypoints(image.image_id)
        assert np.array_equal(keypoints[:, 0], np.float32(row['x']) + np.float32(.5))
        assert database.read_descriptors(image.image_id).data.tobytes() == row['descriptors']
    database.close()


def test_metadata(features):
    from aqorb import files
    found = [files.read_metadata(str(features / f'features.{suffix}')) for suffix in ('parquet', 'db')]
    assert found[0] == found[1]
    assert found[0]['version'] == aqorb.__version__ and found[0]['reader'] == 'Pillow ' + PIL.__version__
    assert found[0]['parameters']['MaxFeatures'] == 1000 and found[0]['max size'] is None


def test_progress(folder, tmp_path, monkeypatch):
    monkeypatch.setenv('PYTHONIOENCODING', 'ascii')  # which cannot show the name
    finished = run('extract', folder, '--out', tmp_path / 'Zwölf.parquet')
    assert re.search(r'40/40 \[.*<.*image/s\]', finished.stderr)  # time, time left and rate
    assert r'Zw\xf6lf.parquet: 40 images' in finished.stdout and os.listdir(str(tmp_path)) == ['Zwölf.parquet']


def test_what_is_refused(folder, features, tmp_path):
    out = shutil.copy(str(features / 'features.parquet'), str(tmp_path))
    refused('features.parquet exists; --overwrite', 'extract', folder, '--out', out)
    assert run('extract', folder, '--out', out, '--overwrite', '--num-features', 10)
    assert max(len(row['x']) for row in rows(out).values()) <= 10
    refused('must end with .parquet or .db', 'extract', folder, '--out', tmp_path / 'features.csv')
    refused('No such file', 'extract', tmp_path / 'absent', '--out', tmp_path / 'other.parquet')
    refused('No such file', 'match', tmp_path / 'absent.parquet', '--pairs', 'exhaustive', '--out', tmp_path / 'm.parquet')
    refused('--out must name a file for the matches', 'match', out, '--pairs', 'exhaustive')
    (tmp_path / 'image.db').write_bytes(encoded(Image.fromarray(noise(0))))
    refused('no file that aqorb has written', 'match', tmp_path / 'image.db', '--pairs', 'exhaustive', '--out', out)


def test_numbers_that_are_refused(folder, tmp_path):
    for option, number in (('--num-features', 0), ('--threads', 2**31), ('--part-size', 2**64), ('--max-size', -1)):
        finished = command('extract', folder, '--out', tmp_path / 'f.parquet', option, number)
        assert finished.returncode == 2 and f'{number} is not from 1 to 2147483647' in finished.stderr


def test_outputs_that_are_refused(folder, tmp_path):
    (tmp_path / 'folder.db').mkdir()
    refused('folder.db is a folder', 'extract', folder, '--out', tmp_path / 'folder.db', '--overwrite')
    refused('must be a name in UTF-8', 'extract', folder, '--out', f'{tmp_path}/\udcff.parquet')
    mine = tmp_path / 'f.parquet.partial' / 'mine.txt'
    mine.parent.mkdir()
    mine.write_text('precious')
    refused('files that are not of this command, such as mine.txt', 'extract', folder, '--out', tmp_path / 'f.parquet')
    assert mine.read_text() == 'precious'


def test_needs_no_other_package(tmp_path):
    code = 'import sys; sys.modules.update({!r}); import aqorb; '
    for names in ['pyarrow', 'PIL', 'tqdm', 'pycolmap'], ['tqdm']:
        blocked = code.format(dict.fromkeys(names))
        run = subprocess.run([sys.executable, '-c', blocked + 'from aqorb.command import main; main()', 'extract',
                              str(tmp_path), '--out', str(tmp_path / 'x.parquet')], stderr=subprocess.PIPE, text=True)
        assert run.returncode == 1 and 'pip install pillow pyarrow' in run.stderr and 'Traceback' not in run.stderr


# Going on

def kill(folder, out, part, after=0):
    """Starts an extraction, and kills it so many seconds after a part is done, or after its start if that is None."""
    process = start('extract', folder, '--out', out, '--part-size', 7)
    while part is not None and not os.path.exists(f'{out}.partial/part-{part:06}.parquet') and process.poll() is None:
        time.sleep(.001)
    time.sleep(after)
    process.kill()
    process.communicate()


def test_what_makes_the_tables_does_not_see_the_database(tmp_path, monkeypatch):
    # It outlives a process that is killed, and would write to the file of the process that goes on.
    commands = []
    monkeypatch.setattr(colmap.subprocess, 'run', lambda command, run=subprocess.run, **options:
                        commands.append(command) or run(command, **options))
    colmap.close(colmap.create(str(tmp_path / 'a.db')))
    assert str(tmp_path) not in str(commands) and os.listdir(str(tmp_path)) == ['a.db']


def test_killed_at_random_moments(folder, features, tmp_path):
    seed = random.randrange(1 << 32)
    chance, begun = random.Random(seed), 0
    for i in range(10):
        name = 'features.' + ('parquet', 'db')[i % 2]
        out = tmp_path / name
        part = chance.choice([None, 0, 1, 2, 3, 4, 5])
        kill(folder, out, part, chance.uniform(0, 1 if part is None else .5))
        begun += os.path.exists(f'{out}.partial')
        if not out.exists() or os.path.exists(f'{out}.partial'):
            run('extract', folder, '--out', out, '--part-size', 7)
        assert out.read_bytes() == (features / name).read_bytes(), f'seed {seed}, {i}'
        assert os.listdir(str(tmp_path)) == [name], f'seed {seed}, {i}'
        out.unlink()
    assert begun, f'seed {seed}: none was killed in the middle'


def test_goes_on_where_it_was(folder, features, tmp_path):
    out = tmp_path / 'features.parquet'
    kill(folder, out, 2)
    kept = {name: os.stat(f'{out}.partial/{name}').st_mtime_ns for name in os.listdir(f'{out}.partial')}
    assert not out.exists() and 'part-000002.parquet' in kept
    for wrong, message in ((['--num-features', '999'], 'parameters'), (['--max-size', '50'], 'max size'),
                           (['--ignore-orientation'], 'EXIF orientation'),
                           (['--part-size', '8'], 'part size')):
        refused(f'partial was begun with another value of "{message}"', 'extract', folder, '--out', out, '--part-size', 7,
                *wrong)
    table = pq.read_table(f'{out}.partial/part-000000.parquet')
    metadata = dict(json.loads(table.schema.metadata[b'aqorb']), version='0.0')
    pq.write_table(table.replace_schema_metadata({**table.schema.metadata, b'aqorb': json.dumps(metadata)}),
                   f'{out}.partial/part-000000.parquet')
    refused('begun with another value of "version": 0.0', 'extract', folder, '--out', out, '--part-size', 7)
    pq.write_table(table, f'{out}.partial/part-000000.parquet')
    first = f'{out}.partial/part-000001.parquet'
    assert os.stat(first).st_mtime_ns == kept['part-000001.parquet']
    finished = run('extract', folder, '--out', out, '--part-size', 7)
    assert not re.search(r'\b0/40', finished.stderr)  # begins with what is done
    assert pq.read_table(str(out)).equals(pq.read_table(str(features / 'features.parquet')))


def test_killed_after_all_was_done(folder, features, tmp_path):
    out = shutil.copy(str(features / 'features.parquet'), str(tmp_path))
    os.mkdir(out + '.partial')
    run('extract', folder, '--out', out)
    assert os.listdir(str(tmp_path)) == ['features.parquet']


def test_files_that_are_left_out(tmp_path):
    images = tmp_path / 'images'
    (images / 'deeper').mkdir(parents=True)
    good = Image.fromarray(noise(9))
    jpeg, png = encoded(good, 'JPEG'), encoded(good)
    contents = {
        b'empty.jpg': b'', b'text.png': b'no image', b'cut.png': png[:len(png) // 2], b'cut.jpg': jpeg[:len(jpeg) // 2],
        b'head.jpg': jpeg[:3], b'zeros.tif': bytes(1000), b'cut.tif': encoded(good, 'TIFF')[:500],
        b'garbled.gif': encoded(good, 'GIF')[:60] + bytes(50),
        b'float.tif': encoded(Image.fromarray(np.zeros((9, 9), np.float32)), 'TIFF')}
    kept = {b'jpeg.txt': jpeg, b'no suffix': png, b'bytes\xff\xfe\n.png': png, 'Zwölf'.encode(): png,
            b'deeper/gif.jpg': encoded(good, 'GIF'), b'one pixel.png': encoded(good.crop((0, 0, 1, 1))), b'black.png':
            encoded(Image.new('L', (64, 48)))}
    for name, content in {**contents, **kept}.items():
        try:
            with open(os.path.join(os.fsencode(str(images)), name), 'wb') as file:
                file.write(content)
        except OSError:  # a file system that wants text
            kept.pop(name)
    os.symlink('absent', str(images / 'dangling.png'))
    os.symlink('..', str(images / 'deeper' / 'loop'))
    os.symlink('jpeg.txt', str(images / 'link'))
    os.mkfifo(str(images / 'fifo.png'))
    kept[b'link'] = jpeg
    left_out = set(contents) | {b'dangling.png', b'fifo.png'}
    out = images / 'features.parquet'  # is in the folder itself
    finished = run('extract', images, '--out', out, '--recursive')
    assert list(rows(out)) == sorted(kept)
    assert f'features.parquet: {len(kept)} images' in finished.stdout
    listed = finished.stderr.split(f'{len(left_out)} files left out:\n')[1]
    assert sorted(re.findall(r'^  (.+?): ', listed, re.MULTILINE)) == sorted(map(os.fsdecode, left_out))
    for name, reason in (('empty.jpg', 'the file is empty'), ('text.png', 'it is no image, or of a format'),
                         ('cut.jpg', '.*truncated'), ('cut.png', '.*truncated'), ('fifo.png', 'it is no regular file')):
        assert re.search(f'  {name}: {reason}', listed), listed
    again = run('extract', images, '--out', out, '--recursive', '--overwrite')
    assert list(rows(out)) == sorted(kept) and listed == again.stderr.split('left out:\n')[1]
    run('extract', images, '--out', tmp_path / 'flat.parquet')
    assert list(rows(tmp_path / 'flat.parquet')) == sorted(name for name in kept if b'/' not in name)
    run('extract', images, '--out', tmp_path / 'f.db', '--recursive')  # names are bytes there, too
    run('match', tmp_path / 'f.db', '--pairs', 'exhaustive', '--out', tmp_path / 'm.parquet')
    found = pq.read_table(str(tmp_path / 'm.parquet'))
    assert set(found['path1'].to_pylist() + found['path2'].to_pylist()) == set(kept)


def test_what_is_left_out_is_listed_after_a_stop(folder, tmp_path):
    images = shutil.copytree(str(folder), str(tmp_path / 'images'))
    (tmp_path / 'images' / '00 is no image.png').write_bytes(b'no image')
    out = tmp_path / 'features.parquet'
    kill(images, out, 2)
    assert '00 is no image.png: it is no image' in run('extract', images, '--out', out, '--part-size', 7).stderr


def test_a_folder_without_permission(tmp_path, monkeypatch):
    (tmp_path / 'closed').mkdir()
    (tmp_path / 'image').touch()
    scandir = os.scandir

    def closed(path):
        if path.endswith(b'closed'):
            raise PermissionError(13, 'Permission denied', path)
        return scandir(path)

    monkeypatch.setattr(os, 'scandir', closed)
    assert _extract.list_files(str(tmp_path), True, 'out') == ([b'image'], [(b'closed', 'Permission denied')])


def test_a_folder_without_images(tmp_path):
    (tmp_path / 'images').mkdir()
    refused('images has no files; --recursive', 'extract', tmp_path / 'images', '--out', tmp_path / 'f.parquet')
    (tmp_path / 'images' / 'text').write_text('no image')
    for suffix in 'parquet', 'db':
        assert f'{suffix}: 0 images' in run('extract', tmp_path / 'images', '--out', tmp_path / f'f.{suffix}').stdout
        assert ': 0 matches of 0 pairs' in run('match', tmp_path / f'f.{suffix}', '--pairs', 'exhaustive', '--out',
                                               tmp_path / f'{suffix}.parquet').stdout
