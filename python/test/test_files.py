# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of files and cv2's storages with the parameters of a detector."""

import os
import pathlib
import reprlib

import cv2 as cv
import numpy as np
import pytest

import aqorb
from conftest import copies_of, values_of


def storage_of(text):
    return cv.FileStorage(text, cv.FILE_STORAGE_READ | cv.FILE_STORAGE_MEMORY)


@pytest.mark.parametrize('kind', [str, pathlib.Path, os.fsencode])
@pytest.mark.parametrize('name', [
    'plain.yml', 'with some spaces.xml', 'zwölf Boxkämpfer.json', '日本.yml', 'packed.yml.gz'])
def test_file_names(tmp_path, orb, kind, name):
    path = kind(str(tmp_path / name))
    orb.write(path)
    assert os.listdir(str(tmp_path)) == [name]
    other = aqorb.AdaptiveQuadtreeORB_create()
    other.read(path)
    assert other.getMaxFeatures() == 300


def test_file_names_that_are_no_unicode(tmp_path, orb):
    path = os.path.join(os.fsencode(str(tmp_path)), b'\xff.yml')
    orb.save(path)
    orb.read(os.fsdecode(path))
    with pytest.raises(aqorb.error, match='no folder'):
        orb.read(os.fsdecode(b'no folder/\xff.yml'))


@pytest.mark.parametrize('wrong', [5, None, ['orb.yml'], storage_of('{}').root, np.zeros(3)])
def test_things_that_are_no_file(orb, wrong):
    for call, accepted in (orb.write, 'FileStorage'), (orb.save, 'FileStorage'), (orb.read, 'FileNode'):
        with pytest.raises(TypeError) as raised:
            call(wrong)
        assert str(raised.value) == f'fileName must be a str, a path or a cv2.{accepted}, got {reprlib.repr(wrong)}'


@pytest.mark.parametrize('content', [None, b'', b'no storage', b'{"nfeatures": '])
def test_files_that_cannot_be_read(tmp_path, orb, content):
    path = tmp_path / 'wrong.json'
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(aqorb.error, match=r"fileName must be a file that can be read, got '.*wrong\.json'") as raised:
        orb.read(path)
    assert isinstance(raised.value, cv.error)
    with pytest.raises(aqorb.error, match=r"fileName must be a file that can be written, got '.*' \(.*Is a directory"):
        orb.write(tmp_path)
    for call in orb.read, orb.write:
        with pytest.raises(aqorb.error, match="fileName must be a file that can be .*, got ''"):
            call('')
        with pytest.raises(aqorb.error, match=r"got 'a\\x00b.yml' \(embedded null byte"):
            call('a\0b.yml')


@pytest.mark.parametrize('text, message', [
    ('{"a": 1}', 'fn must be a map of the parameters, got a node that does not exist'),
    ('{"detector": 1}', 'fn must be a map of the parameters, got a node that is no map'),
    ('{"detector": [1]}', 'fn must be a map of the parameters, got a node that is no map')])
def test_nodes_that_hold_no_parameters(orb, text, message):
    storage = storage_of(text)
    with pytest.raises(aqorb.error, match=message):
        orb.read(storage.getNode('detector'))


def test_every_parameter_survives_a_storage(tmp_path, unusual):
    orb, values = unusual
    path = tmp_path / 'orb.xml'
    orb.write(path)
    storage = cv.FileStorage('.yml', cv.FILE_STORAGE_WRITE | cv.FILE_STORAGE_MEMORY)
    orb.write(storage, 'detector')
    written = storage_of(storage.releaseAndGetString())
    for source in path, written.getNode('detector'):
        other = aqorb.AdaptiveQuadtreeORB_create()
        other.read(source)
        assert values_of(other, values) == values
    for copied in copies_of(orb):
        assert type(copied) is aqorb.AdaptiveQuadtreeORB and values_of(copied, values) == values
        copied.setMaxFeatures(5)
        assert values_of(orb, values) == values


@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='needs /dev/full')
def test_a_disk_that_is_full(orb):
    with pytest.raises(aqorb.error, match="fileName must be a file that can be written, got '/dev/full'.*No space left"):
        orb.write('/dev/full')


def test_storages_that_are_not_open_to_write(orb):
    with pytest.raises(aqorb.error, match='fs must be a storage open for writing'):
        orb.write(cv.FileStorage())
    with pytest.raises(cv.error, match='write'):
        orb.write(storage_of('{}'))
