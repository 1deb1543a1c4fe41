#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Measures what AdaptiveQuadtreeORB's features are worth beside others, and prints Markdown: see doc/reproduction.md.

DATASETS holds the folders bikes, leuven, bark, trees, ubc and graf of the Oxford data (img1..6 and homographies), for
example opencv_extra's testdata/cv/detectors_descriptors_evaluation/images_datasets. A method is orb, orb_slam, sift,
brisk, akaze, aqorb, or aqorb with settings, such as aqorb:strength=1:octave=0. The package aqorb and cv2 are those that
Python finds. Exit codes: 0 all that is asked holds, 3 something does not, 1 an error, 2 bad arguments.
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
from methods import PAPER


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
    if options.dial_table:
        head = ['n = {}'.format(options.n[0]), 'u', 'occupancy', 'distinct', 'places', 'precision', 'distinct at other '
                'scales', 'inliers on the object, n = ' + ' '.join(map(str, claims.OBJECT_NUMBERS))]
        print_table('The dial', head, claims.dial_rows(measured, options))
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    command = commands.add_parser('paper', help="the paper's tables, and its figures 3, 6 and 8")
    command.set_defaults(run=measure_paper)
    command.add_argument('datasets', metavar='DATASETS')
    command.add_argument('--out', default='.', help='folder for the figures')
    command.add_argument('--methods', type=list_of(),
                         default=['orb', 'orb_slam', PAPER, 'aqorb', 'sift', 'brisk', 'akaze'],
                         help='separated by commas; the first four and sift are needed')
    command.add_argument('--n', type=list_of(int), default=[500, 1000, 2000], help='numbers of features')
    command.add_argument('--runs', type=int, default=15, help='repeats of a time measurement')
    command.add_argument('--seeds', type=int, default=15, help="random seeds of a homography's estimation")
    command.add_argument('--ablation', action='store_true', help='also with one ingredient changed')

    command = commands.add_parser('claims', help='what is claimed of the default selection')
    command.set_defaults(run=measure_claims)
    command.add_argument('datasets', metavar='DATASETS')
    command.add_argument('--methods', type=list_of(), default=['aqorb'], help='those to judge')
    command.add_argument('--only', type=list_of(), default=list(claims.SUBJECTS), help=', '.join(claims.SUBJECTS))
    command.add_argument('--short', action='store_true', help='leave out held-out images, and homographies')
    command.add_argument('--dial-table', action='store_true',
                         help='print a row for each method; needs distinct,scale,object')
    command.add_argument('--n', type=list_of(int), default=[500, 1000, 2000], help='numbers of features')
    command.add_argument('--seeds', type=int, default=15, help='random seeds; 0 leaves homographies out')
    command.add_argument('--object', help="folder with box.png and box_in_scene.png of OpenCV's samples")
    command.add_argument('--sequence', help='stereo sequence laid out as KITTI\'s, for the start with one camera')
    command.add_argument('--heldout', help='folder with the unpacked packages that held_out.csv names')

    command = commands.add_parser('refinement', help='what refineMatches gives')
    command.set_defaults(run=print_tables, tables=refinement.tables)
    command.add_argument('datasets', metavar='DATASETS')
    command.add_argument('--n', type=list_of(int), default=[1000], help='numbers of features')

    command = commands.add_parser('poses', help='relative poses by detected, refined and grown matches; needs poselib')
    command.set_defaults(run=print_tables, tables=poses.tables)
    command.add_argument('scenes', metavar='SCENES', help="folder with Strecha's fountain-P11 and entry-P10")
    command.add_argument('--n', type=list_of(int), default=[1000], help='numbers of features')
    command.add_argument('--estimators', type=list_of(), default=list(poses.ESTIMATORS),
                         help="those of the second table (%(default)s)")
    command.add_argument('--sequence', help="sequence laid out as KITTI's, with poses")
    command.add_argument('--elsewhere', action='append', default=[], metavar='FOLDER',
                         help='images of other places, a place in each folder below it; may be repeated')

    for name, text in (('objects', 'how often a known object is located in a scene'),
                       ('verdict', 'how many places of two images agree; needs aqorb_photographs')):
        command = commands.add_parser(name, help=text)
        command.set_defaults(run=print_tables, tables=objects.tables if name == 'objects' else verdict_tables)
        command.add_argument('datasets', metavar='DATASETS')
        command.add_argument('scenes', metavar='SCENES', help="folder with Strecha's fountain-P11 and entry-P10")
        command.add_argument('samples', metavar='SAMPLES', help="folder of OpenCV's sample images")
        command.add_argument('--n', type=list_of(int), default=[500, 1000, 2000] if name == 'objects' else [1000],
                             help='numbers of features')
        command.add_argument('--pairs', type=int, default=400 if name == 'objects' else 1000,
                             help='objects, each with a scene; or photographs of different places (%(default)s)')
        if name == 'objects':
            command.add_argument('--absent', type=int, default=3, help='scenes without each object (%(default)s)')
            command.add_argument('--only', type=list_of(), default=['orb', 'akaze', 'sift', 'aqorb'],
                                 help='detectors, separated by commas')

    command = commands.add_parser('reconstruction', help="COLMAP's reconstructions; needs pycolmap and the command aqorb")
    command.set_defaults(run=print_tables, tables=reconstruction.tables)
    command.add_argument('scenes', metavar='SCENES', help="folder with Strecha's fountain-P11 and entry-P10")
    command.add_argument('--out', default='reconstruction', help='folder for the models, which are measured once')

    command = commands.add_parser('readme', help="README's table")
    command.set_defaults(run=print_tables, tables=lambda options: [('Measured on one thread', readme.HEAD,
                                                                    readme.rows(options))])
    command.add_argument('scenes', metavar='SCENES', help="folder with Strecha's fountain-P11 and entry-P10")
    options = parser.parse_args()
    for subject in options.only if options.command == 'claims' else []:
        if subject not in claims.SUBJECTS:
            parser.error('--only: {} is none of {}'.format(subject, ', '.join(claims.SUBJECTS)))
    if min(getattr(options, 'n', [1]) or [0]) < 1:
        parser.error('--n: numbers above 0, separated by commas')
    try:
        print('aqorb {}, OpenCV {}'.format(aqorb.__version__, cv2.__version__))
        sys.exit(0 if options.run(options) else 3)
    except (OSError, ValueError, AttributeError, cv2.error) as error:
        sys.exit('aqorb_evaluate.py: {}'.format(error))


if __name__ == '__main__':
    main()
