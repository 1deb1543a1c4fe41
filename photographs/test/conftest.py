# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The images that most tests share, and the packages of the processes that they start."""

import os

import pytest

import aqorb
import aqorb_photographs
from command_support import Image, noise, run

os.environ['PYTHONPATH'] = os.pathsep.join(
    os.path.dirname(os.path.dirname(os.path.abspath(package.__file__))) for package in (aqorb_photographs, aqorb))


@pytest.fixture(scope='session')
def folder(tmp_path_factory):
    """Forty images."""
    folder = tmp_path_factory.mktemp('images')
    for i in range(40):
        Image.fromarray(noise(i)).save(str(folder / f'{i:02}.png'))
    return folder


@pytest.fixture(scope='session')
def features(folder, tmp_path_factory):
    """The features of these images."""
    out = tmp_path_factory.mktemp('features') / 'features'
    run('extract', folder, '--out', out, '--part-size', 7)
    return out
