#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Measures single frames from outside of aqorb_profile, which only runs them, and prints CSV:

  stages        the nanoseconds of each stage, by OpenCV's trace of one thread
  instructions  the instructions of a frame by stage and function, counted by callgrind
  aarch64       the instructions of a frame under qemu-user, with qemu_count.c compiled as PLUGIN

scripts/performance.sh runs it.
"""

import argparse
import csv
import os
import re
import subprocess
import sys
import tempfile

DETECTORS = {'orb': 'CV_ORB', 'aqorb': 'AQORB'}  # as the harness of perf/ names them
WARM_UP = 3  # frames that aqorb_profile runs before those that count

# Stages and the regions of the trace that are theirs. Whatever selection calls is selection.
REGIONS = {'threshold': 'varianceOverMean', 'pyramid': 'fillLevel', 'FAST, cells, suppression': 'BandSearch::find',
           'Harris': 'harrisResponses', 'ranking': 'LevelDetection::order', 'selection': 'select',
           'orientation': 'orientations', 'position': 'findKeypoints', 'blur': 'approximateBlur',
           'descriptor': 'computeDescriptors'}
# Functions that, with all they call, make up a stage, and functions that they call and that are of another stage.
FUNCTIONS = [
    ('threshold', ['varianceOverMean'], []),
    ('pyramid', ['fillLevel'], []),
    ('FAST, suppression', ['BandSearch::find'], []),
    ('Harris, moments', ['LevelDetection::findStrengths'], []),
    ('ranking', ['LevelDetection::order'], ['LevelDetection::findStrengths']),
    ('selection', ['Frame::select'], []),
    ('orientation, position', ['findKeypoints'], []),
    ('blur', ['approximateBlur'], []),
    ('descriptor', ['computeDescriptors'], []),
]


def command(arguments, image, detector, frames):
    return [arguments.program, '--frames=%d' % frames, '--images=' + image, '--detector=' + detector]


def name_of(image):
    return 'scene ' + image if re.fullmatch(r'\d+x\d+', image) else image


def traced(location):
    """The names of the regions, and for each outermost region the nanoseconds of each region's own, without those
    inside of it, by the names of it and of the regions around it. OpenCV writes l,LOCATION,"FILE",LINE,"NAME",FLAGS to
    one file, and b,THREAD,TIME,LOCATION,REGION and e,THREAD,TIME,LOCATION,REGION,DURATION[,skip=COUNT] to another."""
    with open(location + '.txt', encoding='utf-8') as file:
        names = dict(re.findall(r'^l,(\d+),".*?",\d+,"(.*)",\w+$', file.read(), re.M))
    regions, open_regions, calls = set(), [], []
    with open(location + '-000.txt', encoding='utf-8') as file:
        for line in csv.reader(file):
            if line[0] == 'b':
                if not open_regions:
                    calls.append([])
                # "virtual void cv::A::f(int) const" is cv::A::f; names of blocks stay as they are.
                name = names[line[3]].replace('(anonymous namespace)', '').partition('(')[0].rpartition(' ')[2]
                open_regions.append([name, 0])
                regions.add(name)
            elif line[0] == 'e':
                if len(line) > 6:
                    sys.exit('The trace has not all regions')
                path = [name for name, _ in open_regions]
                duration = int(line[5])
                calls[-1].append((path, duration - open_regions.pop()[1]))
                if open_regions:
                    open_regions[-1][1] += duration
    return regions, [call for call in calls if call[-1][0][0].endswith('::detectAndCompute')]


def stage_of(path):
    """The stage of the innermost region that marks one, but selection if that is around it."""
    stage = 'rest'
    for name in path:
        for words, region in REGIONS.items():
            if stage != 'selection' and (name == region or name.endswith('::' + region)):
                stage = words
    return stage


def stages(arguments, write):
    write('image', 'frame', 'stage', 'ns')
    for image in arguments.images:
        with tempfile.TemporaryDirectory() as folder:
            location = os.path.join(folder, 'trace')
            limits = dict.fromkeys(('OPENCV_TRACE_DEPTH_OPENCV', 'OPENCV_TRACE_MAX_CHILDREN_OPENCV',
                                    'OPENCV_TRACE_MAX_CHILDREN'), '0')  # none
            name = subprocess.run(command(arguments, image, 'aqorb', arguments.frames), check=True, text=True,
                                  env=dict(os.environ, OPENCV_TRACE='1', OPENCV_TRACE_LOCATION=location, **limits),
                                  stdout=subprocess.PIPE).stdout.strip()
            regions, calls = traced(location)
        absent = [r for r in REGIONS.values() if not any(n == r or n.endswith('::' + r) for n in regions)]
        if absent or len(calls) != WARM_UP + arguments.frames:
            sys.exit('In the trace are {} frames; not in it are: {}'.format(len(calls), ', '.join(absent)))
        for frame, call in enumerate(calls[WARM_UP:]):
            times = dict.fromkeys([*REGIONS, 'rest'], 0)
            for path, nanoseconds in call:
                times[stage_of(path)] += nanoseconds
            for stage, nanoseconds in times.items():
                write(name, frame, stage, nanoseconds)


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


def instructions(arguments, write):
    write('image', 'detector', 'kind', 'name', 'instructions')  # of one frame
    for image in arguments.images:
        for detector, name in DETECTORS.items():
            profile = os.path.join(arguments.out, 'callgrind.{}.{}'.format(os.path.basename(image), detector))
            subprocess.run(['valgrind', '--quiet', '--tool=callgrind', '--callgrind-out-file=' + profile,
                            '--toggle-collect=timeFrame*', *command(arguments, image, detector, arguments.frames)],
                           check=True, stdout=subprocess.DEVNULL)
            inclusive, total = annotate(profile, 'yes')

            def instructions_of(functions):
                counts = [c for name, c in inclusive.items() for f in functions if name.endswith('::' + f)]
                if len(counts) < len(functions):
                    sys.exit('Not in the profile: ' + ', '.join(functions))
                return sum(counts)

            rows = [('frame', 'frame', total)]
            if detector == 'aqorb':
                rows += [('stage', stage, instructions_of(functions) - instructions_of(others))
                         for stage, functions, others in FUNCTIONS]
                rows += [('function', *count) for count in annotate(profile, 'no')[0].items()]
            for kind, what, count in rows:
                write(name_of(image), name, kind, what, count / arguments.frames)


def aarch64(arguments, write):
    def count(image, detector, frames):
        """The instructions of the whole program"""
        run = subprocess.run(['qemu-aarch64', '-L', arguments.sysroot, '-plugin', arguments.plugin,
                              *command(arguments, image, detector, frames)],
                             check=True, capture_output=True, text=True)
        counted = re.search(r'^instructions: (\d+)$', run.stderr, re.M)
        return int(counted[1]) if counted else sys.exit('The plugin printed no number: ' + run.stderr)

    write('image', 'detector', 'instructions')  # of one frame
    for image in arguments.images:
        for detector, name in DETECTORS.items():
            # What the program does besides is the same whatever the number of frames is.
            first, more = (count(image, detector, frames) for frames in (1, 1 + arguments.frames))
            write(name_of(image), name, (more - first) / arguments.frames)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('what', choices=['stages', 'instructions', 'aarch64'])
    parser.add_argument('program', help='aqorb_profile')
    parser.add_argument('--images', type=lambda names: names.split(','), default=['640x480'],
                        help='as of aqorb_profile')
    parser.add_argument('--frames', type=int, default=3, help='that count')
    parser.add_argument('--out', default='.', help='folder for what callgrind writes')
    parser.add_argument('--plugin')
    parser.add_argument('--sysroot', help='folder with the libraries of the program')
    arguments = parser.parse_args()
    rows = csv.writer(sys.stdout, lineterminator='\n')
    {'stages': stages, 'instructions': instructions, 'aarch64': aarch64}[arguments.what](
        arguments, lambda *cells: rows.writerow(cells))


if __name__ == '__main__':
    main()
