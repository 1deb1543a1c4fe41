#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Shows the keypoints of AdaptiveQuadtreeORB in the images of a camera or of a video, with a slider for its
threshold. SOURCE is the number of a camera (without it: 0), a video, or a pattern of images such as frame_%02d.png.
The space bar changes to cv.ORB and back, Esc ends."""

import argparse
import os
import sys
import time

import cv2 as cv

from sample import aqorb, write_picture

WINDOW = 'aqorb (space: cv.ORB and back; Esc: end)'
ESC = 27


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--nfeatures', type=int, default=1000)
    parser.add_argument('--threshold', type=int, default=20,
                        help='FastThreshold to begin with: 20 is the adaptive threshold as it is')
    parser.add_argument('--frames', type=int, default=0, help='number of images to stop after; 0: at the end')
    parser.add_argument('--headless', action='store_true', help='print instead of opening a window')
    parser.add_argument('--out', help='picture to write the last image to')
    parser.add_argument('source', nargs='?', default='0', help='a camera, a video, or a pattern of images')
    return parser.parse_args()


def has_display():
    """Whether there is a display. Some of OpenCV's window systems end the program if there is none."""
    return not sys.platform.startswith('linux') or bool(os.environ.get('DISPLAY') or
                                                        os.environ.get('WAYLAND_DISPLAY'))


def open_source(source):
    if source.isdecimal() and len(source) < 6:
        capture = cv.VideoCapture(int(source))
        if not capture.isOpened():
            sys.exit(source + ': there is no such camera; the name of a video is accepted, too')
        return capture
    sample = cv.samples.findFile(source, False, True)  # a file, or one of OpenCV's samples
    if not sample and '%' not in source:
        sys.exit(source + ': there is no such file')
    capture = cv.VideoCapture(sample or source)
    if not capture.isOpened():
        sys.exit(source + ': not a video, nor a pattern of images, that OpenCV can read')
    return capture


def main():
    arguments = parse_arguments()
    capture = open_source(arguments.source)
    detectors = [('AdaptiveQuadtreeORB', aqorb.AdaptiveQuadtreeORB_create(arguments.nfeatures)),
                 ('ORB', cv.ORB_create(arguments.nfeatures))]
    window = has_display() and not arguments.headless
    threshold = arguments.threshold
    if window:
        cv.namedWindow(WINDOW)
        cv.createTrackbar('FastThreshold', WINDOW, threshold, 100, lambda value: None)
    picture = None
    count = 0
    while arguments.frames == 0 or count < arguments.frames:
        found, frame = capture.read()
        if not found:
            break
        count += 1
        if window:
            threshold = cv.getTrackbarPos('FastThreshold', WINDOW)
        name, detector = detectors[0]
        detector.setFastThreshold(threshold)
        start = time.perf_counter()
        keypoints, _ = detector.detectAndCompute(frame, None)
        milliseconds = 1e3 * (time.perf_counter() - start)
        occupied = 100 * aqorb.distributionOccupancy(keypoints, frame.shape[1::-1])
        text = '{}, threshold {}: {} keypoints in {:.0f} % of the cells, {:.1f} ms'.format(
            name, threshold, len(keypoints), occupied, milliseconds)
        picture = cv.drawKeypoints(frame, keypoints, None, (0, 255, 255))
        cv.putText(picture, text, (8, 20), cv.FONT_HERSHEY_SIMPLEX, 0.5, (0, 255, 0), 1, cv.LINE_AA)
        if not window:
            print(text)
            continue
        cv.imshow(WINDOW, picture)
        key = cv.waitKey(30)
        if key == ESC or cv.getWindowProperty(WINDOW, cv.WND_PROP_VISIBLE) < 1:
            break
        if key == ord(' '):
            detectors.reverse()
    if picture is None:
        sys.exit(arguments.source + ': not one image can be read from it')
    if arguments.out:
        write_picture(arguments.out, picture)


if __name__ == '__main__':
    main()
