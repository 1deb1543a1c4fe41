# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables of what aqorb_profile --program measured: frames in a program that does other work, too.

A ratio is taken from the medians of one pass over the images; what the tables show is the median of this ratio over
the passes, and means of such medians. Ratios of another build, which was measured beside, have rows of their own.
"""

import os

import pandas

from document import build_names, number
from speed import geometric_mean

CASES = {'turns': 'in turns', 'cold': 'cold', 'stream': 'stream', 'warm': 'warm'}


def program_tables(folder):
    times = pandas.read_csv(os.path.join(folder, 'program.csv'))
    # OpenCV marks with ? what the CPU has and the process was told not to use.
    has_avx512 = times['cpu'].str.contains(r'AVX512-SKX(?!\?)')
    cpus = times['cpu'].unique()
    times['case'] = times['case'].map(CASES)
    if len(cpus) > 1:
        times.loc[~has_avx512, 'case'] += ', AVX2 only'
    key = ['case', 'threads', 'image', 'n']
    by_pass = times.pivot(index=key + ['pass'], columns='detector', values='ms')
    builds = build_names(by_pass.columns)
    ratios = by_pass[list(builds)].rdiv(by_pass['CV_ORB'], axis=0).groupby(level=key).median()
    in_order = times.drop_duplicates(key).set_index(key).index
    ratios = ratios.loc[in_order].astype(float)
    medians = by_pass.groupby(level=key).median().loc[in_order]
    return {'In a program': summary_table(ratios, builds), 'In a program: cases': case_table(ratios, medians),
            'In a program: notes': notes(times, ratios['AQORB'])}


def summary_table(ratios, builds):
    """Geometric means and the lowest ratios, with a row for each case."""
    threads = list(ratios.index.unique('threads'))
    rows = []
    for case in ratios.index.unique('case'):
        for build, name in builds.items():
            cells = [[], []]
            for count in threads:
                chosen = ratios[build].xs(case, level='case')
                chosen = chosen[chosen.index.get_level_values('threads') == count]
                for row, summary in zip(cells, (geometric_mean, min)):
                    row.append('' if chosen.empty else number(summary(chosen)))
            rows.append([case + ', ' * bool(name) + name] + cells[0] + cells[1])
    heads = [threads_of(count) for count in threads]
    return pandas.DataFrame(rows, columns=['time of cv::ORB / time of AdaptiveQuadtreeORB'] + heads +
                            ['lowest, ' + head for head in heads])


def threads_of(count):
    return '1 thread' if count == 1 else '{} threads'.format(count)


def case_table(ratios, medians):
    """The ratios of this build, with a row for each image and n, and the times in turns with one thread."""
    cases = ratios['AQORB'].unstack(['case', 'threads'])[
        list(ratios.index.droplevel(['image', 'n']).unique())].loc[
        list(ratios.index.droplevel(['case', 'threads']).unique())]
    rows = []
    for (image, n), row in cases.iterrows():
        cells = [image, str(n)] + [number(ratio) for ratio in row]
        for case, count in cases.columns:
            if case == CASES['turns']:
                time = medians.loc[(case, count, image, n)]
                cells.append('{:.2f} / {:.2f}'.format(time['CV_ORB'], time['AQORB']))
        rows.append(cells)
    heads = ['{}, {}T'.format(case, count) for case, count in cases.columns]
    heads += ['ms {}, {}T'.format(case, count) for case, count in cases.columns if case == CASES['turns']]
    return pandas.DataFrame(rows, columns=['image', 'n'] + heads)


def notes(times, ratios):
    """What is to be known of the tables, a sentence or two a line."""
    passes = times['pass'].nunique()
    case, threads, image, n = ratios.idxmin()
    images = times['image'].nunique()
    lines = ['Geometric means over {} image{} and n = {}. A ratio is the median over {} pass{} of the ratio of'.format(
        images, '' if images == 1 else 's', ', '.join(map(str, sorted(times['n'].unique()))), passes,
        '' if passes == 1 else 'es'),
             'the medians. The lowest ratio of all is that of {} and n = {}, {} with {}.'.format(
                 image, n, case, threads_of(threads))]
    for rows, cpu in zip(('', 'In the rows "AVX2 only": '), times['cpu'].unique()):
        lines.append('{}CPU features: {}{}.'.format(rows, cpu, ' (? means disabled)' if '?' in cpu else ''))
    return '\n'.join(lines)
