# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Writes features and matches of a collection to a COLMAP database, by pycolmap.

    from aqorb_photographs import colmap
    database = pycolmap.Database.open('scene.db')
    camera = colmap.write_camera(database, pycolmap.Camera(model='PINHOLE', width=640, height=480, params=[...]))
    first = colmap.write_image(database, 'first.jpg', camera, keypoints1)
    second = colmap.write_image(database, 'second.jpg', camera, keypoints2)
    database.write_matches(first, second, aqorb.matchArrays(descriptors1, descriptors2)[0])
    database.close()
    pycolmap.geometric_verification('scene.db')

COLMAP has no descriptor type for ORB, so ORB descriptors are written without a type: COLMAP keeps them, but neither
reads nor matches them."""

import functools
import json
import os
import secrets
import subprocess
import sys
import tempfile

import numpy as np

from aqorb_photographs import InputError, places, store, tracks

# Turn from the upright image to the image in the file for each EXIF orientation.
TURNS = {1: [[1, 0], [0, 1]], 2: [[-1, 0], [0, 1]], 3: [[-1, 0], [0, -1]], 4: [[1, 0], [0, -1]], 5: [[0, 1], [1, 0]],
         6: [[0, 1], [-1, 0]], 7: [[0, -1], [-1, 0]], 8: [[0, -1], [1, 0]]}

COLUMNS = ['x', 'y', 'size', 'angle', 'octave', 'descriptors']


def write_camera(database, camera):
    """Writes a pycolmap.Camera, and a rig with this camera alone. Returns the camera's number."""
    import pycolmap
    camera.camera_id = database.write_camera(camera)
    rig = pycolmap.Rig()
    rig.add_ref_sensor(camera.sensor_id)
    database.write_rig(rig)
    return camera.camera_id


def write_image(database, name, camera, keypoints, descriptors=None):
    """Writes an image with its name, its camera's number and its keypoints: an array of aqorb.keypoint_dtype, or
    rows of x, y, scale and orientation in radians, in OpenCV's pixel coordinates. Returns the image's number."""
    import pycolmap
    image = pycolmap.Image(name=name, camera_id=camera)
    image.image_id = database.write_image(image)
    frame = pycolmap.Frame()
    frame.rig_id = database.read_rig_with_sensor(database.read_camera(camera).sensor_id).rig_id
    frame.add_data_id(image.data_id)
    database.write_frame(frame)
    if keypoints.dtype.names:
        keypoints = np.column_stack([keypoints['pt'], keypoints['size'] / 2, np.radians(keypoints['angle'])])
    rows = np.array(keypoints, np.float32)
    rows[:, :2] += .5  # the centre of the first pixel is (0.5, 0.5) for COLMAP, (0, 0) for OpenCV
    database.write_keypoints(image.image_id, rows)
    if descriptors is not None:
        database.write_descriptors(image.image_id, pycolmap.FeatureDescriptors(
            pycolmap.FeatureExtractorType.UNDEFINED, descriptors))
    return image.image_id


def turn_of(orientation, size):
    """Returns the matrix and the shift from positions in an upright image, of the given width and height, to
    positions in the image of its file, which COLMAP reads without turning. Both are OpenCV's pixel coordinates."""
    matrix = np.array(TURNS[orientation], float)
    shift = -np.minimum(matrix, 0) @ (np.array(size) - 1)
    return matrix, shift


def rows_of(found, turn):
    """Returns the keypoint rows for write_image from the columns of an image's features, in pixels of the file."""
    matrix, shift = turn
    angle = np.radians(found['angle'].astype(float))
    direction = matrix @ [np.cos(angle), np.sin(angle)]
    positions = np.column_stack([found['x'], found['y']]) @ matrix.T + shift
    return np.column_stack([positions, found['size'] / 2, np.arctan2(direction[1], direction[0])])


def geometry_of(inlier_matches, fundamental, turns):
    """Returns COLMAP's two-view geometry of uncalibrated cameras for a fundamental matrix of the upright images, with
    x2^T F x1 = 0 in pixels."""
    import pycolmap
    to_upright = []
    for matrix, shift in turns:
        whole = np.eye(3)
        whole[:2, :2], whole[:2, 2] = matrix, shift + .5
        to_upright.append(np.linalg.inv(whole))
    geometry = pycolmap.TwoViewGeometry(config=pycolmap.TwoViewGeometryConfiguration.UNCALIBRATED,
                                        inlier_matches=inlier_matches.astype(np.uint32))
    if len(fundamental):
        geometry.F = to_upright[1].T @ fundamental.reshape(3, 3) @ to_upright[0]
    return geometry


def export(features, matches, folder, path, camera_mode='AUTO', options=None, refine=True,
           min_inliers=tracks.MIN_INLIERS, threads=1, part_size=tracks.PART_SIZE, progress=None):
    """Writes the features in a folder, and the matches in another folder or None, to a database. Cameras, focal lengths
    and places come from COLMAP's import of the images in `folder`, with its camera_mode and options. The database is
    new, and appears when it is complete. With refine, matches become tracks: the further arguments are those of
    tracks.grow and tracks.build, and progress(label, total) returns a function to call after each pair. Returns the
    numbers of written images and pairs, each omitted image with the reason, and the next step for COLMAP.

    A child process writes, because pycolmap ends its process if a disk is full."""
    if os.path.lexists(path):
        raise InputError(f'{path} exists')
    if matches:
        found = store.Features(features, COLUMNS)
        matched = store.Matches(matches, found)
        matched.check()
        if refine:
            tracks.grow(found, matched, folder, threads, part_size,
                        progress and functools.partial(progress, 'aligning'))
    target = f'{path}.{secrets.token_hex(4)}.unfinished'
    call = json.dumps([features, matches, folder, target, camera_mode, options or {}, refine, min_inliers, threads])
    try:
        reply = answer_of([sys.executable, '-m', 'aqorb_photographs.colmap', call], progress)
        if 'images' not in reply:
            raise InputError(reply.get('error') or f'{path}: COLMAP could not write it: {reply["stopped"]}')
        os.rename(target, path)
    finally:
        for suffix in '', '-wal', '-shm', '-journal':
            if os.path.exists(target + suffix):
                os.remove(target + suffix)
    return reply['images'], reply['pairs'], reply['left_out'], reply['needs']


def answer_of(call, progress):
    """Returns the last answer of a child process, or what it printed last before it failed. Other answers are the
    progress."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(filter(None, sys.path)))
    update, reply = int, {}
    with tempfile.TemporaryFile() as errors, subprocess.Popen(
            call, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors, env=environment) as child:
        for line in child.stdout:
            reply = json.loads(line) if line.startswith(b'{') else reply
            if 'total' in reply:
                update = progress('verifying', reply['total']) if progress else int
            elif 'done' in reply:
                update(reply['done'])
        if child.wait() and 'error' not in reply:
            errors.seek(0)
            lines = errors.read().decode(errors='replace').split('\n')
            reply = {'stopped': ' '.join(filter(None, lines[-9:])) or f'exit code {child.returncode}'}
    return reply


def _export(features, matches, folder, path, camera_mode, options, refine, min_inliers, threads):
    import pycolmap
    if not hasattr(pycolmap.Database, 'read_all_pose_priors'):
        raise InputError(f'pycolmap must be 4 or later, for Python 3.10 or later, got {pycolmap.__version__}')
    features = store.Features(features, COLUMNS)
    features.parameters()
    matches = store.Matches(matches, features) if matches else None
    sizes = list(zip(features.value('width'), features.value('height')))
    orientations = features.value('orientation')
    turns = [turn_of(*one) for one in zip(orientations, sizes)]
    with tempfile.TemporaryDirectory() as scratch, import_images(
            os.path.join(scratch, 'images.db'), folder, camera_mode, options, features.images) as imported:
        cameras = {camera.camera_id: camera for camera in imported.read_all_cameras()}
        images = {image.name: image for image in imported.read_all_images()}
        priors = {prior.corr_data_id.id: prior for prior in imported.read_all_pose_priors()}
    reasons = [why_not(os.path.join(folder, name), images.get(name), cameras, size[::-1] if turned >= 5 else size)
               for name, size, turned in zip(features.images, sizes, orientations)]
    positions, pairs = None, detected_pairs(matches, turns) if matches else ()
    if matches and refine:
        seen = [None if reason else cameras[images[name].camera_id] for name, reason in zip(features.images, reasons)]
        positions, pairs = tracks.build(features, matches, turns, seen, 'camera_params' in options, min_inliers,
                                        threads, report)
        if not any(map(len, positions)):
            raise InputError(f'no two images have {min_inliers} positions that agree on one geometry')
    ids, numbers, count = {}, {}, 0
    with pycolmap.Database.open(path) as database, pycolmap.DatabaseTransaction(database):
        for index, name in enumerate(features.images):
            if reasons[index]:
                continue
            image = images[name]
            if image.camera_id not in numbers:
                numbers[image.camera_id] = write_camera(database, cameras[image.camera_id])
            found = features.of(index)
            rows = (rows_of(found, turns[index]), found['descriptors']) if positions is None else (positions[index],)
            ids[index] = write_image(database, name, numbers[image.camera_id], *rows)
            prior = priors.get(image.image_id)
            if prior and np.isfinite(prior.position).all():
                prior.corr_data_id = database.read_image(ids[index]).data_id
                database.write_pose_prior(prior)
        for first, second, geometry, *matched in pairs:
            if first in ids and second in ids:
                database.write_matches(ids[first], ids[second], *matched or (geometry.inlier_matches,))
                if len(geometry.inlier_matches) >= places.MIN_INLIERS:
                    database.write_two_view_geometry(ids[first], ids[second], geometry)
                count += 1
    needs = ''
    if not matches:
        needs = "COLMAP cannot match these features: run aqorb match, then aqorb colmap with its matches"
    elif positions is None and not (matches.parameters() or {'verified': True})['verified']:
        needs = "the matches are not verified: run COLMAP's geometric_verification"
    left_out = [each for each in zip(features.images, reasons) if each[1]]
    answer(images=len(ids), pairs=count, left_out=left_out, needs=needs)


def detected_pairs(matches, turns):
    """Yields both indices of each pair of images, its two-view geometry, and its matches."""
    for row, (first, second) in enumerate(matches.pairs.tolist()):
        found = matches.of(row)
        rows = np.column_stack([found['index1'], found['index2']]).astype(np.uint32)
        ends = turns[first], turns[second]
        geometry = geometry_of(rows[found['inliers']], found['fundamental'], ends)
        yield first, second, geometry, rows


def import_images(path, folder, camera_mode, options, names):
    """Returns a database with COLMAP's import of images."""
    import pycolmap
    pycolmap.Database.open(path).close()
    if names:
        pycolmap.import_images(path, folder, getattr(pycolmap.CameraMode, camera_mode), names,
                               pycolmap.ImageReaderOptions(options))
    return pycolmap.Database.open(path)


def why_not(path, image, cameras, size):
    """Returns the reason to omit an image, or None."""
    if not os.path.exists(path):
        return 'there is no such file'
    if image is None:
        return 'COLMAP cannot read it, or not with this camera'
    camera = cameras[image.camera_id]
    return None if (camera.width, camera.height) == size else 'its features are of another size'


def report(total):
    """Tells answer_of of the progress."""
    print(json.dumps({'total': total}), flush=True)
    return lambda count=1: print(json.dumps({'done': count}), flush=True)


def answer(**found):
    """Prints the answer for export, and ends the process."""
    print('\n' + json.dumps(found), end='', flush=True)
    os._exit('error' in found)


def _main():
    try:
        _export(*json.loads(sys.argv[1]))
    except Exception as error:  # pycolmap raises errors of any kind
        answer(error=str(error))


if __name__ == '__main__':
    _main()
