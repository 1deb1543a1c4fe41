# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Features and matches in a database of COLMAP, by pycolmap.

    import pycolmap
    from aqorb import colmap
    database = pycolmap.Database.open('scene.db')
    first = colmap.write_image(database, 'first.jpg', camera_id, keypoints1)
    second = colmap.write_image(database, 'second.jpg', camera_id, keypoints2)
    colmap.write_matches(database, first, second, aqorb.matchArrays(descriptors1, descriptors2)[0])
    database.close()
    colmap.write_pairs('pairs.txt', [('first.jpg', 'second.jpg')])
    pycolmap.verify_matches('scene.db', 'pairs.txt')

COLMAP has a type of descriptors for SIFT and for a few others. Those of ORB are written without a type: COLMAP neither
reads nor matches them, but keeps them, and aqorb match finds them there."""

import itertools
import os

import numpy as np
import pycolmap


def write_camera(database, width, height, focal_length=None):
    """Writes a camera of the model SIMPLE_RADIAL and a rig of this camera alone. Returns the camera's number. Without a
    focal length in pixels it is COLMAP's first guess, 1.2 times the longer side, which COLMAP refines."""
    camera = pycolmap.Camera.create_from_model_name(
        pycolmap.Camera().camera_id, 'SIMPLE_RADIAL', focal_length or 1.2 * max(width, height), width, height)
    camera.has_prior_focal_length = focal_length is not None
    return add_camera(database, camera)


def add_camera(database, camera):
    """Writes a pycolmap.Camera and a rig of this camera alone. Returns the camera's number."""
    camera.camera_id = database.write_camera(camera)
    rig = pycolmap.Rig()
    rig.add_ref_sensor(camera.sensor_id)
    database.write_rig(rig)
    return camera.camera_id


def write_image(database, name, camera_id, keypoints, descriptors=None):
    """Writes an image of that name, str or bytes, and its keypoints, an array of aqorb.keypoint_dtype or rows of x, y
    and whatever else COLMAP has in a keypoint. Returns the image's number."""
    image = pycolmap.Image(name=name, camera_id=camera_id)
    image.image_id = database.write_image(image)
    frame = pycolmap.Frame(rig_id=database.read_rig_with_sensor(database.read_camera(camera_id).sensor_id).rig_id)
    frame.add_data_id(image.data_id)
    database.write_frame(frame)
    if keypoints.dtype.names:
        keypoints = np.column_stack([keypoints['pt'], keypoints['size'] / 2, np.radians(keypoints['angle'])])
    # The centre of the first pixel is (0.5, 0.5) for COLMAP, (0, 0) for OpenCV.
    rows = np.array(keypoints, np.float32)
    rows[:, :2] += .5
    database.write_keypoints(image.image_id, rows)
    if descriptors is not None:
        kind = pycolmap.FeatureExtractorType.UNDEFINED
        database.write_descriptors(image.image_id, pycolmap.FeatureDescriptors(type=kind, data=descriptors))
    return image.image_id


def write_matches(database, image1, image2, pairs):
    """Writes the matches of two images, given by their numbers: rows of two indices of keypoints, as aqorb.matchArrays
    returns them. COLMAP is yet to verify them: pycolmap.verify_matches."""
    database.write_matches(image1, image2, np.asarray(pairs, np.uint32).reshape(-1, 2))


def write_pairs(path, pairs):
    """Writes pairs of names of images, str or bytes, as pycolmap.verify_matches reads them: two names a line. They must
    have no white space, at which COLMAP parts them."""
    lines = [[os.fsencode(name) for name in pair] for pair in pairs]
    for name in itertools.chain(*lines):
        if len(name.split()) != 1:
            raise ValueError(f'COLMAP cannot read the name {name!r} in a list of pairs')
    with open(path, 'wb') as file:
        file.writelines(b' '.join(pair) + b'\n' for pair in lines)
