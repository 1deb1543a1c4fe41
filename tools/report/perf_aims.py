#!/usr/bin/python3
# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Prints which aims the table of scripts/perf.sh reaches, a file of whose output is the argument."""

import sys

from perf_table import REFERENCE_SET, geometric_mean

# Words, column of the table, numbers of features, what is taken of the ratios, at least
AIMS = [
    ('detectAndCompute, 1 thread', 'both 1T', (500, 1000, 2000), geometric_mean, 4.0),
    ('the same, lowest of an image and n', 'both 1T', (500, 1000, 2000), min, 2.5),
    ('detectAndCompute, 2 threads', 'both 2T', (500, 1000, 2000), geometric_mean, 6.5),
    ('detect, 1 thread', 'detect 1T', (500, 1000, 2000), geometric_mean, 3.5),
    ('compute of 1000 keypoints, 1 thread', 'compute 1T', (1000,), geometric_mean, 2.5),
]


def main():
    with open(sys.argv[1]) as file:
        rows = [[cell.strip() for cell in line.strip('| \n').split('|')] for line in file if line[0] == '|']
    head = rows[0]
    rows = [row for row in rows if row[0] in REFERENCE_SET]
    if {row[0] for row in rows} != set(REFERENCE_SET):
        return  # without the photographs there is nothing to compare
    print('## Aims\n\n| time of cv::ORB / time of AdaptiveQuadtreeORB, reference set | aim | here | reached |')
    print('|---|---:|---:|---:|')
    for words, column, numbers, function, aim in AIMS:
        if column not in head:  # perf.sh was asked for other numbers of threads
            continue
        ratios = [float(row[head.index(column)]) for row in rows if int(row[2]) in numbers]
        ratio = function(ratios)
        print('| {} | at least {:.1f} | {:.2f} | {} |'.format(words, aim, ratio, 'yes' if ratio >= aim else 'no'))
    print()


if __name__ == '__main__':
    main()
