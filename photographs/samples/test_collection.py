# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The long form of the tests of collections, which scripts/python.sh collection runs: 500 photographs by the command,
the function and Ray, with and without a worker that is killed, and 10,000 small images. The photographs are crops of
those in the folder that AQORB_PHOTOGRAPHS names."""

import contextlib
import os
import pathlib
import random
import re
import subprocess
import sys
import time

import numpy as np
import psutil
import pyarrow as pa
import pyarrow.parquet as pq
import pycolmap
import pytest
from PIL import Image

import aqorb

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / 'test'))
from command_support import peak_memory  # noqa: E402

LISTS = 'x', 'y', 'size', 'angle', 'response', 'octave'


@pytest.fixture(scope='module')
def photographs(tmp_path_factory):
    folder = tmp_path_factory.mktemp('photographs')
    chance = random.Random(0)
    paths = sorted(pathlib.Path(os.environ['AQORB_PHOTOGRAPHS']).rglob('*.png'))
    opened = [Image.open(str(path)).convert('RGB') for path in paths]
    for i in range(500):
        image = opened[i % len(opened)]
        x, y = chance.randrange(image.width - 479), chance.randrange(image.height - 359)
        image.crop((x, y, x + 480, y + 360)).save(str(folder / f'{i:05}.jpg'), quality=90)
    (folder / 'no image.txt').write_text('no image')
    return folder


@pytest.fixture(scope='module')
def table(photographs, tmp_path_factory):
    """What the command gives."""
    out = tmp_path_factory.mktemp('command') / 'features'
    run('extract', photographs, '--out', out)
    return sorted_table(out)


def run(*arguments):
    call = [sys.executable, '-m', 'aqorb_photographs', *map(str, arguments)]
    return subprocess.run(call, check=True, stdout=subprocess.PIPE, text=True).stdout


def start_ray(photographs, out):
    return subprocess.Popen([sys.executable, str(HERE / 'ray_features.py'), str(photographs), '--out', str(out), '--batch',
                             '10', '--actors', '2'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def sorted_table(folder):
    return pq.read_table(str(folder)).sort_by('name').combine_chunks()


def test_the_function(photographs, table):
    images = []
    for name in table['name'].to_pylist():
        image = Image.open(str(photographs / name))
        image.draft('L', image.size)
        images.append(np.asarray(image))
    features = aqorb.AdaptiveQuadtreeORB_create(1000).detectAndComputeBatch(images)
    assert len(images) == 500 and np.array_equal(features.offsets[1:], pa.compute.cumulative_sum(
        pa.compute.list_value_length(table['x'])))
    for name in LISTS:
        assert np.array_equal(table[name].combine_chunks().flatten(), getattr(features, name)), name
    assert b''.join(table['descriptors'].to_pylist()) == features.descriptors.tobytes()


def test_ray(photographs, table, tmp_path):
    process = start_ray(photographs, tmp_path / 'out')
    output, _ = process.communicate(timeout=600)
    assert process.returncode == 0, output
    assert 'no image.txt is left out: it is no image' in output
    assert sorted_table(tmp_path / 'out').equals(table)


def test_the_function_for_spark(photographs, table):
    page = HERE.parent / 'many_images.md'
    code = page.read_text().split('mapInArrow`:\n\n```python\n')[1].split('# Spark begins here.')[0]
    names = {}
    exec(code, names)
    paths = [str(photographs / name) for name in table['name'].to_pylist() + ['no image.txt']]
    files = pa.table({'path': paths, 'content': [pathlib.Path(path).read_bytes() for path in paths]})
    found = pa.Table.from_batches(names['extract'](iter(files.to_batches(max_chunksize=50))))
    for name in 'name', *LISTS, 'descriptors', 'digest', 'file_size':
        assert found[name].combine_chunks().equals(table[name].combine_chunks()) or name == 'name'
    assert [os.path.basename(name) for name in found['name'].to_pylist()] == table['name'].to_pylist()


def actor_at_work(process):
    """An actor of a process, or None. Its process has another name while it waits."""
    with contextlib.suppress(psutil.NoSuchProcess):  # one ended meanwhile
        for actor in psutil.Process(process.pid).children(recursive=True):
            if re.match('ray::.*Extractor', ' '.join(actor.cmdline())) and actor.cpu_times().user > 1:
                return actor


def test_ray_with_a_worker_that_is_killed(photographs, table, tmp_path):
    process = start_ray(photographs, tmp_path / 'out')
    killed = None
    while process.poll() is None and not killed:
        time.sleep(.02)
        killed = actor_at_work(process)
    time.sleep(.2)
    if killed:
        killed.kill()
    output, _ = process.communicate(timeout=600)
    assert killed and process.returncode == 0, output
    assert sorted_table(tmp_path / 'out').equals(table)


def test_ray_places(photographs, table, tmp_path):
    start_ray(photographs, tmp_path / 'features').communicate(timeout=600)
    assert '0 of them new' in run('extract', photographs, '--out', tmp_path / 'features')
    how = '--min-gap', '3', '--seed', '2'
    run('match', tmp_path / 'features', '--pairs', 'retrieval:4', '--out', tmp_path / 'matches', *how)
    subprocess.run([sys.executable, str(HERE / 'ray_places.py'), str(tmp_path / 'features'), '--retrieval', '4',
                    '--batch', '70', '--out', str(tmp_path / 'out'), *how], check=True)
    order = [('name1', 'ascending'), ('name2', 'ascending')]
    command, pipeline = (pq.read_table(str(tmp_path / name)).sort_by(order) for name in ('matches', 'out'))
    assert len(command) > 1000 and pipeline.equals(command)
    again = run('match', tmp_path / 'features', '--pairs', 'retrieval:4', '--out', tmp_path / 'out', *how)
    assert ' 0 of them new' in again
    assert '00003.jpg\t' in run('search', tmp_path / 'features', photographs / '00003.jpg')


@pytest.mark.skipif('AQORB_TEST_SEQUENCE' not in os.environ, reason='AQORB_TEST_SEQUENCE is not set')
def test_phones(tmp_path):
    """A drive, half of it by a phone that is turned, is mapped and undistorted by COLMAP."""
    images = tmp_path / 'images'
    images.mkdir()
    frames = sorted(pathlib.Path(os.environ['AQORB_TEST_SEQUENCE'], 'image_l').glob('*'))[:24]
    for i, path in enumerate(frames):
        exif = Image.Exif()
        # The focal length of KITTI's camera, 707 pixels, on film of the same diagonal.
        exif[0x8769] = exif._ifds[0x8769] = {0xa405: round(707.09 * 43.267 / np.hypot(1226, 370))}
        exif[0x0112] = 6 if i % 2 else 1
        image = Image.open(str(path)).convert('RGB')
        (image.transpose(Image.ROTATE_90) if i % 2 else image).save(str(images / f'{i:02}.jpg'), quality=95, exif=exif)
    database, model, dense = (str(tmp_path / name) for name in ('x.db', 'model', 'dense'))
    run('extract', images, '--out', tmp_path / 'f', '--num-features', 2000)
    run('match', tmp_path / 'f', '--pairs', 'sequential:4', '--out', tmp_path / 'm')
    run('colmap', tmp_path / 'f', tmp_path / 'm', '--images', images, '--database', database)
    pycolmap.geometric_verification(database)
    options = pycolmap.IncrementalPipelineOptions(ba_refine_focal_length=False, ba_refine_extra_params=False)
    options.mapper.init_max_forward_motion, options.mapper.init_min_tri_angle = 1, 4
    os.makedirs(model)
    found = pycolmap.incremental_mapping(database, str(images), model, options)
    largest = max(found, key=lambda number: found[number].num_reg_images())
    assert found[largest].num_reg_images() == len(frames)
    pycolmap.undistort_images(dense, os.path.join(model, str(largest)), str(images))
    assert len(os.listdir(os.path.join(dense, 'images'))) == len(frames)
    print(found[largest].summary())


def distance_between(found, truth):
    """The mean distance of points from the true ones, after the similarity that takes them there."""
    moved, true = found - found.mean(0), truth - truth.mean(0)
    u, values, v = np.linalg.svd(true.T @ moved)
    values[2] *= np.linalg.det(u @ v)
    u[:, 2] *= np.linalg.det(u @ v)
    return np.linalg.norm(moved @ (u @ v).T * values.sum() / (moved**2).sum() - true, axis=1).mean()


@pytest.mark.skipif('AQORB_STRECHA' not in os.environ, reason='AQORB_STRECHA is not set')
def test_refined_tracks(tmp_path):
    """Photographs of a fountain with known cameras (github.com/openMVG/SfM_quality_evaluation), by COLMAP."""
    scene, = pathlib.Path(os.environ['AQORB_STRECHA']).rglob('fountain-P11')
    images, truth = tmp_path / 'images', {}
    images.mkdir()
    for path in (scene / 'images').glob('*.jpg'):
        truth[f'{path.stem}.png'] = np.loadtxt(scene / f'gt_dense_cameras/{path.name}.camera', skiprows=7, max_rows=1)
        image = Image.open(path).convert('L')
        image.resize((1024, 683), Image.LANCZOS).save(images / f'{path.stem}.png')
    (fx, _, cx), (_, fy, cy), _ = np.loadtxt(scene / 'images/K.txt') * 1024 / image.width
    camera = '--camera-mode', 'SINGLE', '--camera-model', 'PINHOLE', '--camera-params', f'{fx},{fy},{cx},{cy}'
    run('extract', images, '--out', tmp_path / 'f', '--num-features', 2000)
    run('match', tmp_path / 'f', '--pairs', 'exhaustive', '--out', tmp_path / 'm')
    for option in [], ['--refine']:
        database, model = tmp_path / f'x{len(option)}.db', tmp_path / f'model{len(option)}'
        run('colmap', tmp_path / 'f', tmp_path / 'm', '--images', images, '--database', database, *camera, *option)
        model.mkdir()
        options = pycolmap.IncrementalPipelineOptions(ba_refine_focal_length=False, ba_refine_extra_params=False)
        options.random_seed = 0
        found = pycolmap.incremental_mapping(str(database), str(images), str(model), options)[0]
        centers = {image.name: image.projection_center() for image in found.images.values() if image.has_pose}
        error = distance_between(np.array(list(centers.values())), np.array([truth[name] for name in centers]))
        reprojection = found.compute_mean_reprojection_error()
        print(f'{" ".join(option) or "as detected"}: {len(centers)} images, reprojection error {reprojection:.3f} px, '
              f'error of camera positions {1000 * error:.1f} mm')
    assert len(centers) == len(truth) and reprojection <= .16 and error <= .003


def test_ten_thousand_small_images(tmp_path):
    memory = {}
    for count in 1000, 10000:
        folder, out = tmp_path / str(count), tmp_path / f'{count}-features'
        folder.mkdir()
        for i in range(count):
            pixels = np.random.RandomState(i).randint(0, 256, (12, 16), np.uint8)
            Image.fromarray(np.repeat(np.repeat(pixels, 8, 0), 8, 1)).save(str(folder / f'{i:05}.bmp'))
        memory[count] = peak_memory('extract', folder, '--out', out)
        found = pq.read_table(str(out), columns=['name'])
        assert found['name'].to_pylist() == [f'{i:05}.bmp' for i in range(count)]
    print(f'memory: {memory} KiB')
    assert memory[10000] < memory[1000] + 50000  # 10,000 files have some 100 MB of features
