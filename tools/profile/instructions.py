#!/usr/bin/python3
# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Counts the instructions of a frame with callgrind and prints tables of them."""

import argparse
import os
import re
import subprocess

DETECTORS = {'orb': 'cv::ORB', 'aqorb': 'AdaptiveQuadtreeORB'}

# Functions that, with all they call, make up a stage.
STAGES = [
    ('threshold', ['varianceOverMean']),
    ('pyramid', ['fillPyramid']),
    ('FAST, suppression', ['findBandCorners', 'suppressCorners']),
    ('Harris', ['harrisResponses']),
    ('quadtree', ['leafPoints', 'BalancedSequence::begin']),
    ('selection', ['FeatureSelector::select']),
    ('orientation, position', ['AdaptiveQuadtreeORBImpl::refine']),
    ('blur', ['approximateBlur']),
    ('descriptor', ['computeDescriptors']),
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


def millions(value):
    return '{:.2f}'.format(value * 1e-6)


def print_table(title, head, rows):
    print('## {}\n\n| {} |'.format(title, ' | '.join(head)))
    print('|---|' + '---:|' * (len(head) - 1))
    for row in rows:
        print('| {} |'.format(' | '.join(row)))
    print()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('program', help='aqorb_profile')
    parser.add_argument('out', help='folder for what callgrind writes')
    parser.add_argument('--images', default='640x480', help='as of aqorb_profile')
    parser.add_argument('--n', type=int, default=1000)
    parser.add_argument('--frames', type=int, default=3, help='to count, after those that warm up')
    arguments = parser.parse_args()
    images = arguments.images.split(',')
    names = [name_of(image) for image in images]

    totals = {}
    stages = {}  # image -> instructions by stage
    kernels = {}
    for image in images:
        for detector in DETECTORS:
            profile = count(arguments.program, arguments.out, image, detector, arguments.n, arguments.frames)
            inclusive, total = annotate(profile, 'yes')
            totals[image, detector] = total / arguments.frames
            if detector != 'aqorb':
                continue
            stages[image] = []
            for stage, functions in STAGES:
                counts = [c for name, c in inclusive.items() for f in functions if name.endswith('::' + f)]
                if len(counts) < len(functions):
                    raise SystemExit('Not in the profile: ' + ', '.join(functions))
                stages[image].append(sum(counts) / arguments.frames)
            kernels[image] = annotate(profile, 'no')[0]

    print_table('Instructions', ['image'] + ['{}, millions'.format(d) for d in DETECTORS.values()] + ['ratio'],
                [[name_of(image)] + [millions(totals[image, d]) for d in DETECTORS] +
                 ['{:.2f}'.format(totals[image, 'orb'] / totals[image, 'aqorb'])] for image in images])

    rows = [[stage] + ['{:.1f}'.format(100 * stages[image][i] / totals[image, 'aqorb']) for image in images]
            for i, (stage, _) in enumerate(STAGES)]
    rows.append(['rest'] + ['{:.1f}'.format(100 - 100 * sum(stages[image]) / totals[image, 'aqorb'])
                            for image in images])
    print_table('Instructions by stage', ['% of a frame'] + names, rows)

    first = kernels[images[0]]
    functions = sorted(first, key=first.get, reverse=True)[:15]
    share = 100 / arguments.frames
    print_table('Instructions by function', ['% of a frame, in the function itself'] + names,
                [[re.sub('^cv::aqorb::(stages::)?', '', name)] +
                 ['{:.1f}'.format(share * kernels[image].get(name, 0) / totals[image, 'aqorb'])
                  for image in images] for name in functions])
    print('One thread, n = {}; valgrind has no AVX-512, so both run their AVX2 code.'.format(arguments.n))


if __name__ == '__main__':
    main()
