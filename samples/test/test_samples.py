# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Runs each Python sample on the images of sample_images.cpp, and on files that are missing or no images."""

import os
import pathlib
import subprocess
import sys

import cv2 as cv
import numpy as np
import pytest

SAMPLES = pathlib.Path(__file__).resolve().parent.parent


@pytest.fixture(scope='module')
def images(tmp_path_factory):
    """The folder with what sample_images.cpp makes, a program that AQORB_SAMPLE_IMAGES names."""
    if 'AQORB_SAMPLE_IMAGES' not in os.environ:
        pytest.skip('AQORB_SAMPLE_IMAGES is not set')
    folder = tmp_path_factory.mktemp('images')
    subprocess.run([os.environ['AQORB_SAMPLE_IMAGES'], str(folder)], check=True)
    return folder


def start(images, command):
    """The finished process of a sample, in the folder of the images."""
    name, *arguments = command.split()
    return subprocess.run([sys.executable, str(SAMPLES / (name + '.py')), *arguments], cwd=str(images),
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)


def run(images, command):
    """A sample's output and its picture."""
    result = start(images, command + ' --out=out.png')
    assert result.returncode == 0, result.stderr
    return result.stdout, cv.imread(str(images / 'out.png'))


def test_panorama(images):
    _, picture = run(images, 'panorama part1.png part2.png part3.png')
    assert abs(picture.shape[1] - 900) < 40 and abs(picture.shape[0] - 600) < 40


def test_panorama_of_impossible_cameras(images, monkeypatch):
    """OpenCV 5.0 finds some for two views of a wall, and folds both to a picture of 279x80."""
    monkeypatch.syspath_prepend(str(SAMPLES))
    import panorama
    monkeypatch.setattr(panorama, 'compose', lambda images, cameras: np.zeros((80, 279, 3), np.uint8))
    monkeypatch.setattr(sys, 'argv', ['panorama', *[str(images / 'part{}.png'.format(i)) for i in (1, 2, 3)]])
    with pytest.raises(SystemExit, match='the cameras could not be estimated'):
        panorama.main()


@pytest.mark.parametrize('command, text', [
    ('panorama no.png view1.png', 'no.png: there is no such file'),
    ('panorama text.png view1.png', 'text.png: cannot be read as an image'),
    ('panorama no.png no.png --out=missing/picture.png', 'cannot be written'),  # before all else
    ('panorama view1.png 32x32.png', 'the ')])
def test_sentence(images, command, text):
    result = start(images, command)
    assert result.returncode == 1 and text in result.stderr and 'Traceback' not in result.stderr
