#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions of a frame with callgrind and prints them as CSV, by image, detector, stage and function."""

import argparse
import csv
import os
import re
import subprocess
import sys

DETECTORS = {'orb': 'CV_ORB', 'aqorb': 'AQORB'}  # as the harness of perf/ names them

# Functions that, with all they call, make up a stage, and functions that they call and that are of another stage.
STAGES = [
    ('threshold', ['varianceOverMean'], []),
    ('pyramid', ['fillLevel'], []),
    ('FAST, suppression', ['BandSearch::find'], []),
    ('Harris, moments', ['LevelDetection::findStrengths'], []),
    ('ranking', ['LevelDetection::orderByRank'], ['LevelDetection::findStrengths']),
    ('selection', ['Frame::select'], []),
    ('orientation, position', ['findKeypoints'], []),
    ('blur', ['approximateBlur'], []),
    ('descriptor', ['computeDescriptors'], []),
]


def annotate(profile, inclusive):
    """{function: instructions} and all of the program, by callgrind_annotate"""
    text = subprocess.run(['callgrind_annotate', '--threshold=100', '--inclusive=' + inclusive, profile],
                          check=True, capture_output=True, text=True).stdout
    functions = {}
    for count, name in re.findall(r'^ *([\d,]+) \([ \d.]+%\) +[^ :]*:(.*?)(?: \[[^]]*\])?$', text, re.M):
        name = name.replace('(anonymous namespace)::', '').split('(')[0]
        functions[name] = functions.get(name, 0) + int(count.replace(',', ''))
    total = re.search(r'^ *([\d,]+) .*PROGRAM TOTALS$', text, re.M)[1]
    return functions, int(total.replace(',', ''))


def count(program, out, image, detector, n, frames):
    profile = os.path.join(out, 'callgrind.{}.{}'.format(os.path.basename(image), detector))
    subprocess.run(['valgrind', '--quiet', '--tool=callgrind', '--callgrind-out-file=' + profile,
                    '--toggle-collect=timeFrame*', program, '--frames=%d' % frames, '--images=' + image,
                    '--detector=' + detector, '--n=%d' % n], check=True)
    return profile


def name_of(image):
    return 'scene ' + image if re.fullmatch(r'\d+x\d+', image) else image


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('program', help='aqorb_profile')
    parser.add_argument('out', help='folder for what callgrind writes')
    parser.add_argument('--images', default='640x480', help='as of aqorb_profile')
    parser.add_argument('--n', type=int, default=1000)
    parser.add_argument('--frames', type=int, default=3, help='to count, after those that warm up')
    arguments = parser.parse_args()

    rows = csv.writer(sys.stdout, lineterminator='\n')
    rows.writerow(['image', 'detector', 'kind', 'name', 'instructions'])  # of one frame
    for image in arguments.images.split(','):
        for detector in DETECTORS:
            profile = count(arguments.program, arguments.out, image, detector, arguments.n, arguments.frames)

            def write(kind, name, instructions):
                rows.writerow([name_of(image), DETECTORS[detector], kind, name, instructions / arguments.frames])

            inclusive, total = annotate(profile, 'yes')
            write('frame', 'frame', total)
            if detector != 'aqorb':
                continue
            def instructions_of(functions):
                counts = [c for name, c in inclusive.items() for f in functions if name.endswith('::' + f)]
                if len(counts) < len(functions):
                    sys.exit('Not in the profile: ' + ', '.join(functions))
                return sum(counts)

            for stage, functions, others in STAGES:
                write('stage', stage, instructions_of(functions) - instructions_of(others))
            for name, instructions in annotate(profile, 'no')[0].items():
                write('function', name, instructions)


if __name__ == '__main__':
    main()
