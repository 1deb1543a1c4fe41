#!/usr/bin/env python3

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Keypoints of a camera's or a video's images, with a slider for the threshold. Where there is no display, the same
numbers are printed."""

import argparse
import os
import sys
import time

import cv2 as cv

try:
    import aqorb
except ImportError:
    from cv2 import aqorb

WINDOW = 'aqorb (space: cv.ORB and back; Esc: end)'


def has_display():
    """Some of OpenCV's window systems end the program where there is none."""
    return not sys.platform.startswith('linux') or bool(os.environ.get('DISPLAY') or
                                                        os.environ.get('WAYLAND_DISPLAY'))


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('source', nargs='?', default='0',
                        help='number of a camera, a video or a pattern of images such as frame_%%02d.png (0)')
    parser.add_argument('--nfeatures', type=int, default=1000, help='number of keypoints to ask for (1000)')
    parser.add_argument('--threshold', type=int, default=20,
                        help='FastThreshold to begin with (20, the adaptive threshold as it is)')
    parser.add_argument('--frames', type=int, default=0, help='number of images to stop after (0: at the end)')
    parser.add_argument('--headless', action='store_true', help='print instead of opening a window')
    parser.add_argument('--out', help='picture to write the last image to')
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    capture = cv.VideoCapture(int(arguments.source) if arguments.source.isdecimal() else arguments.source)
    if not capture.isOpened():
        sys.exit(arguments.source + ': cannot be opened')

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
        cv.putText(picture, text, (10, 25), cv.FONT_HERSHEY_SIMPLEX, 0.6, (0, 255, 0), 2, cv.LINE_AA)
        if not window:
            print(text)
            continue
        cv.imshow(WINDOW, picture)
        key = cv.waitKey(1)
        if key == 27:
            break
        if key == ord(' '):
            detectors.reverse()
    if picture is None:
        sys.exit(arguments.source + ': no image')
    if arguments.out and not cv.imwrite(arguments.out, picture):
        sys.exit(arguments.out + ': cannot be written')


if __name__ == '__main__':
    main()
