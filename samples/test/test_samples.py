# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Runs each Python sample, on images made from a photograph of opencv_extra or, without it, from a drawn scene; and on
files that are none. Each is run as a copy in a folder of its own."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import cv2 as cv
import numpy as np
import pytest

SAMPLES = pathlib.Path(__file__).resolve().parent.parent
HOMOGRAPHY = np.array([[0.9, -0.15, 90], [0.1, 0.95, -20], [1e-4, 5e-5, 1]])  # from view1.png to view2.png


@pytest.fixture(scope='module')
def images(tmp_path_factory):
    """The folder with what sample_images.cpp makes, a program that AQORB_SAMPLE_IMAGES names."""
    if 'AQORB_SAMPLE_IMAGES' not in os.environ:
        pytest.skip('AQORB_SAMPLE_IMAGES is not set')
    folder = tmp_path_factory.mktemp('images')
    subprocess.run([os.environ['AQORB_SAMPLE_IMAGES'], str(folder)], check=True)
    return folder


@pytest.fixture
def start(images, tmp_path):
    def start_sample(name, *arguments, **environment):
        """The finished process of a sample; IMAGES in arguments is the folder of the images."""
        command = [sys.executable, shutil.copy(str(SAMPLES / (name + '.py')), str(tmp_path))]
        command += [argument.replace('IMAGES', str(images)) for argument in arguments]
        return subprocess.run(command, cwd=str(tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env=dict(os.environ, **environment), timeout=120)
    return start_sample


@pytest.fixture
def run(start, tmp_path):
    def run_sample(name, *files, options=()):
        """The sample's output and its picture."""
        out = tmp_path / 'out.png'
        result = start(name, '--out=' + str(out), *options, *['IMAGES/' + file for file in files])
        assert result.returncode == 0, result.stderr
        return result.stdout, cv.imread(str(out))
    return run_sample


def test_homography(run):
    output, _ = run('homography', 'view1.png', 'view2.png')
    rows = re.findall(r'^ ?\[+(.*?)\]+$', output, re.MULTILINE)
    found = np.array([row.split() for row in rows], float)
    corners = np.float32([[[0, 0]], [[899, 0]], [[899, 599]], [[0, 599]]])
    difference = cv.perspectiveTransform(corners, found) - cv.perspectiveTransform(corners, HOMOGRAPHY)
    assert np.abs(difference).max() < 2


def test_panorama(run):
    _, picture = run('panorama', 'part1.png', 'part2.png', 'part3.png')
    height, width = picture.shape[:2]
    assert abs(width - 900) < 40 and abs(height - 600) < 40


@pytest.mark.parametrize('name', ['aqorb_demo', 'fisheye_mask', 'homography', 'retain_uniform'])
def test_a_sample_image_that_is_missing(start, name):
    result = start(name, OPENCV_SAMPLES_DATA_PATH='')
    if result.returncode == 0:
        pytest.skip('OpenCV finds its samples')
    assert '=$(scripts/demo.sh --images)' in result.stderr


def test_retain_uniform(run):
    output, _ = run('retain_uniform', 'view1.png', options=['--npoints=300'])
    table = {(detector, how): (int(n), int(occupied)) for detector, how, n, occupied in
             re.findall(r'^(\w+), (\w+) +(\d+) +[\d.]+ +(\d+) %', output, re.MULTILINE)}
    for detector in 'SIFT', 'FAST':
        assert table[detector, 'retainUniform'][0] == table[detector, 'retainBest'][0] == 300
        assert table[detector, 'retainUniform'][1] > table[detector, 'retainBest'][1]


def test_live(run):
    output, picture = run('live', 'frame_%02d.png', options=['--headless', '--frames=3', '--threshold=10'])
    assert output.count('AdaptiveQuadtreeORB, threshold 10: 1000 keypoints') == 3
    assert picture.shape[1] == 640


@pytest.mark.skipif(not (shutil.which('Xvfb') and shutil.which('xdotool')), reason='needs Xvfb and xdotool')
def test_live_window(images):
    command = [str(SAMPLES / 'test' / 'live_window.sh'), sys.executable, str(SAMPLES / 'live.py')]
    result = subprocess.run(command + [str(images / 'frame_%02d.png')], stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, timeout=120)
    assert result.returncode == 0, result.stdout


def test_fisheye_mask(run):
    output, _ = run('fisheye_mask', 'fisheye.png', options=['--radius=290'])
    assert int(re.search(r'Without mask: \d+ keypoints, (\d+) not', output).group(1)) > 0
    assert 'With mask: 1000 keypoints, 0 not inside' in output


def test_aqorb_demo(start, tmp_path):
    result = start('aqorb_demo', 'IMAGES/view1.png', 'IMAGES/view2.png')
    assert result.returncode == 0, result.stderr
    assert re.search(r'^distinct consistent matches +\d+ +\d+$', result.stdout, re.MULTILINE)
    for name in 'keypoints', 'matches':
        assert cv.imread(str(tmp_path / 'aqorb_{}.jpg'.format(name))) is not None


def test_aqorb_demo_with_a_known_homography(start, tmp_path):
    storage = cv.FileStorage(str(tmp_path / 'homography.yml'), cv.FILE_STORAGE_WRITE)
    storage.write('H', HOMOGRAPHY)
    storage.release()
    result = start('aqorb_demo', '--homography=homography.yml', 'IMAGES/view1.png', 'IMAGES/view2.png')
    assert result.returncode == 0, result.stderr
    errors = re.search(r'^error of the estimated homography +([\d.]+) px +([\d.]+) px$', result.stdout, re.MULTILINE)
    assert max(map(float, errors.groups())) < 2


def test_all_samples_are_tested():
    assert {path.stem for path in SAMPLES.glob('*.py')} == set(UNREADABLE)


# What each says of a file that is none.
NO_IMAGE = 'text.png: cannot be read as an image'
UNREADABLE = {'aqorb_demo': NO_IMAGE, 'fisheye_mask': NO_IMAGE, 'homography': NO_IMAGE, 'live': 'text.png: not ',
              'panorama': NO_IMAGE, 'retain_uniform': NO_IMAGE}


@pytest.mark.parametrize('name', UNREADABLE)
def test_help(start, name):
    result = start(name, '--help')
    assert result.returncode == 0 and not result.stderr
    assert 'usage: {}.py '.format(name) in result.stdout and '--out' in result.stdout


@pytest.mark.parametrize('name', UNREADABLE)
def test_unusable_file(start, name):
    result = start(name, 'IMAGES/text.png')
    assert result.returncode == 1 and UNREADABLE[name] in result.stderr and 'Traceback' not in result.stderr


@pytest.mark.parametrize('name, files, text', [
    ('homography', ('32x32.png', 'view1.png'), 'no homography was found among '),
    ('panorama', ('view1.png', '32x32.png'), 'the ')])
def test_no_result(start, name, files, text):
    result = start(name, *['IMAGES/' + file for file in files])
    assert result.returncode == 1 and result.stderr.startswith(text)
