# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Runs each Python sample once, on images made from a photograph of opencv_extra or, without it, from a drawn one."""

import os
import pathlib
import re
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


@pytest.fixture(scope='module')
def images(tmp_path_factory):
    scene = cv.imread(os.path.join(os.environ.get('OPENCV_TEST_DATA_PATH', ''), PHOTOGRAPH), cv.IMREAD_GRAYSCALE)
    scene = drawn() if scene is None else scene
    circle = cv.circle(np.zeros_like(scene), (450, 300), 290, 255, cv.FILLED)
    made = {'view1': scene, 'view2': cv.warpPerspective(scene, HOMOGRAPHY, scene.shape[::-1]),
            'fisheye': scene & circle}
    made.update(('part{}'.format(i + 1), scene[:, 225 * i:225 * i + 450]) for i in range(3))
    made.update(('frame_{:02}'.format(i), scene[10 * i:10 * i + 480, 20 * i:20 * i + 640]) for i in range(4))
    folder = tmp_path_factory.mktemp('images')
    for name, image in made.items():
        assert cv.imwrite(str(folder / (name + '.png')), image)
    return folder


@pytest.fixture
def run(images, tmp_path):
    def run_sample(name, *arguments):
        """The sample's output and its picture; arguments that end in .png are among the images."""
        out = tmp_path / 'out.png'
        command = [sys.executable, str(SAMPLES / (name + '.py')), '--out=' + str(out)]
        command += [str(images / argument) if argument.endswith('.png') else argument for argument in arguments]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
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


def test_retain_uniform(run):
    output, _ = run('retain_uniform', 'view1.png', '--npoints=300')
    table = {(detector, how): (int(n), int(occupied)) for detector, how, n, occupied in
             re.findall(r'^(\w+), (\w+) +(\d+) +[\d.]+ +(\d+) %', output, re.MULTILINE)}
    for detector in 'SIFT', 'FAST':
        assert table[detector, 'retainUniform'][0] == table[detector, 'retainBest'][0] == 300
        assert table[detector, 'retainUniform'][1] > table[detector, 'retainBest'][1]


def test_live(run):
    output, picture = run('live', 'frame_%02d.png', '--headless', '--frames=3', '--threshold=10')
    assert output.count('AdaptiveQuadtreeORB, threshold 10: 1000 keypoints') == 3
    assert picture.shape == (480, 640, 3)


def test_fisheye_mask(run):
    output, _ = run('fisheye_mask', 'fisheye.png', '--radius=290')
    assert int(re.search(r'Without mask: \d+ keypoints, (\d+) not', output).group(1)) > 0
    assert 'With mask: 1000 keypoints, 0 not inside' in output


@pytest.mark.parametrize('name, count', [('homography', 2), ('panorama', 2), ('retain_uniform', 1), ('live', 1),
                                         ('fisheye_mask', 1)])
def test_without_an_image(name, count, tmp_path):
    command = [sys.executable, str(SAMPLES / (name + '.py'))] + ['missing.png'] * count
    result = subprocess.run(command, cwd=str(tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert result.returncode == 1
    assert re.search('^missing.png: ', result.stderr, re.MULTILINE) and 'Traceback' not in result.stderr
