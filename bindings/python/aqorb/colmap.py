# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Features and matches in a database of COLMAP. It is written by Python's sqlite3 alone: two SQLite libraries in a
process that have the same file open destroy it, so close the database before pycolmap opens it.

    from aqorb import colmap
    database = colmap.create('scene.db')
    camera = colmap.write_camera(database, width, height)
    first = colmap.write_image(database, 'first.jpg', camera, keypoints1)
    second = colmap.write_image(database, 'second.jpg', camera, keypoints2)
    colmap.write_matches(database, first, second, aqorb.matchArrays(descriptors1, descriptors2)[0])
    colmap.close(database)
    colmap.write_pairs('pairs.txt', [('first.jpg', 'second.jpg')])
    pycolmap.verify_matches('scene.db', 'pairs.txt')

COLMAP has a type of descriptors for SIFT and for a few others. Those of ORB are written without a type: COLMAP neither
reads nor matches them, but keeps them, and aqorb match finds them there."""

import itertools
import os
import sqlite3
import subprocess
import sys

import numpy as np

MODELS = 'SIMPLE_PINHOLE', 'PINHOLE', 'SIMPLE_RADIAL', 'RADIAL', 'OPENCV'  # in the order of COLMAP's numbers
NO_TYPE = -1  # of descriptors
MAX_IMAGES = 2**31 - 1


# Prints the tables of an empty database. It never sees the database that is wanted: as another process it may outlive the
# one that asks, and what goes on with that one's work must not be disturbed.
PRINT_TABLES = """
import os, sqlite3, tempfile, pycolmap
with tempfile.TemporaryDirectory() as folder:
    path = os.path.join(folder, 'empty.db')
    pycolmap.Database.open(path).close()
    database = sqlite3.connect(path)
    print(*database.iterdump(), sep='\\n')
    print(f'PRAGMA user_version = {database.execute("PRAGMA user_version").fetchone()[0]};')
    database.close()
"""


def create(path):
    """Makes a new database and returns it, a sqlite3.Connection. Its tables are those of pycolmap, which makes them in
    another process, because it ends its process where a disk is full."""
    made = subprocess.run([sys.executable, '-c', PRINT_TABLES], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE)
    if made.returncode:
        lines = made.stderr.decode(errors='replace').strip().splitlines()
        raise OSError(f'pycolmap could not make a database: {lines[-1] if lines else "it was ended"}')
    database = open_alone(path)
    database.executescript(made.stdout.decode())
    return database


def open_alone(path):
    """Opens a database that nobody else knows yet, nor goes on with if the process ends before it is closed."""
    database = sqlite3.connect(path)
    database.execute('PRAGMA journal_mode = DELETE')  # not COLMAP's, which leaves a second file
    database.execute('PRAGMA journal_mode = OFF')
    database.execute('PRAGMA synchronous = OFF')
    return database


def close(database):
    """Writes what is not written yet, and closes the database."""
    database.commit()
    database.close()


def write_camera(database, width, height, focal_length=None, model='SIMPLE_RADIAL', params=None):
    """Writes a camera and a rig of this camera alone. Returns the camera's number. The parameters are those of COLMAP's
    model. Without them it is a SIMPLE_RADIAL of the given focal length in pixels. Without that, too, it is COLMAP's
    first guess, 1.2 times the longer side, which COLMAP refines."""
    known = focal_length is not None or params is not None
    if params is None:
        params = focal_length or 1.2 * max(width, height), width / 2, height / 2, 0
    camera = database.execute('INSERT INTO cameras(model, width, height, params, prior_focal_length) '
                              'VALUES (?, ?, ?, ?, ?)', (MODELS.index(model), width, height,
                                                         np.array(params, '<f8').tobytes(), known)).lastrowid
    database.execute('INSERT INTO rigs(ref_sensor_id, ref_sensor_type) VALUES (?, 0)', (camera,))
    return camera


def write_image(database, name, camera, keypoints, descriptors=None):
    """Writes an image of that name, str or bytes, and its keypoints, an array of aqorb.keypoint_dtype or rows of x, y
    and whatever else COLMAP has in a keypoint. Returns the image's number."""
    image = database.execute('INSERT INTO images(name, camera_id) VALUES (CAST(? AS TEXT), ?)',
                             (os.fsencode(name), camera)).lastrowid
    frame = database.execute('INSERT INTO frames(rig_id) SELECT rig_id FROM rigs '
                             'WHERE ref_sensor_id = ? AND ref_sensor_type = 0', (camera,)).lastrowid
    database.execute('INSERT INTO frame_data VALUES (?, ?, ?, 0)', (frame, image, camera))
    if keypoints.dtype.names:
        keypoints = np.column_stack([keypoints['pt'], keypoints['size'] / 2, np.radians(keypoints['angle'])])
    # The centre of the first pixel is (0.5, 0.5) for COLMAP, (0, 0) for OpenCV.
    rows = np.array(keypoints, '<f4')
    rows[:, :2] += .5
    database.execute('INSERT INTO keypoints VALUES (?, ?, ?, ?)', (image, *rows.shape, rows.tobytes()))
    if descriptors is not None:
        database.execute('INSERT INTO descriptors(image_id, type, rows, cols, data) VALUES (?, ?, ?, ?, ?)',
                         (image, NO_TYPE, *descriptors.shape, descriptors.tobytes()))
    return image


def blob_of(image1, image2, pairs):
    """The number of a pair of images, and the columns rows, cols and data of pairs of keypoints."""
    pairs = np.asarray(pairs, '<u4').reshape(-1, 2)
    if image1 > image2:
        image1, image2, pairs = image2, image1, pairs[:, ::-1]
    return MAX_IMAGES * image1 + image2, len(pairs), 2, pairs.tobytes()


def write_matches(database, image1, image2, pairs):
    """Writes the matches of two images, given by their numbers: rows of two indices of keypoints, as aqorb.matchArrays
    returns them. COLMAP is yet to verify them: pycolmap.verify_matches."""
    database.execute('INSERT INTO matches VALUES (?, ?, ?, ?)', blob_of(image1, image2, pairs))


def write_two_view_geometry(database, image1, image2, pairs, F):
    """Writes the matches of two images that agree with the fundamental matrix F, for which x2^T F x1 = 0 in pixels of
    OpenCV. COLMAP takes them as verified, of cameras that are not calibrated."""
    shift = np.array([[1, 0, -.5], [0, 1, -.5], [0, 0, 1]])  # from COLMAP's pixels
    F = shift.T @ np.asarray(F, float) @ shift
    if image1 > image2:
        F = F.T
    uncalibrated = 3
    # NULL where nothing is known: of an E or a pose of zeros COLMAP would make use.
    database.execute('INSERT INTO two_view_geometries(pair_id, rows, cols, data, config, F) VALUES (?, ?, ?, ?, ?, ?)',
                     (*blob_of(image1, image2, pairs), uncalibrated, np.ascontiguousarray(F, '<f8').tobytes()))


def write_pairs(path, pairs):
    """Writes pairs of names of images, str or bytes, as pycolmap.verify_matches reads them: two names a line. They must
    have no white space, at which COLMAP parts them."""
    lines = [[os.fsencode(name) for name in pair] for pair in pairs]
    for name in itertools.chain(*lines):
        if len(name.split()) != 1:
            raise ValueError(f'COLMAP cannot read the name {name!r} in a list of pairs')
    with open(path, 'wb') as file:
        file.writelines(b' '.join(pair) + b'\n' for pair in lines)
