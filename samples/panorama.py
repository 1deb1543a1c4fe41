#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Stitches two or more overlapping photographs of a turning camera to a panorama.

cv.Stitcher takes no detector in Python, so this program runs its steps one by one."""

import argparse
import sys

import cv2 as cv
import numpy as np

from sample import aqorb, picture_option, read_image, write_picture


def read(name, megapixels=1):
    image = read_image(name, cv.IMREAD_COLOR)
    scale = min(1, (megapixels * 1e6 / image[..., 0].size) ** 0.5)
    return cv.resize(image, None, fx=scale, fy=scale, interpolation=cv.INTER_AREA)


# The package's function also takes the package's detectors. OpenCV's build needs no such function.
compute_image_features = getattr(aqorb, 'computeImageFeatures2', cv.detail.computeImageFeatures2)


def estimate_cameras(features):
    matcher = cv.detail_BestOf2NearestMatcher(False, 0.3)
    matches = matcher.apply2(features)
    if len(cv.detail.leaveBiggestComponent(features, matches, 1)) < len(features):
        sys.exit('the images do not overlap enough')
    found, cameras = cv.detail_HomographyBasedEstimator().apply(features, matches, None)
    if found:
        for camera in cameras:
            camera.R = camera.R.astype(np.float32)
        adjuster = cv.detail_BundleAdjusterRay()
        adjuster.setConfThresh(1)
        found, cameras = adjuster.apply(features, matches, cameras)
    if not found:
        sys.exit('the cameras could not be estimated')
    rotations = cv.detail.waveCorrect([camera.R for camera in cameras], cv.detail.WAVE_CORRECT_HORIZ)
    for camera, rotation in zip(cameras, rotations):
        camera.R = rotation
    return cameras


def compose(images, cameras):
    warper = cv.PyRotationWarper('spherical', float(np.median([camera.focal for camera in cameras])))
    corners, warped, masks = [], [], []
    for image, camera in zip(images, cameras):
        K = camera.K().astype(np.float32)
        corner, picture = warper.warp(image, K, camera.R, cv.INTER_LINEAR, cv.BORDER_REFLECT)
        everywhere = np.full(image.shape[:2], 255, np.uint8)
        corners.append(corner)
        warped.append(picture)
        masks.append(warper.warp(everywhere, K, camera.R, cv.INTER_NEAREST, cv.BORDER_CONSTANT)[1])

    seams = cv.detail.SeamFinder_createDefault(cv.detail.SeamFinder_VORONOI_SEAM)
    seam_masks = seams.find([picture.astype(np.float32) for picture in warped], corners, masks)
    blender = cv.detail_MultiBandBlender()
    blender.prepare(cv.detail.resultRoi(corners=corners, sizes=[picture.shape[1::-1] for picture in warped]))
    for picture, mask, corner in zip(warped, seam_masks, corners):
        blender.feed(picture.astype(np.int16), mask, corner)
    panorama, _ = blender.blend(None, None)
    return cv.convertScaleAbs(np.maximum(panorama, 0))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nfeatures', type=int, default=1500)
    parser.add_argument('--out', type=picture_option, default='panorama.jpg', help='picture to write')
    parser.add_argument('images', nargs='+', metavar='IMAGE', help='two or more, as left.jpg middle.jpg right.jpg')
    arguments = parser.parse_args()
    if len(arguments.images) < 2:
        parser.error('two images or more are needed')
    images = [read(name) for name in arguments.images]
    detector = aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)
    features = [compute_image_features(detector, image) for image in images]
    try:
        panorama = compose(images, estimate_cameras(features))
    except cv.error:  # an assertion, for example with hardly any matches
        panorama = np.empty((0, 0, 3), np.uint8)
    if panorama.size < min(image.size for image in images):  # impossible cameras fold the images to less than one
        sys.exit('the cameras could not be estimated')
    print('{} of {} images stitched, {}x{}'.format(len(images), len(images), *panorama.shape[1::-1]))
    write_picture(arguments.out, panorama)


if __name__ == '__main__':
    main()
