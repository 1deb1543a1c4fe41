# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What the tests of the command aqorb share."""

import io
import re
import subprocess
import sys

import pytest

import aqorb
from conftest import noise  # noqa: F401 # for those that import this

pytest.importorskip('tqdm')
pycolmap = pytest.importorskip('pycolmap')
pa = pytest.importorskip('pyarrow')
pq = pytest.importorskip('pyarrow.parquet')
PIL = pytest.importorskip('PIL')
Image = pytest.importorskip('PIL.Image')
collection = pytest.importorskip('aqorb.collection')

TEXT = {'stdout': subprocess.PIPE, 'stderr': subprocess.PIPE, 'text': True, 'errors': 'surrogateescape'}


def call_of(*arguments):
    return [sys.executable, '-m', 'aqorb', *map(str, arguments)]


def start(*arguments, **options):
    """A process of the command."""
    return subprocess.Popen(call_of(*arguments), **{**TEXT, **options})


def command(*arguments, **options):
    """A finished process of the command."""
    return subprocess.run(call_of(*arguments), timeout=300, **{**TEXT, **options})


def run(*arguments):
    finished = command(*arguments)
    assert finished.returncode == 0, finished.stderr
    return finished


def refused(message, *arguments):
    finished = command(*arguments)
    assert finished.returncode == 1 and re.search(message, finished.stderr), finished.stderr
    assert 'Traceback' not in finished.stderr


def rows(path):
    return {row['path']: row for row in pq.read_table(str(path)).to_pylist()}


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
