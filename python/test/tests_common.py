# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""In place of the file of this name in OpenCV's source tree, so that the test of cv2.aqorb, which belongs to the module,
tests the package."""

import unittest

import cv2

import aqorb

cv2.aqorb = aqorb


class NewOpenCVTests(unittest.TestCase):
    bootstrap = staticmethod(unittest.main)

    def __init_subclass__(cls):
        cls.test_is_a_cv_orb = unittest.skip('the package has no class of cv2')(cls.test_is_a_cv_orb)
