# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""A detector's parameters in files and in cv2's storages. They pass as text, because cv2's storages belong to another
OpenCV than the package's."""

import contextlib
import gzip
import os
import reprlib

import aqorb


@contextlib.contextmanager
def opened(file_name, mode, accepted):
    """Opens a file by any name that open() accepts. Yields it and its name without .gz, whose suffix is the format."""
    try:
        path = os.fsencode(file_name)
    except TypeError:
        raise TypeError(f'fileName must be a str, a path or a cv2.{accepted}, got {reprlib.repr(file_name)}') from None
    is_packed = path.endswith(b'.gz')
    try:
        with (gzip.open if is_packed else open)(path, mode) as file:
            yield file, os.path.basename(path[:-3] if is_packed else path)
    except (OSError, EOFError, ValueError) as error:
        done = 'written' if mode == 'wb' else 'read'
        raise aqorb.error(f'fileName must be a file that can be {done}, got {os.fsdecode(path)!r} ({error})') from None


def save(file_name, text_of):
    """Writes a file by Python, because cv::FileStorage does not report a full disk."""
    with opened(file_name, 'wb', 'FileStorage') as (file, name):
        file.write(text_of(name))


def load(file_name, read):
    with opened(file_name, 'rb', 'FileNode') as (file, _):
        read(file.read())


def write(text, storage, name):
    if not storage.isOpened():
        raise aqorb.error('fs must be a storage open for writing, got a closed storage')
    import cv2
    source = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    root = source.root()  # valid as long as `source`
    if name:
        storage.startWriteStruct(name, cv2.FileNode_MAP)
    for key in root.keys():
        node = root.getNode(key)
        storage.write(key, node.string() if node.isString() else int(node.real()) if node.isInt() else node.real())
    if name:
        storage.endWriteStruct()


def read(node):
    """Returns the parameters of a node as text."""
    if not node.isMap():
        raise aqorb.error('fn must be a map of the parameters, got a node that ' +
                          ('does not exist' if node.isNone() else 'is no map'))
    import cv2
    given = cv2.FileStorage('.yml', cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    for key in node.keys():
        value = node.getNode(key)
        is_number = value.isInt() or value.isReal()
        # The library rejects a parameter that is no number.
        given.write(key, value.real() if is_number else value.string() if value.isString() else 'no number')
    return given.releaseAndGetString()
