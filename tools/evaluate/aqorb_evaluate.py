#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Measures what AdaptiveQuadtreeORB's features are worth beside others, and prints Markdown: see doc/reproduction.md.

DATASETS holds the folders bikes, leuven, bark, trees, ubc and graf of the Oxford data (img1..6 and homographies), for
example opencv_extra's testdata/cv/detectors_descriptors_evaluation/images_datasets. SCENES holds Strecha's fountain-P11
and entry-P10. A method is orb, orb_slam, sift, brisk, akaze, aqorb, or aqorb with settings, such as
aqorb:strength=1:octave=0. The package aqorb and cv2 are those that Python finds. Exit codes: 0 all that is asked holds,
3 something does not, 1 an error, 2 bad arguments.
"""

import argparse
import os
import sys

import aqorb
import cv2

import claims
import objects
import paper
import poses
import readme
import reconstruction
import refinement


def print_table(title, head, rows):
    print('\n{}\n'.format(title))
    print('| {} |\n|{}'.format(' | '.join(head), '---|' + '---:|' * (len(head) - 1)))
    for row in rows:
        print('| {} |'.format(' | '.join(row)))
    sys.stdout.flush()


def list_of(kind=str):
    return lambda text: [kind(part) for part in text.split(',') if part]


def measure_paper(options):
    os.makedirs(options.out, exist_ok=True)
    rows = paper.measure(options)
    for table in paper.tables(rows, options):
        print_table(*table)
    judged = list(paper.claims(rows, options))
    print_table('What is claimed of the tables', ['', 'asked', 'here', 'holds'],
                [row[:3] + ['yes' if row[3] else 'no'] for row in judged])
    paper.draw_figures(rows, options)
    return all(row[3] for row in judged)


def measure_claims(options):
    if options.short:
        options.only, options.seeds = ['distinct', 'roll', 'scale', 'object', 'start'], 0
    for subject, name in (('object', 'object'), ('start', 'sequence'), ('heldout', 'heldout')):
        if subject in options.only and not getattr(options, name):
            print('{} is left out: --{} is not given'.format(subject, name), file=sys.stderr)
            options.only.remove(subject)
    measured = claims.measure(options)
    if options.by_method:
        head = ['n = {}'.format(options.n[0]), 'u', 'occupancy', 'distinct', 'places', 'precision', 'distinct at other '
                'scales', 'inliers on the object, n = ' + ' '.join(map(str, claims.OBJECT_NUMBERS))]
        print_table('By method', head, claims.rows_by_method(measured, options))
        return True
    failed = []
    for method in options.methods:
        judged = claims.judge(measured, options, method)
        print_table(method, ['', 'n', 'here', 'cv::ORB', "the paper's", 'asked', 'holds'], judged.rows)
        failed += judged.failed
    return not failed


def verdict_tables(options):
    import verdict  # only this command needs the package aqorb_photographs
    return verdict.tables(options)


def print_tables(options):
    for title, head, rows in options.tables(options):
        print_table(title, head, rows)
    return True


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)

    def add(name, text, folders, n=None, run=print_tables, **defaults):
        command = commands.add_parser(name, help=text)
        command.set_defaults(run=run, **defaults)
        for folder in folders.split():
            command.add_argument(folder.lower(), metavar=folder)
        if n:
            command.add_argument('--n', type=list_of(int), default=n, help='numbers of features')
        return command

    several = [500, 1000, 2000]
    command = add('paper', "the paper's tables, and its figures 3, 6 and 8", 'DATASETS', several, measure_paper)
    command.add_argument('--out', default='.', help='folder for the figures')
    command.add_argument('--ablation', action='store_true', help='also with one ingredient changed')

    command = add('claims', 'what is claimed of the default selection', 'DATASETS', several, measure_claims)
    command.add_argument('--methods', type=list_of(), default=['aqorb'], help='those to judge')
    command.add_argument('--only', type=list_of(), default=list(claims.SUBJECTS), help=', '.join(claims.SUBJECTS))
    command.add_argument('--short', action='store_true', help='leave out held-out images, and homographies')
    command.add_argument('--by-method', action='store_true',
                         help='print a row for each method; needs distinct,scale,object')
    command.add_argument('--seeds', type=int, default=15, help='random seeds; 0 leaves homographies out')
    command.add_argument('--object', help="folder with box.png and box_in_scene.png of OpenCV's samples")
    command.add_argument('--sequence', help='stereo sequence laid out as KITTI\'s, for the start with one camera')
    command.add_argument('--heldout', help='folder with the unpacked packages that held_out.csv names')

    add('refinement', 'what refineMatches gives', 'DATASETS', [1000], tables=refinement.tables)
    command = add('poses', 'relative poses by detected, refined and grown matches; needs poselib', 'SCENES', [1000],
                  tables=poses.tables)
    command.add_argument('--sequence', help="sequence laid out as KITTI's, with poses")
    command.add_argument('--elsewhere', action='append', default=[], metavar='FOLDER',
                         help='images of other places, a place in each folder below it; may be repeated')
    command = add('objects', 'how often a known object is located in a scene', 'DATASETS SCENES SAMPLES', several,
                  tables=objects.tables)
    command.add_argument('--pairs', type=int, default=400, help='objects, each with a scene (%(default)s)')
    command = add('verdict', 'how many places of two images agree; needs aqorb_photographs', 'DATASETS SCENES SAMPLES',
                  [1000], tables=verdict_tables)
    command.add_argument('--pairs', type=int, default=1000, help='photographs of different places (%(default)s)')
    command = add('reconstruction', "COLMAP's reconstructions; needs pycolmap and the command aqorb", 'SCENES',
                  tables=reconstruction.tables)
    command.add_argument('--out', default='reconstruction', help='folder for the models, which are measured once')
    add('readme', "README's table", 'SCENES', tables=readme.tables)
    options = parser.parse_args()
    if not set(getattr(options, 'only', [])) <= set(claims.SUBJECTS):
        parser.error('--only: there are ' + ', '.join(claims.SUBJECTS))
    if min(getattr(options, 'n', [1]) or [0]) < 1:
        parser.error('--n: numbers above 0, separated by commas')
    return options


def main():
    options = arguments()
    try:
        print('aqorb {}, OpenCV {}'.format(aqorb.__version__, cv2.__version__))
        sys.exit(0 if options.run(options) else 3)
    except (OSError, ValueError, AttributeError, cv2.error) as error:
        sys.exit('aqorb_evaluate.py: {}'.format(error))


if __name__ == '__main__':
    main()
