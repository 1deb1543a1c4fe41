# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The long form of the tests of collections, which scripts/python.sh --collection runs: 500 photographs by the command,
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
import pytest
from PIL import Image

import aqorb

HERE = pathlib.Path(__file__).resolve().parent
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
    out = tmp_path_factory.mktemp('command') / 'features.parquet'
    subprocess.run([sys.executable, '-m', 'aqorb', 'extract', str(photographs), '--out', str(out)], check=True)
    return pq.read_table(str(out))


def start_ray(photographs, out):
    return subprocess.Popen([sys.executable, str(HERE / 'ray_features.py'), str(photographs), '--out', str(out), '--batch',
                             '10', '--actors', '2'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def sorted_table(folder):
    return pq.read_table(str(folder)).sort_by('path')


def test_the_function(photographs, table):
    images = []
    for path in table['path'].to_pylist():
        image = Image.open(str(photographs / os.fsdecode(path)))
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
    page = HERE.parent.parent / 'modules/aqorb/tutorials/aqorb_many_images/aqorb_many_images.markdown'
    code = page.read_text().split('mapInArrow`:\n\n```python\n')[1].split('# Spark begins here.')[0]
    names = {}
    exec(code, names)
    files = pa.table({'path': [path.decode() for path in table['path'].to_pylist()] + ['no image.txt']})
    files = files.append_column('content', [[(photographs / path).read_bytes() for path in files['path'].to_pylist()]])
    found = pa.Table.from_batches(names['extract'](iter(files.to_batches(max_chunksize=50))))
    assert found.combine_chunks().equals(table)


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


def test_ray_places(table, tmp_path):
    pq.write_table(table, str(tmp_path / 'features.parquet'))
    how = '--min-gap', '3', '--ratio', '.8', '--seed', '2'
    subprocess.run([sys.executable, '-m', 'aqorb', 'match', str(tmp_path / 'features.parquet'), '--pairs', 'retrieval:4',
                    '--out', str(tmp_path / 'matches.parquet'), *how], check=True)
    subprocess.run([sys.executable, str(HERE / 'ray_places.py'), str(tmp_path / 'features.parquet'), '--retrieval', '4',
                    '--batch', '70', '--out', str(tmp_path / 'out'), *how], check=True)
    order = [('path1', 'ascending'), ('path2', 'ascending')]
    command, pipeline = (pq.read_table(str(tmp_path / name)).sort_by(order) for name in ('matches.parquet', 'out'))
    assert len(command) > 1000 and pipeline.equals(command)


def test_ten_thousand_small_images(tmp_path):
    memory = {}
    for count in 1000, 10000:
        folder, out = tmp_path / str(count), tmp_path / f'{count}.parquet'
        folder.mkdir()
        for i in range(count):
            pixels = np.random.RandomState(i).randint(0, 256, (12, 16), np.uint8)
            Image.fromarray(np.repeat(np.repeat(pixels, 8, 0), 8, 1)).save(str(folder / f'{i:05}.bmp'))
        process = subprocess.Popen([sys.executable, '-m', 'aqorb', 'extract', str(folder), '--out', str(out)])
        _, status, usage = os.wait4(process.pid, 0)
        assert status == 0
        memory[count] = usage.ru_maxrss
        found = pq.read_table(str(out), columns=['path', 'x'])
        assert found['path'].to_pylist() == [b'%05d.bmp' % i for i in range(count)]
    print(f'memory: {memory} KiB')
    assert memory[10000] < memory[1000] + 30000  # 10,000 files have some 100 MB of features
