# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""A detector's parameters in files and in cv2's storages. They come as the text that OpenCV writes, as the storages of
cv2 are not those of the OpenCV that the package has."""

import contextlib
import gzip
import os
import reprlib

import aqorb


@contextlib.contextmanager
def opened(file_name, mode, accepted):
    """Opens whatever open() takes as the name of a file. Its end chooses the format, also before .gz."""
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
    """By Python, because cv::FileStorage does not tell that a disk is full."""
    with opened(file_name, 'wb', 'FileStorage') as (file, name):
        file.write(text_of(name))


def load(file_name, read):
    with opened(file_name, 'rb', 'FileNode') as (file, _):
        read(file.read())


def write(text, storage, name):
    if not storage.isOpened():
        raise aqorb.error('fs must be a storage that is open to write, got one that is not open')
    import cv2
    source = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    root = source.root()  # of no use without the storage
    if name:
        storage.startWriteStruct(name, cv2.FileNode_MAP)
    for key in root.keys():
        node = root.getNode(key)
        storage.write(key, node.string() if node.isString() else int(node.real()) if node.isInt() else node.real())
    if name:
        storage.endWriteStruct()


def read(node):
    """The parameters that a node has, as a text."""
    if not node.isMap():
        raise aqorb.error('fn must be a map of the parameters, got a node that ' +
                          ('does not exist' if node.isNone() else 'is no map'))
    import cv2
    given = cv2.FileStorage('.yml', cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    for key in node.keys():
        value = node.getNode(key)
        is_number = value.isInt() or value.isReal()
        # What is no number the library refuses, if it is a parameter's.
        given.write(key, value.real() if is_number else value.string() if value.isString() else 'no number')
    return given.releaseAndGetString()
