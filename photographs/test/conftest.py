# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What the tests of the command aqorb share: also the packages of the processes that they start."""

import contextlib
import glob
import io
import itertools
import os
import re
import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq
import pycolmap
import pytest
from PIL import Image

import aqorb
import aqorb_photographs
from aqorb_photographs.__main__ import main

os.environ['PYTHONPATH'] = os.pathsep.join(
    os.path.dirname(os.path.dirname(os.path.abspath(package.__file__))) for package in (aqorb_photographs, aqorb))

TEXT = {'stdout': subprocess.PIPE, 'stderr': subprocess.PIPE, 'text': True, 'errors': 'surrogateescape'}

# Not an emulator, whose /proc does not tell of this process.
LINUX = pytest.mark.skipif(not glob.glob('/proc/self/task/*'), reason='looks into /proc, or limits memory')


def noise(seed, height=120, width=160):
    pixels = np.random.RandomState(seed).randint(0, 256, (height // 8, width // 8), np.uint8)
    return np.repeat(np.repeat(pixels, 8, 0), 8, 1)


def save(path, pixels, **options):
    """Writes pixels as an image, in a folder that it makes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path, **options)


def call_of(*arguments):
    return [sys.executable, '-m', 'aqorb_photographs', *map(str, arguments)]


def start(*arguments, **options):
    """A process of the command."""
    return subprocess.Popen(call_of(*arguments), **{**TEXT, **options})


def peak_memory(*arguments):
    """The most memory of a call of the command, in KiB. A small process starts it, because a process begins with what
    the one that starts it has."""
    code = ('import resource, subprocess, sys; subprocess.run(sys.argv[1:], stdout=2, check=True); '
            'print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)')
    return int(subprocess.check_output([sys.executable, '-c', code, *call_of(*arguments)]))


def command(*arguments, **options):
    """What a call of the command gives: of a process of its own if it has options, else of this one."""
    if options:
        return subprocess.run(call_of(*arguments), timeout=300, **{**TEXT, **options})
    output, errors, threads = io.StringIO(), io.StringIO(), aqorb.getNumThreads()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
        try:
            main(list(map(str, arguments)))
        except SystemExit as ended:
            code = ended.code or 0
            if isinstance(code, str):
                print(code, file=errors)
                code = 1
        finally:
            aqorb.setNumThreads(threads)
    return subprocess.CompletedProcess(arguments, code, output.getvalue(), errors.getvalue())


def run(*arguments):
    finished = command(*arguments)
    assert finished.returncode == 0, finished.stderr
    return finished


def refused(message, *arguments):
    finished = command(*arguments)
    assert finished.returncode == 1 and re.search(message, finished.stderr), finished.stderr
    assert 'Traceback' not in finished.stderr


def rows(path):
    """The rows of a folder of features by name."""
    return {row['name']: row for row in pq.read_table(str(path)).to_pylist()}


def matches_of(path):
    return {(row['name1'], row['name2']): row for row in pq.read_table(str(path)).to_pylist()}


def parts_of(path):
    return {name: os.stat(path / name).st_mtime_ns for name in os.listdir(path)}


def geometries_of(path):
    """Yields the two-view geometries in a COLMAP database: the names of both images, the positions of the matches in
    both, and the geometry."""
    with pycolmap.Database.open(path) as database:
        images = {image.name: image.image_id for image in database.read_all_images()}
        for names in itertools.combinations(images, 2):
            both = [images[name] for name in names]
            if database.exists_two_view_geometry(*both):
                geometry = database.read_two_view_geometry(*both)
                rows = geometry.inlier_matches.T
                yield names, [database.read_keypoints(one)[row, :2] for one, row in zip(both, rows)], geometry


def epipolar_distances(points1, points2, fundamental):
    """The distances of points2 from the epipolar lines of points1."""
    lines = np.column_stack([points1, np.ones(len(points1))]) @ fundamental.T
    return abs((lines[:, :2] * points2).sum(1) + lines[:, 2]) / np.hypot(*lines[:, :2].T)


def expected(pixels, features=1000):
    """The columns of a grey image, by detectAndComputeArrays."""
    keypoints, descriptors = aqorb.AdaptiveQuadtreeORB_create(features).detectAndComputeArrays(pixels)
    columns = {name: keypoints[name].tolist() for name in ('size', 'angle', 'response', 'octave')}
    return dict(columns, x=keypoints['pt'][:, 0].tolist(), y=keypoints['pt'][:, 1].tolist(),
                descriptors=descriptors.tobytes(), width=pixels.shape[1], height=pixels.shape[0])


def encoded(image, kind='PNG', **options):
    stream = io.BytesIO()
    image.save(stream, kind, **options)
    return stream.getvalue()


@pytest.fixture(scope='session')
def folder(tmp_path_factory):
    """Forty images."""
    folder = tmp_path_factory.mktemp('images')
    for i in range(40):
        save(folder / f'{i:02}.png', noise(i))
    return folder


@pytest.fixture(scope='session')
def features(folder, tmp_path_factory):
    """The features of these images."""
    out = tmp_path_factory.mktemp('features') / 'features'
    run('extract', folder, '--out', out, '--part-size', 7)
    return out
