# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package share."""

import copy
import glob
import os
import pickle
import subprocess
import sys
import unittest

import numpy as np
import pytest

import aqorb

FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(aqorb.__file__)))
os.environ['PYTHONPATH'] = FOLDER  # for the processes that tests start

sys.modules['tests_common'] = sys.modules[__name__]  # which the test of cv2.aqorb imports from OpenCV's source tree

# Not an emulator, whose /proc does not tell of this process.
LINUX = pytest.mark.skipif(not glob.glob('/proc/self/task/*'), reason='looks into /proc, forks, or limits memory')


class NewOpenCVTests(unittest.TestCase):
    """Has the test of cv2.aqorb, which belongs to the module, test the package."""

    def __init_subclass__(cls):
        cls.test_is_a_cv_orb = unittest.skip('the package has no class of cv2')(cls.test_is_a_cv_orb)
        cls.test_batch = unittest.skip('the package returns a FeatureBatch')(cls.test_batch)


try:
    import cv2
    cv2.aqorb = aqorb
except ImportError:  # the tests that need none
    pass


def noise(seed, height=120, width=160):
    pixels = np.random.RandomState(seed).randint(0, 256, (height // 8, width // 8), np.uint8)
    return np.repeat(np.repeat(pixels, 8, 0), 8, 1)


def python(*arguments, **options):
    """Runs Python in a process of its own, and returns the process and what it printed, also its errors."""
    return subprocess.run([sys.executable, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=300, **options)


def copies_of(thing):
    return [pickle.loads(pickle.dumps(thing, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)] + [
        copy.copy(thing), copy.deepcopy(thing)]


@pytest.fixture(scope='session')
def image():
    return noise(3, 480, 640)


@pytest.fixture
def orb():
    return aqorb.AdaptiveQuadtreeORB_create(300)


@pytest.fixture
def threads():
    """The number of threads, which is set back afterwards."""
    number = aqorb.getNumThreads()
    yield number
    aqorb.setNumThreads(number)


@pytest.fixture
def unusual():
    """A detector none of whose properties has its default, and their values by name."""
    orb = aqorb.AdaptiveQuadtreeORB_create()
    values = {}
    for name in [name[3:] for name in dir(orb) if name.startswith('set')]:
        value = getattr(orb, 'get' + name)()
        values[name] = (not value if isinstance(value, bool) else
                        value + 1 if isinstance(value, int) else max(value, 0) + 1 / 3)
        getattr(orb, 'set' + name)(values[name])
    return orb, values


def values_of(orb, names):
    return {name: getattr(orb, 'get' + name)() for name in names}
