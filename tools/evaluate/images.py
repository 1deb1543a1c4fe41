# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The images that methods are compared on."""

import glob
import os

import cv2
import numpy as np

PAPER_SETS = ['bikes', 'leuven', 'bark', 'trees', 'ubc']
SETS = PAPER_SETS + ['graf']


def read_image(stem, flags=cv2.IMREAD_GRAYSCALE):
    for file in sorted(glob.glob(stem + '.*')):
        image = cv2.imread(file, flags)
        if image is not None:
            return image
    raise FileNotFoundError(stem + ': no such image')


def read_matrix(stem):
    """A homography; None where there is none."""
    if os.path.exists(stem + '.xml'):
        storage = cv2.FileStorage(stem + '.xml', cv2.FILE_STORAGE_READ)
        return storage.getFirstTopLevelNode().mat()
    return np.loadtxt(stem).reshape(3, 3) if os.path.exists(stem) else None


def read_set(folder, name, flags=cv2.IMREAD_GRAYSCALE):
    """The six images of a set, and the homographies from the first one to each."""
    path = os.path.join(folder, name)
    homographies = [np.eye(3)] + [read_matrix('{}/H1to{}p'.format(path, i)) for i in range(2, 7)]
    if any(homography is None for homography in homographies):
        raise FileNotFoundError(path + ': needs H1to2p to H1to6p')
    return [read_image('{}/img{}'.format(path, i), flags) for i in range(1, 7)], homographies


def scaled(image, scale):
    """The resized image, and the homography to it. Coordinates count from the middle of a pixel."""
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    shift = (scale - 1) / 2
    return (cv2.resize(image, None, fx=scale, fy=scale, interpolation=how),
            np.array([[scale, 0, shift], [0, scale, shift], [0, 0, 1]]))


def rolled(image, degrees):
    """The image rolled about its centre on a canvas of its size, filled by reflection, and the homography to it."""
    height, width = image.shape[:2]
    turn = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), degrees, 1)
    return (cv2.warpAffine(image, turn, (width, height), borderMode=cv2.BORDER_REFLECT_101),
            np.vstack([turn, [0, 0, 1]]))


def with_object(scene, part, scale, place, degrees):
    """A photograph with a small, turned copy of another image in it, whose right side is a little further away."""
    height, width = part.shape
    turn = cv2.getRotationMatrix2D((0, 0), degrees, scale)[:, :2]
    corners = np.array([[0, 0], [width, .06 * height], [width, .94 * height], [0, height]]) @ turn.T + place
    matrix = cv2.getPerspectiveTransform(np.float32([[0, 0], [width, 0], [width, height], [0, height]]),
                                         np.float32(corners))
    size, scene = scene.shape[::-1], scene.copy()
    inside = cv2.warpPerspective(np.full(part.shape, 255, np.uint8), matrix, size) > 127
    scene[inside] = cv2.warpPerspective(cv2.GaussianBlur(part, (0, 0), .5 / scale), matrix, size)[inside]
    cv2.setRNGSeed(1)
    noise = cv2.randn(np.zeros(scene.shape, np.int16), (0,) * 4, (2,) * 4)
    return cv2.add(scene, noise, dtype=cv2.CV_8U)


def with_weaker_half(image):
    """The left half of an image, beside itself mirrored at a contrast of .3, and the column where this begins."""
    left = image[:, :image.shape[1] // 2]
    mean = left.mean()
    return np.hstack([left, np.round(mean + .3 * (left[:, ::-1] - mean)).astype(np.uint8)]), left.shape[1]


def small_objects(folder, sets):
    """[(name, object, scene)]: box.png in box_in_scene.png, and three that are drawn into photographs of sets."""
    box, scene = (read_image(os.path.join(folder, name)) for name in ('box', 'box_in_scene'))
    wall, parked = sets['graf'][0][0][100:420, 150:550], sets['ubc'][0][0][100:400, 100:500]
    return [('box', box, scene), ('trees', box, with_object(sets['trees'][0][0], box, .6, (430, 380), 17)),
            ('leuven', wall, with_object(sets['leuven'][0][0], wall, .55, (360, 220), -11)),
            ('bark', parked, with_object(sets['bark'][0][0], parked, .5, (300, 200), 14))]


def read_folder(folder, width):
    """The images of a folder, reduced to a width at most."""
    found = [cv2.imread(file, cv2.IMREAD_GRAYSCALE) for file in sorted(glob.glob(os.path.join(folder, '*.[jp][pn]*g')))]
    return [scaled(image, width / image.shape[1])[0] if image.shape[1] > width else image for image in found]


def read_scene(path, width):
    """(name, image, camera's matrix, rotation, centre) of each photograph of one of Strecha's scenes, reduced to a
    width. Rotation and centre lead from the camera to the world."""
    for name in sorted(os.listdir(os.path.join(path, 'gt_dense_cameras'))):
        stem = name.split('.')[0]
        image = read_image(os.path.join(path, 'images', stem))
        reduced, matrix = scaled(image, width / image.shape[1])
        with open(os.path.join(path, 'gt_dense_cameras', name), encoding='utf-8') as file:
            numbers = np.array(file.read().split(), float)
        yield stem, reduced, matrix @ numbers[:9].reshape(3, 3), numbers[12:21].reshape(3, 3), numbers[21:24]


def read_sequence(folder):
    """The left images of a sequence in KITTI's layout, the camera's matrix, and the poses of the frames."""
    files = sorted(glob.glob(os.path.join(folder, 'image_[0l]/*')))
    images = [cv2.imread(file, cv2.IMREAD_GRAYSCALE) for file in files]
    with open(os.path.join(folder, 'calib.txt'), encoding='utf-8') as file:
        camera = np.array(file.readline().split()[-12:], float).reshape(3, 4)[:, :3]
    poses = [np.vstack([pose.reshape(3, 4), [0, 0, 0, 1]]) for pose in np.loadtxt(os.path.join(folder, 'poses.txt'))]
    return images, camera, poses
