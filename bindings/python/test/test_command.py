# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of the command aqorb. The long form, with 10,000 images and Ray, is samples/collection/test_collection.py."""

import io
import itertools
import json
import os
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import stat
import subprocess
import sys
import time

import numpy as np
import pytest

import aqorb

pytest.importorskip('tqdm')
pycolmap = pytest.importorskip('pycolmap')
pa = pytest.importorskip('pyarrow')
pq = pytest.importorskip('pyarrow.parquet')
PIL = pytest.importorskip('PIL')
Image = pytest.importorskip('PIL.Image')
collection = pytest.importorskip('aqorb.collection')

FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(aqorb.__file__)))


def command(*arguments, **options):
    """A finished process of the command."""
    return subprocess.run([sys.executable, '-m', 'aqorb', *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, env=dict(os.environ, PYTHONPATH=FOLDER), timeout=300,
                          **dict({'text': True, 'errors': 'surrogateescape'}, **options))


def run(*arguments):
    finished = command(*arguments)
    assert finished.returncode == 0, finished.stderr
    return finished


def refused(message, *arguments):
    finished = command(*arguments)
    assert finished.returncode == 1 and re.search(message, finished.stderr), finished.stderr
    assert 'Traceback' not in finished.stderr


def noise(seed, height=120, width=160):
    pixels = np.random.RandomState(seed).randint(0, 256, (height // 8, width // 8), np.uint8)
    return np.repeat(np.repeat(pixels, 8, 0), 8, 1)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Forty images."""
    folder = tmp_path_factory.mktemp('images')
    for i in range(40):
        Image.fromarray(noise(i)).save(str(folder / f'{i:02}.png'))
    return folder


@pytest.fixture(scope='module')
def features(folder, tmp_path_factory):
    """A file of each kind with the features of those."""
    out = tmp_path_factory.mktemp('features')
    for suffix in 'parquet', 'npz', 'db':
        run('extract', folder, '--out', out / f'features.{suffix}', '--part-size', 7)
    return out


def rows(path):
    return {row['path']: row for row in pq.read_table(str(path)).to_pylist()}


def expected(pixels, features=1000):
    """The columns of a grey image, by detectAndComputeArrays."""
    keypoints, descriptors = aqorb.AdaptiveQuadtreeORB_create(features).detectAndComputeArrays(pixels)
    columns = {name: keypoints[name].tolist() for name in ('size', 'angle', 'response', 'octave')}
    return dict(columns, x=keypoints['pt'][:, 0].tolist(), y=keypoints['pt'][:, 1].tolist(),
                descriptors=descriptors.tobytes(), width=pixels.shape[1], height=pixels.shape[0])


def test_parquet(folder, features):
    found = rows(features / 'features.parquet')
    assert list(found) == [os.fsencode(name) for name in sorted(os.listdir(str(folder)))]
    for i, row in enumerate(found.values()):
        assert row == dict(expected(noise(i)), path=b'%02d.png' % i)


def test_npz(features):
    table = pq.read_table(str(features / 'features.parquet'))
    with np.load(str(features / 'features.npz')) as file:
        offsets = file['offsets']
        assert file['path'].tolist() == table['path'].to_pylist() and len(offsets) == 41
        for name in 'x', 'y', 'size', 'angle', 'response', 'octave':
            assert np.array_equal(file[name], table[name].combine_chunks().flatten())
        assert file['descriptors'].tobytes() == b''.join(table['descriptors'].to_pylist())
        assert file['descriptors'].shape == (offsets[-1], 32) and np.all(file['width'] == 160)


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
    found = [files.read_metadata(str(features / f'features.{suffix}')) for suffix in ('parquet', 'npz', 'db')]
    assert found[0] == found[1] == found[2]
    assert found[0]['version'] == aqorb.__version__ and found[0]['reader'] == 'Pillow ' + PIL.__version__
    assert found[0]['parameters']['MaxFeatures'] == 1000 and found[0]['max size'] is None


def test_progress(folder, tmp_path):
    finished = run('extract', folder, '--out', tmp_path / 'features.parquet')
    assert re.search(r'40/40 \[.*<.*image/s\]', finished.stderr)  # time, time left and rate
    assert 'features.parquet: 40 images' in finished.stdout and os.listdir(str(tmp_path)) == ['features.parquet']


def test_what_is_refused(folder, features, tmp_path):
    out = shutil.copy(str(features / 'features.parquet'), str(tmp_path))
    refused('features.parquet exists; --overwrite', 'extract', folder, '--out', out)
    assert run('extract', folder, '--out', out, '--overwrite', '--num-features', 10)
    assert max(len(row['x']) for row in rows(out).values()) <= 10
    refused("must end with one of .parquet, .npz, .db", 'extract', folder, '--out', tmp_path / 'features.csv')
    refused('No such file', 'extract', tmp_path / 'absent', '--out', tmp_path / 'other.parquet')
    refused('No such file', 'match', tmp_path / 'absent.parquet', '--pairs', 'exhaustive', '--out', tmp_path / 'm.parquet')
    refused('--out must name a file for the matches', 'match', out, '--pairs', 'exhaustive')
    Image.fromarray(noise(0)).save(str(tmp_path / 'image.png'))
    os.rename(str(tmp_path / 'image.png'), str(tmp_path / 'image.npz'))
    refused('is no file that aqorb has written', 'match', tmp_path / 'image.npz', '--pairs', 'exhaustive', '--out', out)


def test_needs_no_other_package(tmp_path):
    code = 'import sys; sys.modules.update({!r}); import aqorb; '
    for names in ['pyarrow', 'PIL', 'tqdm', 'pycolmap'], ['tqdm']:
        blocked = code.format(dict.fromkeys(names))
        run = subprocess.run([sys.executable, '-c', blocked + 'from aqorb.command import main; main()', 'extract',
                              str(tmp_path), '--out', str(tmp_path / 'x.parquet')], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, env=dict(os.environ, PYTHONPATH=FOLDER))
        assert run.returncode == 1 and 'pip install pillow pyarrow' in run.stderr and 'Traceback' not in run.stderr


# Going on

def stop(folder, out, part, after=0):
    """Starts an extraction, and kills it so many seconds after a part is done, or after its start if that is None."""
    process = subprocess.Popen([sys.executable, '-m', 'aqorb', 'extract', str(folder), '--out', str(out), '--part-size',
                                '7'], stderr=subprocess.PIPE, env=dict(os.environ, PYTHONPATH=FOLDER))
    while part is not None and not os.path.exists(f'{out}.partial/part-{part:06}.parquet') and process.poll() is None:
        time.sleep(.001)
    time.sleep(after)
    process.kill()
    process.communicate()


def test_killed_at_random_moments(folder, features, tmp_path):
    seed = random.randrange(1 << 32)
    chance, begun = random.Random(seed), 0
    for i in range(10):
        name = 'features.' + ('parquet', 'npz', 'db')[i % 3]
        out = tmp_path / name
        part = chance.choice([None, 0, 1, 2, 3, 4, 5])
        stop(folder, out, part, chance.uniform(0, 1 if part is None else .05))
        begun += os.path.exists(f'{out}.partial')
        if not out.exists() or os.path.exists(f'{out}.partial'):
            run('extract', folder, '--out', out, '--part-size', 7)
        assert out.read_bytes() == (features / name).read_bytes(), f'seed {seed}, {i}'
        assert os.listdir(str(tmp_path)) == [name], f'seed {seed}, {i}'
        out.unlink()
    assert begun, f'seed {seed}: none was killed in the middle'


def test_goes_on_where_it_was(folder, features, tmp_path):
    out = tmp_path / 'features.parquet'
    stop(folder, out, 2)
    kept = {name: os.stat(f'{out}.partial/{name}').st_mtime_ns for name in sorted(os.listdir(f'{out}.partial'))[:3]}
    assert not out.exists() and 'part-000002.parquet' in kept
    for wrong, message in ((['--num-features', '999'], 'parameters'), (['--max-size', '50'], 'max size'),
                           (['--reader', 'cv2'], 'reader'), (['--ignore-orientation'], 'EXIF orientation'),
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


@pytest.mark.skipif(os.name == 'nt', reason='signals of Unix')
def test_ctrl_c(folder, tmp_path):
    out = tmp_path / 'features.parquet'
    process = subprocess.Popen([sys.executable, '-m', 'aqorb', 'extract', str(folder), '--out', str(out), '--part-size',
                                '1'], stderr=subprocess.PIPE, text=True, env=dict(os.environ, PYTHONPATH=FOLDER),
                               # A shell without job control has what it starts in the background ignore Ctrl-C.
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    while not os.path.exists(f'{out}.partial/part-000003.parquet') and process.poll() is None:
        time.sleep(.001)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode == 130 and 'stopped; the same command goes on' in errors and 'Traceback' not in errors
    run('extract', folder, '--out', out, '--part-size', 1)
    assert len(rows(out)) == 40


# Images

def encoded(image, kind='PNG', **options):
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()


def read(content, **options):
    return collection.read_image(io.BytesIO(content), **options)


def oriented(orientation):
    exif = Image.Exif()
    exif[0x0112] = orientation
    return exif


@pytest.mark.parametrize('orientation', range(1, 9))
def test_orientation(orientation):
    upright = Image.fromarray(noise(1))
    # What undoes the turn of each orientation.
    stored = {2: Image.FLIP_LEFT_RIGHT, 3: Image.ROTATE_180, 4: Image.FLIP_TOP_BOTTOM, 5: Image.TRANSPOSE,
              6: Image.ROTATE_90, 7: Image.TRANSVERSE, 8: Image.ROTATE_270}
    turned = upright.transpose(stored[orientation]) if orientation > 1 else upright
    for kind in 'PNG', 'TIFF':
        pixels, size = read(encoded(turned, kind, exif=oriented(orientation)))
        assert np.array_equal(pixels, noise(1)) and size == (160, 120), kind
    for reader in 'pillow', 'cv2':
        jpeg = encoded(turned, 'JPEG', quality=95, exif=oriented(orientation))
        pixels, size = read(jpeg, reader=reader)
        assert size == (160, 120) and np.abs(pixels.astype(int) - noise(1)).mean() < 5
        pixels, size = read(jpeg, reader=reader, max_size=40)
        assert size == (160, 120) and pixels.shape == (30, 40)
        pixels, size = read(jpeg, reader=reader, orientation=False)
        assert size == turned.size and pixels.shape == turned.size[::-1]


def test_sixteen_bits():
    wide = noise(2).astype(np.uint16) * 257
    for kind in 'PNG', 'TIFF', 'PPM':
        content = encoded(Image.fromarray(wide.astype(np.int32) if kind == 'PPM' else wide), kind)
        assert np.array_equal(read(content)[0], noise(2)), kind
    assert np.array_equal(read(encoded(Image.fromarray(wide // 2)))[0], (wide // 2 + 128) // 257)
    with pytest.raises(ValueError, match='more than 16 bits'):
        read(encoded(Image.fromarray(wide.astype(np.int32) * 2), 'TIFF'))
    with pytest.raises(ValueError, match='floating-point'):
        read(encoded(Image.fromarray(wide.astype(np.float32)), 'TIFF'))


@pytest.mark.parametrize('kind', ['GIF', 'PNG', 'TIFF', 'WEBP'])
def test_of_an_animation_the_first_frame(kind):
    frames = [Image.fromarray(noise(i)) for i in (3, 4, 5)]
    options = {'lossless': True} if kind == 'WEBP' else {}
    content = encoded(frames[0], kind, save_all=True, append_images=frames[1:], **options)
    assert np.abs(read(content)[0].astype(int) - noise(3)).max() <= 1


@pytest.mark.parametrize('mode', ['1', 'L', 'LA', 'P', 'RGB', 'RGBA', 'CMYK'])
def test_modes(mode):
    grey = noise(6) // 128 * 255
    image = Image.fromarray(grey)
    image = (image.convert('RGB') if mode in ('P', 'CMYK') else image).convert(mode)
    kind = 'TIFF' if mode == 'CMYK' else 'PNG'
    assert np.abs(read(encoded(image, kind))[0].astype(int) - grey).max() <= 1
    if mode in ('L', 'RGB', 'CMYK'):
        for progressive in False, True:
            pixels, _ = read(encoded(image, 'JPEG', quality=95, progressive=progressive))
            assert np.abs(pixels.astype(int) - grey).mean() < 8


def test_max_size():
    image = Image.fromarray(noise(7)).resize((640, 480), Image.NEAREST).convert('RGB')
    for content in encoded(image), encoded(image, 'JPEG', quality=95):
        for max_size, shape in ((None, (480, 640)), (640, (480, 640)), (639, (479, 639)), (100, (75, 100)), (1, (1, 1))):
            pixels, size = read(content, max_size=max_size)
            assert pixels.shape == shape and size == (640, 480)
    large, small = (read(encoded(image, kind, **options), max_size=160)[0].astype(int)
                    for kind, options in (('PNG', {}), ('JPEG', {'quality': 95})))
    assert np.abs(large - small).mean() < 3


def test_positions_are_those_of_the_large_image(tmp_path):
    (tmp_path / 'images').mkdir()
    pixels = noise(8, 480, 640)
    Image.fromarray(pixels).save(str(tmp_path / 'images' / 'a.png'))
    run('extract', tmp_path / 'images', '--out', tmp_path / 'f.parquet', '--max-size', 320)
    row = rows(tmp_path / 'f.parquet')[b'a.png']
    half = expected(read(encoded(Image.fromarray(pixels)), max_size=320)[0])
    assert (row['width'], row['height']) == (640, 480)
    assert np.allclose(row['x'], np.float32(half['x']) * 2 + .5) and np.allclose(row['y'], np.float32(half['y']) * 2 + .5)
    assert np.allclose(row['size'], np.float32(half['size']) * 2) and row['descriptors'] == half['descriptors']


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
    listed = finished.stderr.split(f'{len(left_out)} files were left out:\n')[1]
    assert sorted(re.findall(r'^  (.+?): ', listed, re.MULTILINE)) == sorted(map(os.fsdecode, left_out))
    for name, reason in (('empty.jpg', 'the file is empty'), ('text.png', 'it is no image that Pillow can read'),
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
    stop(images, out, 2)
    assert '00 is no image.png: it is no image' in run('extract', images, '--out', out, '--part-size', 7).stderr


def test_files_without_permission(folder, tmp_path):
    user = {}
    if os.name == 'nt' or os.getuid() == 0:
        user = {'user': 'nobody', 'group': 'nogroup', 'extra_groups': []}
        try:
            if command('--version', **user).returncode:
                pytest.skip('no ordinary user can use the package')
        except (LookupError, OSError, TypeError, ValueError):
            pytest.skip('there is no ordinary user')
    base = pathlib.Path('/tmp') if user else tmp_path
    images = pathlib.Path(shutil.copytree(str(folder), f'{base}/aqorb-{os.getpid()}'))
    try:
        if user:
            shutil.chown(str(images), 'nobody')
            images.chmod(0o755)
        (images / '01.png').chmod(0)
        (images / 'closed').mkdir(0)
        finished = command('extract', images, '--out', images / 'f.parquet', '--recursive', **user)
        assert finished.returncode == 0, finished.stderr
        assert '2 files were left out:\n' in finished.stderr
        assert '  01.png: Permission denied' in finished.stderr and '  closed: Permission denied' in finished.stderr
        assert len(rows(images / 'f.parquet')) == 39
    finally:
        (images / 'closed').chmod(stat.S_IRWXU)
        shutil.rmtree(str(images))


def test_a_folder_without_images(tmp_path):
    (tmp_path / 'images').mkdir()
    for suffix in 'parquet', 'npz', 'db':
        run('extract', tmp_path / 'images', '--out', tmp_path / f'f.{suffix}')
        run('match', tmp_path / f'f.{suffix}', '--pairs', 'exhaustive', '--out', tmp_path / f'{suffix}.parquet')
        assert pq.read_table(str(tmp_path / f'{suffix}.parquet')).num_rows == 0


def test_the_reader_cv2(folder, tmp_path):
    run('extract', folder, '--out', tmp_path / 'f.parquet', '--reader', 'cv2')
    import cv2
    assert rows(tmp_path / 'f.parquet')[b'05.png'] == dict(expected(noise(5)), path=b'05.png')
    metadata = json.loads(pq.read_schema(str(tmp_path / 'f.parquet')).metadata[b'aqorb'])
    assert metadata['reader'] == 'cv2 ' + cv2.__version__


def test_five_hundred_photographs(tmp_path):
    if 'OPENCV_TEST_DATA_PATH' not in os.environ:
        pytest.skip('needs OPENCV_TEST_DATA_PATH')
    photographs = sorted(pathlib.Path(os.environ['OPENCV_TEST_DATA_PATH']).glob(
        'cv/detectors_descriptors_evaluation/images_datasets/*/*.png'))
    (tmp_path / 'images').mkdir()
    write_crops(photographs, tmp_path / 'images', 500)
    run('extract', tmp_path / 'images', '--out', tmp_path / 'f.parquet')
    table = pq.read_table(str(tmp_path / 'f.parquet'))
    images = [np.asarray(Image.open(str(tmp_path / 'images' / os.fsdecode(path))).convert('L'))
              for path in table['path'].to_pylist()]
    found = aqorb.AdaptiveQuadtreeORB_create(1000).detectAndComputeBatch(images)
    assert len(images) == 500
    for name in 'x', 'y', 'size', 'angle', 'response', 'octave':
        assert np.array_equal(table[name].combine_chunks().flatten(), getattr(found, name))
    assert b''.join(table['descriptors'].to_pylist()) == found.descriptors.tobytes()


def write_crops(photographs, folder, count, size=(320, 240)):
    chance = random.Random(0)
    opened = [Image.open(str(path)).convert('RGB') for path in photographs]
    for i in range(count):
        image = opened[i % len(opened)]
        x, y = chance.randrange(image.width - size[0] + 1), chance.randrange(image.height - size[1] + 1)
        image.crop((x, y, x + size[0], y + size[1])).save(str(folder / f'{i:05}.bmp'))


# Matches

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
        refused('pairs must be sequential:K, exhaustive or a file', 'match', features / 'features.parquet', '--pairs',
                pairs, '--out', tmp_path / 'x.parquet')
    refused('ratio must be finite and at least 0, got -1', 'match', features / 'features.parquet', '--pairs', 'exhaustive', '--ratio', -1, '--out',
            tmp_path / 'x.parquet')
    refused('pairs.txt, line 2: must be the paths of two images', 'match', features / 'features.parquet', '--pairs',
            tmp_path / 'pairs.txt', '--out', tmp_path / 'x.parquet')


def test_match_options(features, tmp_path):
    run('match', features / 'features.npz', '--pairs', 'sequential:1', '--out', tmp_path / 'm.parquet', '--ratio', '.9',
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
    for name in 'parquet', 'npz':
        run('match', features / f'features.{name}', '--pairs', 'sequential:2', '--out', tmp_path / f'{name}.db')
    for path in copied, str(tmp_path / 'parquet.db'), str(tmp_path / 'npz.db'):
        database = pycolmap.Database.open(path)
        ids = {image.name.encode(): image.image_id for image in database.read_all_images()}
        assert database.num_matched_image_pairs() == len(expected_matches) == 77
        for (first, second), row in expected_matches.items():
            pairs = database.read_matches(ids[first], ids[second])
            assert pairs.tolist() == [list(pair) for pair in zip(row['index1'], row['index2'])]
        database.delete_matches(ids[b'00.png'], ids[b'01.png'])
        database.close()
    run('match', copied, '--pairs', 'sequential:2')  # what is missing is matched
    refused('has other matches; --overwrite', 'match', copied, '--pairs', 'sequential:3')
    refused('a database is matched in place', 'match', copied, '--pairs', 'sequential:2', '--out', tmp_path / 'new.db')
    run('match', copied, '--pairs', 'sequential:1', '--overwrite')
    with sqlite3.connect(copied) as connection:
        assert connection.execute('SELECT count(*) FROM matches').fetchone() == (39,)


def test_draw(folder, tmp_path):
    picture = tmp_path / 'matches.png'
    finished = run('draw', folder / '00.png', folder / '00.png', '--out', picture)
    count = len(expected(noise(0))['x'])
    assert re.search(rf'{count} and {count} features', finished.stdout) and Image.open(str(picture)).size == (320, 120)
    assert int(re.search(r': (\d+) matches', finished.stdout).group(1)) > count / 2
    refused('exists; --overwrite', 'draw', folder / '00.png', folder / '01.png', '--out', picture)
    (tmp_path / 'text').write_text('no image')
    refused('text: it is no image', 'draw', folder / '00.png', tmp_path / 'text', '--out', tmp_path / 'x.png')
