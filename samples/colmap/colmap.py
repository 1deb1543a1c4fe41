#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Reconstructs a scene with COLMAP from the images of a moving camera, with features of each of several detectors.

usage: colmap.py [--detectors=aqorb,orb,sift] [--features=2000] [--neighbours=5] [--runs=5]
                 [--out=colmap] FOLDER

FOLDER has the images in the folder image_0 or image_l, the first camera's projection matrix in the first line of
calib.txt and, if the error is to be measured, the true poses in poses.txt, as the odometry benchmark of KITTI has them.

Features are matched between each image and the next ones, as mutual nearest neighbours: those of ORB by Hamming
distance, which COLMAP does not know. The keypoints and the matches are written into COLMAP's database. COLMAP verifies
them and reconstructs the camera's poses and the points. The latter depends on chance, so that it is done several times,
with the seeds 0 to --runs - 1. The table has the medians, and the position errors from the least to the greatest.
The reconstructions are left in the folder --out. Needs pycolmap.
"""

import argparse
import os
import shutil
import sys

import cv2 as cv
import numpy as np
import pycolmap

import aqorb
from aqorb.collection import colmap


def fail(message):
    sys.exit('colmap.py: ' + message)


def make_detector(name, features):
    """The detector, and the norm that its descriptors are compared by."""
    if name == 'aqorb':
        return aqorb.AdaptiveQuadtreeORB_create(features), cv.NORM_HAMMING
    if name == 'orb':
        return cv.ORB_create(features), cv.NORM_HAMMING
    if name == 'sift':
        return cv.SIFT_create(features), cv.NORM_L2
    return fail('there is no detector {}'.format(name))


def read_camera(folder, size):
    with open(os.path.join(folder, 'calib.txt')) as file:
        projection = np.array(file.readline().split()[-12:], float).reshape(3, 4)
    return pycolmap.Camera(model='PINHOLE', width=size[0], height=size[1], has_prior_focal_length=True, params=[
        projection[0, 0], projection[1, 1], projection[0, 2] + .5, projection[1, 2] + .5])


def fill_database(path, folder, names, name, features, neighbours):
    """Detects, matches and writes into a new database."""
    detector, norm = make_detector(name, features)
    images = [cv.imread(os.path.join(folder, file), cv.IMREAD_GRAYSCALE) for file in names]
    if any(image is None for image in images):
        fail('not all files in {} are images'.format(folder))
    found = [detector.detectAndCompute(image, None) for image in images]
    database = pycolmap.Database.open(path)
    camera = colmap.write_camera(database, read_camera(os.path.dirname(folder), images[0].shape[::-1]))
    ids = [colmap.write_image(database, file, camera, aqorb.keypointsToArray(keypoints))
           for file, (keypoints, _) in zip(names, found)]
    pairs = [(i, j) for i in range(len(names)) for j in range(i + 1, min(i + 1 + neighbours, len(names)))]
    for i, j in pairs:
        if norm == cv.NORM_HAMMING:
            matches = aqorb.matchArrays(found[i][1], found[j][1])[0]
        else:
            matches = cv.BFMatcher(norm, crossCheck=True).match(found[i][1], found[j][1])
            matches = [(m.queryIdx, m.trainIdx) for m in matches]
        database.write_matches(ids[i], ids[j], np.array(matches, np.uint32).reshape(-1, 2))
    database.close()


def position_error(reconstruction, folder, names):
    """The root of the mean square distance in metres between the camera's positions and the true ones, after the best
    similarity transform; None without poses.txt."""
    path = os.path.join(folder, 'poses.txt')
    if not os.path.exists(path):
        return None
    poses = np.loadtxt(path).reshape(-1, 3, 4)
    found, true = [], []
    for image in reconstruction.images.values():
        if image.has_pose:
            found.append(image.projection_center())
            true.append(poses[names.index(image.name)][:, 3])
    found, true = np.array(found), np.array(true)
    transform, scale = cv.estimateAffine3D(found, true, force_rotation=True)
    difference = true - scale * found @ transform[:, :3].T - transform[:, 3]
    return np.sqrt((difference ** 2).sum(1).mean())


def reconstruct(folder, names, name, options):
    """The largest reconstruction of each run that gave one."""
    out = os.path.join(options.out, name)
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    database = os.path.join(out, 'database.db')
    fill_database(database, folder, names, name, options.features, options.neighbours)
    pycolmap.set_random_seed(0)
    pycolmap.geometric_verification(database)
    pipeline = pycolmap.IncrementalPipelineOptions(ba_refine_focal_length=False, ba_refine_extra_params=False,
                                                   multiple_models=False, num_threads=2)
    # A camera that looks ahead as it drives has no pair of images that COLMAP would begin with otherwise.
    pipeline.mapper.init_max_forward_motion = 1
    pipeline.mapper.init_min_tri_angle = 4
    largest = []
    for seed in range(options.runs):
        pycolmap.set_random_seed(seed)
        run = os.path.join(out, 'run{}'.format(seed))
        os.makedirs(run)
        found = pycolmap.incremental_mapping(database, folder, run, pipeline)
        if found:
            largest.append(max(found.values(), key=lambda r: r.num_reg_images()))
    return largest


def table_row(name, found, names, options):
    """A row of the table: medians of the reconstructions, and each position error."""
    def median(values):
        return np.median(list(values))

    if not found:
        return '| {} | 0 of {} | | | | |'.format(name, len(names))
    errors = [position_error(reconstruction, options.folder, names) for reconstruction in found]
    return '| {} | {:.0f} of {} | {:.0f} | {:.2f} | {:.3f} | {} |'.format(
        name, median(r.num_reg_images() for r in found), len(names), median(r.num_points3D() for r in found),
        median(r.compute_mean_track_length() for r in found),
        median(r.compute_mean_reprojection_error() for r in found),
        '' if None in errors else ', '.join('{:.3f}'.format(error) for error in sorted(errors)))


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split('usage: ')[1].split('\n\n')[0], add_help=True)
    parser.add_argument('--detectors', default='aqorb,orb,sift')
    parser.add_argument('--features', type=int, default=2000)
    parser.add_argument('--neighbours', type=int, default=5)
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--out', default='colmap')
    parser.add_argument('folder')
    options = parser.parse_args()
    folder = os.path.join(options.folder, 'image_0')
    if not os.path.isdir(folder):
        folder = os.path.join(options.folder, 'image_l')
    if not os.path.isdir(folder):
        fail('{} has no folder image_0 or image_l'.format(options.folder))
    names = sorted(os.listdir(folder))
    pycolmap.logging.minloglevel = 2
    print('| features | images | points | track length | reprojection error, px | position errors, m |')
    print('|---|---|---|---|---|---|')
    for name in options.detectors.split(','):
        print(table_row(name, reconstruct(folder, names, name, options), names, options), flush=True)


if __name__ == '__main__':
    main()
