# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables of what tools/matching measured: matchers, and pairs of images."""

import glob
import os

import numpy
import pandas

from document import number


def read_all(folder, pattern):
    files = sorted(glob.glob(os.path.join(folder, pattern)))
    if not files:
        raise ValueError('{} has no {}'.format(folder, pattern))
    return pandas.concat([pandas.read_csv(file) for file in files], ignore_index=True)


def medians(times, keys):
    """The medians of the repeats: columns of the keys, in the order of the file, and one for each contender."""
    table = times.groupby(keys + ['contender'], sort=False)['ms'].median().unstack('contender')
    return times[keys].drop_duplicates().merge(table.reset_index(), on=keys)


def chosen(table, **values):
    for key, value in values.items():
        table = table[table[key] == value]
    return table


def fastest_first(times, contender):
    return list(times[times['contender'] == contender].groupby('cpu')['ms'].sum().sort_values().index)


def matching_tables(folder):
    times = read_all(folder, 'matchers-*.csv')
    cpus = fastest_first(times, 'HammingMatcher')
    table = medians(times, ['task', 'cpu', 'n'])
    ghz = pandas.read_csv(os.path.join(folder, 'frequency.csv'))['ghz'][0]
    rows, gains = [], []
    for task in times['task'].unique():
        for cpu in cpus:
            part = chosen(table, task=task, cpu=cpu).set_index('n')
            ratios = part['cv::BFMatcher'] / part['HammingMatcher']
            for n, row in part.iterrows():
                cycles = row['HammingMatcher'] * 1e6 * ghz / n / n if ghz else float('nan')
                rows.append([task, cpu, str(n), number(row['cv::BFMatcher'], 2), number(row['HammingMatcher'], 3),
                             number(ratios[n], 1), number(cycles, 2)])
            gains.append([task, cpu, number(numpy.exp(numpy.log(ratios).mean()), 1)])
    best = chosen(table, task='cross check', cpu=cpus[0]).set_index('n')
    positions = [[str(n)] + [number(row[name], 3) for name in ('HammingMatcher', 'matchArrays', 'matchByPosition')]
                 for n, row in best.iterrows()]
    scaling = pandas.read_csv(os.path.join(folder, 'scaling.csv'))
    by_threads = scaling.groupby(['task', 'n', 'threads'], sort=False)['ms'].median().unstack('threads')
    threads = [[task, str(n), number(row[1], 3), number(row[2], 3), number(row[1] / row[2], 2)]
               for (task, n), row in by_threads.iterrows()]
    program = pandas.concat([read_all(folder, name + '-*.csv').assign(contender=name)
                             for name in ('program', 'preloaded')])
    preloaded = [[row['task'], row['cpu'], str(row['n']), number(row['program'], 2), number(row['preloaded'], 3),
                  number(row['program'] / row['preloaded'], 1)]
                 for _, row in medians(program, ['task', 'cpu', 'n']).iterrows()]
    return {
        'Matchers: preloaded': pandas.DataFrame(preloaded, columns=['cv::BFMatcher', 'CPU', 'n', 'without, ms',
                                                                    'with, ms', 'gain']),
        'Matchers': pandas.DataFrame(rows, columns=['one thread', 'CPU', 'n', 'cv::BFMatcher, ms', 'HammingMatcher, ms',
                                                    'gain', 'cycles for a pair']),
        'Matchers: gain': pandas.DataFrame(gains, columns=['geometric mean', 'CPU', 'gain']),
        'Matchers: positions': pandas.DataFrame(positions, columns=['n', 'HammingMatcher, ms', 'matchArrays, ms',
                                                                    'matchByPosition, ms']),
        'Matchers: threads': pandas.DataFrame(threads, columns=['', 'n', '1 thread, ms', '2 threads, ms', 'gain'])}


def pair_tables(folder):
    times = read_all(folder, 'pairs-*.csv')
    table = medians(times, ['cpu', 'n', 'set'])
    first, middle, last = 'cv::ORB, cv::BFMatcher', 'aqorb, cv::BFMatcher', 'aqorb, HammingMatcher'
    rows = []
    cpus = fastest_first(times, last)
    for cpu in cpus:
        for n in times['n'].unique():
            part = chosen(table, cpu=cpu, n=n).set_index('set')[[first, middle, last]]
            means = numpy.exp(numpy.log(part).mean())
            for name, row in list(part.iterrows()) + [('geometric mean', means)]:
                rows.append([cpu, str(n), name] + [number(row[each], 2) for each in (first, middle, last)] +
                            [number(row[first] / row[each], 1) for each in (middle, last)])
    return {'Pairs of images': pandas.DataFrame(rows, columns=[
        'CPU', 'n', 'set', 'cv::ORB and cv::BFMatcher, ms', 'aqorb and cv::BFMatcher, ms',
        'aqorb and HammingMatcher, ms', 'gain', 'gain with HammingMatcher'])}
