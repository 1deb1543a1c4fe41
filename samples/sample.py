# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Shared by the samples: the module, files, and messages for bad files."""

import os
import sys

import cv2 as cv

try:
    import aqorb
except ImportError:  # cv2 was built with the module
    from cv2 import aqorb


def read_image(name, flags=cv.IMREAD_GRAYSCALE):
    """Reads a file, or one of OpenCV's samples in the folder that OPENCV_SAMPLES_DATA_PATH names."""
    file = cv.samples.findFile(name, False, True)
    if not file:
        sys.exit(name + ": there is no such file (OpenCV's sample images: "
                 'export OPENCV_SAMPLES_DATA_PATH=$(scripts/demo.sh --images))')
    image = cv.imread(file, flags)
    if image is None:
        sys.exit(name + ': cannot be read as an image')
    return image


def check_writable(file, is_writable):
    if not is_writable:
        sys.exit(file + ': cannot be written; a name such as picture.jpg in an existing folder is accepted')


def picture_option(file):
    """Type of --out: rejects a name that cannot be written, before the program does any work."""
    check_writable(file, cv.haveImageWriter(file) and os.path.isdir(os.path.dirname(file) or '.'))
    return file


def write_picture(file, picture):
    check_writable(file, cv.imwrite(file, picture))
    print('Picture:', file)
