# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package share."""

import ctypes

import cv2 as cv
import numpy as np
import pytest

import aqorb


@pytest.fixture(scope='session')
def image():
    noise = np.random.RandomState(3).randint(0, 256, (60, 80), np.uint8)
    return cv.resize(noise, (640, 480), interpolation=cv.INTER_NEAREST)


@pytest.fixture
def orb():
    return aqorb.AdaptiveQuadtreeORB_create(300)


def never_freed(item):
    """The item itself, with a reference that nobody releases: cv2 corrupts memory when it frees an object of a class
    that is derived from cv2.KeyPoint."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(item))
    return item
