#!/usr/bin/python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Makes the tables and figures of the documents from what was measured.

PART says what FOLDER holds:
  speed         results of opencv_perf_aqorb: AdaptiveQuadtreeORB against cv::ORB, image by image
  scaling       results of opencv_perf_aqorb: growth with the size of the image and with the number of features
  setting       what aqorb_profile --setting printed, as setting.csv
  program       what aqorb_profile --program printed, as program.csv
  stages        what tools/profile/frames.py stages printed, as stages.csv
  matching      what aqorb_matching printed, as matchers-*.csv, scaling.csv and frequency.csv
  pairs         what aqorb_matching --pairs printed, as pairs-*.csv
  collection    what tools/profile/collection.py printed, as collection.csv
  memory        what aqorb_profile --memory printed, as memory.csv
  instructions  what tools/profile/frames.py instructions printed, as instructions.csv
  aarch64       what tools/profile/frames.py aarch64 printed, as aarch64.csv
  evaluation    what aqorb_evaluate wrote
  claims        what aqorb_claims wrote
  figures       the same, to draw the figures in FOLDER

scripts/performance.sh and scripts/reproduce.sh measure and call this program.
"""

import argparse
import importlib
import sys

import document

# The module and its function that make the tables of a part. A module is loaded only when it is needed, as
# only the figures need matplotlib.
PARTS = {
    'speed': ('speed', 'speed_tables'),
    'scaling': ('speed', 'scaling_tables'),
    'setting': ('profiling', 'setting_tables'),
    'program': ('program', 'program_tables'),
    'matching': ('matching', 'matching_tables'),
    'pairs': ('matching', 'pair_tables'),
    'stages': ('profiling', 'stage_tables'),
    'collection': ('profiling', 'collection_tables'),
    'memory': ('profiling', 'memory_tables'),
    'instructions': ('profiling', 'instruction_tables'),
    'aarch64': ('profiling', 'emulated_tables'),
    'evaluation': ('evaluation', 'evaluation_tables'),
    'claims': ('claims', 'claims_tables'),
    'figures': ('evaluation_figures', 'draw_figures'),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('part', metavar='PART', choices=list(PARTS))
    parser.add_argument('folder', metavar='FOLDER')
    parser.add_argument('--doc', metavar='DOCUMENT', action='append', default=[],
                        help='put the tables into this document in place of printing them; may be repeated')
    arguments = parser.parse_args()

    module, function = PARTS[arguments.part]
    try:
        tables = getattr(importlib.import_module(module), function)(arguments.folder)
        for path in arguments.doc:
            print('{}: {}'.format(path, '; '.join(document.update(path, tables)) or 'shows none of these tables'))
    except (OSError, ValueError) as error:
        sys.exit('report.py: {}'.format(error))
    if not arguments.doc:
        print(document.terminal(tables))


if __name__ == '__main__':
    main()
