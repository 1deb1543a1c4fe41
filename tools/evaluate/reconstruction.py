# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Reconstructions of Strecha's photographs by COLMAP's mapper, from SIFT's features and from those of aqorb."""

import itertools
import os
import re
import resource
import shutil
import subprocess
import sys

import aqorb
import cv2
import numpy as np

import images
import measures
import poses

SEEDS = range(3)  # of the mapper
PAGE = os.path.join(os.path.dirname(__file__), '../../photographs/reconstruction.md')
HEAD = ['', 'images', 'positions, mm', "of SIFT's", 'median, mm', 'rotations, degrees', 'points', 'reprojection, px',
        'features, s', 'matches, s', 'tracks, s', 'mapper, s']


class Scene:
    """The photographs of a scene, reduced, in a folder; their true rotations and centres; and what COLMAP is told of
    their camera if it is known and if it is not."""

    def __init__(self, source, out):
        self.folder, self.truth = os.path.join(out, 'images'), {}
        os.makedirs(self.folder, exist_ok=True)
        for stem, picture, camera, rotation, centre in images.read_scene(source, poses.WIDTH):
            cv2.imwrite(os.path.join(self.folder, stem + '.png'), picture)
            self.truth[stem + '.png'] = rotation, centre
        # The centre of the first pixel is (0, 0) in OpenCV's coordinates, (0.5, 0.5) in COLMAP's.
        self.parameters = [camera[0, 0], camera[1, 1], camera[0, 2] + .5, camera[1, 2] + .5]
        known = {'camera_model': 'PINHOLE', 'camera_params': ','.join(map(str, self.parameters))}
        self.cameras = {'known': known, 'unknown': {}}

    def errors(self, model):
        """The errors of camera positions in mm and of rotations in degrees, after the similarity that fits best."""
        found = {image.name: image.cam_from_world().inverse() for image in model.images.values() if image.has_pose}
        moved, true = (np.array(each) for each in (
            [pose.translation for pose in found.values()], [self.truth[name][1] for name in found]))
        u, values, v = np.linalg.svd((true - true.mean(0)).T @ (moved - moved.mean(0)))
        sign = [1, 1, np.linalg.det(u @ v)]
        turn, scale = u * sign @ v, values @ sign / ((moved - moved.mean(0))**2).sum()
        distances = np.linalg.norm((moved - moved.mean(0)) @ turn.T * scale - true + true.mean(0), axis=1)
        angles = [poses.angle((np.trace(self.truth[name][0].T @ turn @ pose.rotation.matrix()) - 1) / 2)
                  for name, pose in found.items()]
        return 1000 * distances.mean(), 1000 * np.median(distances), np.mean(angles)


def seconds():
    """Processor time of this process and of those that have ended."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def timed(function, *arguments, **options):
    start = seconds()
    return function(*arguments, **options), seconds() - start


def by_sift(scene, path, camera, count):
    """COLMAP's own features and matches."""
    import pycolmap  # only this command needs it
    options = pycolmap.FeatureExtractionOptions()
    options.sift.max_num_features = count
    return [timed(pycolmap.extract_features, path, scene.folder, camera_mode=pycolmap.CameraMode.SINGLE,
                  reader_options=pycolmap.ImageReaderOptions(**camera), extraction_options=options)[1],
            timed(pycolmap.match_exhaustive, path)[1], 0]


def by_sift_tracks(scene, path, _, count):
    """OpenCV's SIFT, and the program of the tutorial."""
    import pycolmap
    from aqorb_photographs import colmap, tracks
    pictures = [cv2.imread(os.path.join(scene.folder, name), cv2.IMREAD_GRAYSCALE) for name in scene.truth]
    size, sift = pictures[0].shape[::-1], cv2.SIFT_create(count)
    features, first = timed(lambda: [measures.Features(*sift.detectAndCompute(picture, None)) for picture in pictures])

    def match(i, j):
        return measures.indices(poses.mutual(features[i], features[j], cv2.NORM_L2, .8))

    with open(PAGE, encoding='utf-8') as file:
        program = re.search('```python\n(aligned.*?)```', file.read(), re.DOTALL)[1].replace('sift.db', path)
    names = {'itertools': itertools, 'pycolmap': pycolmap, 'colmap': colmap, 'tracks': tracks, 'match': match,
             'names': list(scene.truth), 'images': pictures,
             'keypoints': [aqorb.keypointsToArray(found.keypoints) for found in features],
             'camera': pycolmap.Camera(model='PINHOLE', width=size[0], height=size[1], params=scene.parameters)}
    return [first, 0, timed(exec, program, names)[1]]


def by_command(scene, path, camera, option):
    """The command aqorb."""
    features, matches = (os.path.join(os.path.dirname(path), name) for name in ('features', 'matches'))
    options = [word for name, value in camera.items() for word in ('--' + name.replace('_', '-'), value)]
    return [timed(subprocess.run, [sys.executable, '-m', 'aqorb_photographs', *call], check=True)[1] for call in (
        ['extract', scene.folder, '--out', features, '--num-features', '2000'],
        ['match', features, '--pairs', 'exhaustive', '--out', matches],
        ['colmap', features, matches, '--images', scene.folder, '--database', path, '--camera-mode', 'SINGLE', option,
         *options])]


METHODS = {'SIFT, 2000 features': (by_sift, 2000), "SIFT, COLMAP's 8192": (by_sift, 8192),
           'SIFT, 2000, tracks by aqorb': (by_sift_tracks, 2000), 'aqorb --no-refine': (by_command, '--no-refine'),
           'aqorb': (by_command, '--refine')}


def measured(scene, folder, method, intrinsics):
    """The images, errors, points and seconds of a method, as medians of the mapper's seeds."""
    import pycolmap
    shutil.rmtree(folder, ignore_errors=True)  # the command aqorb would go on with what is there
    os.makedirs(folder)
    path, (function, argument) = os.path.join(folder, 'scene.db'), METHODS[method]
    times, found = function(scene, path, scene.cameras[intrinsics], argument), []
    for seed in SEEDS:
        options = pycolmap.IncrementalPipelineOptions(random_seed=seed, extract_colors=False)
        if intrinsics == 'known':
            options.ba_refine_focal_length = options.ba_refine_extra_params = False
        models, spent = timed(pycolmap.incremental_mapping, path, scene.folder, folder, options)
        model = max(models.values(), key=lambda each: each.num_reg_images())
        found.append([model.num_reg_images(), *scene.errors(model), model.num_points3D(),
                      model.compute_mean_reprojection_error(), *times, spent])
    return np.median(found, 0)


def draw(model, path):
    """Draws points and cameras as seen from above, each point in the colour of the first image that has it. A few points
    are far away, and left out."""
    from matplotlib import pyplot
    turn = next(iter(model.images.values())).cam_from_world().rotation.matrix()
    points = np.array([point.xyz for point in model.points3D.values()]) @ turn.T
    cameras = np.array([image.projection_center() for image in model.images.values()]) @ turn.T
    first = [min(element.image_id for element in point.track.elements) for point in model.points3D.values()]
    figure, axes = pyplot.subplots(figsize=(9, 6))
    axes.scatter(points[:, 0], points[:, 2], 3, first, cmap='tab20')
    axes.plot(cameras[:, 0], cameras[:, 2], 'k^')
    low, high = np.percentile(points, [2, 98], axis=0)
    low, high = np.minimum(low, cameras.min(0)), np.maximum(high, cameras.max(0))
    axes.set(xlim=(low[0] - 1, high[0] + 1), ylim=(low[2] - 1, high[2] + 1), aspect='equal')
    axes.axis('off')
    figure.savefig(path, dpi=72, bbox_inches='tight')


def tables(options):
    """(title, head, rows) of each table; draws the models of aqorb."""
    for name in poses.SCENES:
        out = os.path.join(options.out, name)
        scene = Scene(os.path.join(options.scenes, name), out)
        for intrinsics in scene.cameras:
            rows, first = [], 0
            for method in METHODS if intrinsics == 'known' else [each for each in METHODS if 'tracks' not in each]:
                count, mean, median, angle, points, reprojection, *times = measured(
                    scene, os.path.join(out, intrinsics, method.replace(' ', '_')), method, intrinsics)
                first = first or mean
                rows.append([method, '{:.0f} of {}'.format(count, len(scene.truth)), '{:.2f}'.format(mean),
                             '{:.2f}'.format(mean / first), '{:.2f}'.format(median), '{:.4f}'.format(angle),
                             '{:.0f}'.format(points), '{:.3f}'.format(reprojection), *map('{:.1f}'.format, times)])
            import pycolmap
            draw(pycolmap.Reconstruction(os.path.join(out, intrinsics, 'aqorb', '0')),
                 os.path.join(out, intrinsics + '.png'))
            yield '{}, intrinsics {}'.format(name, intrinsics), HEAD, rows
