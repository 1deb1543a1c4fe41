# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Runs each Python sample, on images made from a photograph of opencv_extra or, without it, from a drawn one; and
with arguments that none may accept."""

import collections
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
PHOTOGRAPH = 'cv/detectors_descriptors_evaluation/images_datasets/leuven/img1.png'
HOMOGRAPHY = np.array([[0.9, -0.15, 90], [0.1, 0.95, -20], [1e-4, 5e-5, 1]])


def drawn():
    """Squares of random place, size and brightness."""
    rng = np.random.RandomState(1)
    image = np.full((600, 900), 128, np.uint8)
    for _ in range(2500):
        side, x, y = rng.randint(5, 40), rng.randint(0, 900), rng.randint(0, 600)
        image[y:y + side, x:x + side] = rng.randint(0, 256)
    return image


def with_noise(image, random):
    return np.clip(image + random.normal(0, 30, image.shape), 0, 255).astype(np.uint8)


@pytest.fixture(scope='module')
def images(tmp_path_factory):
    scene = cv.imread(os.path.join(os.environ.get('OPENCV_TEST_DATA_PATH', ''), PHOTOGRAPH), cv.IMREAD_GRAYSCALE)
    scene = drawn() if scene is None else scene
    circle = cv.circle(np.zeros_like(scene), (450, 300), 290, 255, cv.FILLED)
    made = {'view1': scene, 'view2': cv.warpPerspective(scene, HOMOGRAPHY, scene.shape[::-1]),
            'fisheye': scene & circle}
    # Without noise OpenCV's matcher takes the parts for one and the same image, and drops the pair.
    noise = np.random.RandomState(2)
    made.update(('part{}'.format(i + 1), with_noise(scene[:, 225 * i:225 * i + 450], noise)) for i in range(3))
    made.update(('frame_{:02}'.format(i), scene[10 * i:10 * i + 480, 20 * i:20 * i + 640]) for i in range(4))
    # What no sample can work on, what is just enough, and what is too wide for a picture in JPEG.
    made.update(('{}x{}'.format(w, h), scene[:h, np.arange(w) % 900])
                for w, h in ((1, 1), (3, 3), (100000, 1), (32, 32), (70000, 40)))
    folder = tmp_path_factory.mktemp('images')
    for name, image in made.items():
        assert cv.imwrite(str(folder / (name + '.png')), image)
    for name in '1x1', '3x3', '100000x1':
        shutil.copy(str(folder / (name + '.png')), str(folder / (name + '_00.png')))
        stereo(folder / name, [made[name]], [made[name]])
    stereo(folder / 'stereo', [scene[50:530, 60 + 4 * i:700 + 4 * i] for i in range(3)],
           [scene[50:530, 70 + 4 * i:710 + 4 * i] for i in range(3)])
    stereo(folder / 'text', [scene], [scene])
    for name in 'text.png', 'text_00.png', 'text/image_0/0.png':
        (folder / name).write_text('no image')
    return folder


def stereo(folder, left, right):
    """A sequence in KITTI's layout: a camera that moves, and all points ten pixels of disparity away."""
    for camera, images_of_camera in enumerate((left, right)):
        (folder / 'image_{}'.format(camera)).mkdir(parents=True)
        for i, image in enumerate(images_of_camera):
            assert cv.imwrite(str(folder / 'image_{}'.format(camera) / '{}.png'.format(i)), image)
    (folder / 'calib.txt').write_text('P0: 500 0 320 0 0 500 240 0 0 0 1 0\nP1: 500 0 320 -250 0 500 240 0 0 0 1 0\n')


@pytest.fixture
def start(images, tmp_path):
    def start_sample(name, *arguments, **environment):
        """The finished process of a sample; IMAGES in arguments is the folder of the images."""
        command = [sys.executable, str(SAMPLES / (name + '.py'))]
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


def assert_fails(result, name, exit_code, text):
    """The sample ended with one sentence."""
    assert result.returncode == exit_code, result.stderr
    assert re.fullmatch(re.escape(name) + r'\.py: [^\n]*' + re.escape(text) + r'[^\n]*\n', result.stderr)


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


def test_stereo_odometry(run):
    output, _ = run('stereo_odometry', 'stereo')
    assert '3 frames' in output and re.search(r'^frames whose motion was not found +0 +0$', output, re.MULTILINE)


Sample = collections.namedtuple('Sample', 'name files form options number missing text without')

NO_FILE = ': no such file, nor one of OpenCV\'s samples in the folder that the variable OPENCV_SAMPLES_DATA_PATH names'
NO_IMAGE = ': not an image that OpenCV can read'
NO_VIDEO = ': not a video, nor a pattern of images, that OpenCV can read'

# files: how many it needs; form: of the name of one; without: what it says without arguments
ALL = [
    Sample('aqorb_demo', 2, '{}.png', [], 'nfeatures', NO_FILE, NO_IMAGE, 'rubberwhale1.png' + NO_FILE),
    Sample('fisheye_mask', 1, '{}.png', [], 'margin', NO_FILE, NO_IMAGE, 'graf1.png' + NO_FILE),
    Sample('homography', 2, '{}.png', [], 'nfeatures', NO_FILE, NO_IMAGE, 'graf1.png' + NO_FILE),
    Sample('live', 1, '{}_%02d.png', ['--headless', '--frames=2'], 'threshold', NO_VIDEO, ': not ',
           '0: there is no such camera'),
    Sample('panorama', 2, '{}.png', [], 'nfeatures', NO_FILE, NO_IMAGE, 'are needed; see --help'),
    Sample('retain_uniform', 1, '{}.png', [], 'npoints', NO_FILE, NO_IMAGE, 'graf1.png' + NO_FILE),
    Sample('stereo_odometry', 1, '{}', [], 'nfeatures', ': needs calib.txt', NO_IMAGE, 'are needed; see --help')]

each_sample = pytest.mark.parametrize('sample', ALL, ids=[sample.name for sample in ALL])


def files(sample, kind):
    return sample.options + ['IMAGES/' + sample.form.format(kind)] * sample.files


def test_all_samples_are_tested():
    modules = {'drawing', 'program'}
    assert {path.stem for path in SAMPLES.glob('*.py')} - modules == {sample.name for sample in ALL}


@each_sample
def test_help(start, sample):
    result = start(sample.name, '--help')
    assert result.returncode == 0 and not result.stderr
    for text in 'usage: {}.py '.format(sample.name), 'Example:\n  {}.py '.format(sample.name), '--out', 'default', \
            'Exit code: 0 done':
        assert text in result.stdout


@each_sample
@pytest.mark.parametrize('argument, text', [('--colour=3', '--colour=3: unknown option'), ('-c', '-c: unknown option'),
                                            ('--out', 'out')])
def test_bad_argument(start, sample, argument, text):
    assert_fails(start(sample.name, *files(sample, 'view1'), argument), sample.name, 2, text)


@each_sample
def test_bad_number(start, sample):
    argument = '--{}=-3'.format(sample.number)
    assert_fails(start(sample.name, *files(sample, 'view1'), argument), sample.name, 2,
                 argument + ': a whole number from ')


@pytest.mark.parametrize('value', ['0', '12abc', '99999999999', ''])
def test_bad_feature_count(start, value):
    argument = '--nfeatures=' + value
    assert_fails(start('homography', argument), 'homography', 2, argument + ': a whole number from 1 to 1000000')


@each_sample
def test_without_a_package(start, sample, tmp_path):
    (tmp_path / 'cv2.py').write_text('raise ImportError("No module named cv2")')
    result = start(sample.name, '--help', PYTHONPATH=str(tmp_path))
    assert_fails(result, sample.name, 1, 'No module named cv2. cv2, numpy, and either the package aqorb or ')


@each_sample
@pytest.mark.parametrize('kind', ['missing', 'text', '1x1', '3x3', '100000x1'])
def test_unusable_file(start, sample, kind):
    texts = {'missing': sample.missing, 'text': sample.text}
    text = texts.get(kind, ': has {} pixels; at least 32x32 are accepted'.format(kind))
    assert_fails(start(sample.name, *files(sample, kind)), sample.name, 1, text)


@each_sample
def test_without_arguments(start, sample):
    result = start(sample.name, *sample.options, OPENCV_SAMPLES_DATA_PATH='')
    if result.returncode == 0 and not sample.without.startswith('are needed'):
        pytest.skip('OpenCV finds its samples, or a camera')
    assert_fails(result, sample.name, 2 if sample.without.startswith('are needed') else 1, sample.without)


@pytest.mark.parametrize('name', ['fisheye_mask', 'homography', 'live', 'retain_uniform', 'stereo_odometry'])
def test_surplus_file(start, name):
    assert_fails(start(name, 'a.png', 'b.png', 'surplus.png'), name, 2, '.png: one argument too many')


@each_sample
def test_no_folder_for_the_picture(start, sample):
    kinds = {'fisheye_mask': 'fisheye', 'live': 'frame', 'panorama': 'part1', 'stereo_odometry': 'stereo'}
    arguments = files(sample, kinds.get(sample.name, 'view1'))
    if sample.name == 'panorama':
        arguments[1] = 'IMAGES/part2.png'
    result = start(sample.name, *arguments, '--out=missing/picture.png')
    assert_fails(result, sample.name, 1, 'missing/picture.png: ')


@pytest.mark.parametrize('size', ['32x32', '70000x40'])
@pytest.mark.parametrize('name', ['fisheye_mask', 'retain_uniform'])
def test_unusual_size(run, name, size):
    run(name, size + '.png')


def test_too_wide_for_jpeg(start):
    assert_fails(start('fisheye_mask', 'IMAGES/70000x40.png', '--out=wide.jpg'), 'fisheye_mask', 1,
                 'wide.jpg: a picture of 140000x')


@pytest.mark.parametrize('options, text', [
    (['--margin=5000'], '--margin=5000: at most the radius of '),
    (['--x=5000', '--y=300'], '--x=5000 --y=300: a centre inside the image of 900x600 pixels')])
def test_circle_outside(start, options, text):
    assert_fails(start('fisheye_mask', 'IMAGES/fisheye.png', *options), 'fisheye_mask', 2, text)


def test_no_homography(start):
    assert_fails(start('homography', 'IMAGES/32x32.png', 'IMAGES/view1.png'), 'homography', 1,
                 'no homography was found among ')


def test_one_image(start):
    assert_fails(start('homography', 'IMAGES/view1.png'), 'homography', 2, 'view1.png: a second image is needed')


def test_no_overlap(start):
    assert_fails(start('panorama', 'IMAGES/view1.png', 'IMAGES/32x32.png'), 'panorama', 1, 'the ')


@pytest.mark.parametrize('arguments, exit_code, text', [
    (['--homography=a.xml'], 2, '--homography=a.xml: is accepted with two images'),
    (['--homography=IMAGES/text.png', 'IMAGES/view1.png', 'IMAGES/view2.png'], 1,
     'text.png: an XML, YAML or JSON file with a 3x3 matrix is accepted')])
def test_demo_homography(start, arguments, exit_code, text):
    assert_fails(start('aqorb_demo', *arguments), 'aqorb_demo', exit_code, text)
