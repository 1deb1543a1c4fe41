# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""A detector's parameters in files and in cv2's storages. They come as the text that OpenCV writes, as the storages of
cv2 are not those of the OpenCV that the package has."""

import gzip
import os

import aqorb


def path_of(file_name, accepted):
    """The path in the encoding of file names, from whatever open() takes as one."""
    try:
        path = os.fsencode(file_name)
    except TypeError:
        raise TypeError(f'fileName must be a str, a path or a cv2.{accepted}, got '
                        f'{aqorb._aqorb._brief(file_name)}') from None
    if b'\0' in path:
        raise aqorb.error(f'fileName must be a path of the system, got {file_name!r}')
    return path


def text_name(path):
    """The end of the name chooses the format."""
    return os.path.basename(path[:-3] if path.endswith(b'.gz') else path)


def save(path, text):
    """By Python, because cv::FileStorage does not tell that a disk is full."""
    try:
        with open(path, 'wb') as file:
            file.write(gzip.compress(text) if path.endswith(b'.gz') else text)
    except OSError as error:
        shown = path.decode(errors='backslashreplace')
        raise aqorb.error(f"fileName must be a file that can be written, got '{shown}' ({error})") from None


def root_of(text):
    import cv2
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    return storage, storage.root()  # the node is of no use without the storage


def write(text, storage, name):
    if not storage.isOpened():
        raise aqorb.error('fs must be a storage that is open to write, got one that is not open')
    source, root = root_of(text)
    if name:
        import cv2
        storage.startWriteStruct(name, cv2.FileNode_MAP)
    for key in root.keys():
        node = root.getNode(key)
        storage.write(key, node.string() if node.isString() else int(node.real()) if node.isInt() else node.real())
    if name:
        storage.endWriteStruct()


def read(text, node):
    """The parameters that a node has, of those in the text, as such a text."""
    if not node.isMap():
        raise aqorb.error('fn must be a map of the parameters, got a node that ' +
                          ('does not exist' if node.isNone() else 'is no map'))
    import cv2
    given = cv2.FileStorage('.yml', cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    source, root = root_of(text)
    for key in root.keys():
        value = node.getNode(key)
        if value.isInt() or value.isReal():
            given.write(key, value.real())
        elif not root.getNode(key).isString() and not value.isNone():
            given.write(key, 'no number')  # for the library to say which parameter should have been one
    return given.releaseAndGetString()
