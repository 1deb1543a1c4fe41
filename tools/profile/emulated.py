#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions of a frame under qemu-user and prints them as CSV, by image and detector."""

import argparse
import csv
import re
import subprocess
import sys

from instructions import DETECTORS, name_of

FRAMES = 2  # which the counts are taken of


def count(arguments, image, detector, frames):
    """The instructions of the whole program"""
    run = subprocess.run([arguments.emulator, '-L', arguments.sysroot, '-plugin', arguments.plugin, arguments.program,
                          '--frames=%d' % frames, '--images=' + image, '--detector=' + detector],
                         check=True, stderr=subprocess.PIPE, text=True)
    counted = re.search(r'^instructions: (\d+)$', run.stderr, re.M)
    if not counted:
        sys.exit('The plugin printed no number: ' + run.stderr)
    return int(counted[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('plugin', help='qemu_count.c, compiled')
    parser.add_argument('sysroot', help='folder with the libraries of the program')
    parser.add_argument('program', help='aqorb_profile')
    parser.add_argument('--emulator', default='qemu-aarch64')
    parser.add_argument('--images', default='640x480', help='as of aqorb_profile')
    arguments = parser.parse_args()

    rows = csv.writer(sys.stdout, lineterminator='\n')
    rows.writerow(['image', 'detector', 'instructions'])  # of one frame
    for image in arguments.images.split(','):
        for detector in DETECTORS:
            # What the program does besides is the same whatever the number of frames is.
            first, more = (count(arguments, image, detector, frames) for frames in (1, 1 + FRAMES))
            rows.writerow([name_of(image), DETECTORS[detector], (more - first) / FRAMES])
            sys.stdout.flush()


if __name__ == '__main__':
    main()
