# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables of what tools/profile measured: where time, memory and instructions go."""

import os
import re

import pandas

from document import build_names, number


def setting_tables(folder):
    setting = pandas.read_csv(os.path.join(folder, 'setting.csv'), dtype=str)
    return {'Setting': setting.set_axis(['', ''], axis=1)}


def stage_tables(folder):
    times = pandas.read_csv(os.path.join(folder, 'stages.csv'))
    images = list(times['image'].unique())

    def of_kind(kind):
        """Times with a row for each image and frame and a column for each name."""
        chosen = times[times['kind'] == kind]
        return chosen.pivot(index=['image', 'frame'], columns='name', values='ns')[list(chosen['name'].unique())]

    stages = medians(of_kind('stage'))
    shares = 100 * stages.div(stages.sum(axis=1), axis=0)  # medians need not add up to that of the frames
    rows = [[stage] + [number(shares.loc[image, stage], 1) for image in images] for stage in stages.columns]
    tables = {'Stages': pandas.DataFrame(rows, columns=['% of a frame'] + images)}

    paths = of_kind('path')
    one = paths['frame 1']
    shares_of_path = medians(100 * paths[['serial 8', 'longest 8']].div(one, axis=0))
    gains = medians(paths[['{} {}'.format(kind, threads) for kind in ('least', 'queue') for threads in (2, 4, 8)]].rdiv(
        one, axis=0))
    rows = [[image, number(shares.loc[image, 'selection'], 1)] +
            [number(share, 1) for share in shares_of_path.loc[image]] + [number(gain) for gain in gains.loc[image]]
            for image in images]
    tables['Critical path'] = pandas.DataFrame(rows, columns=[
        'image', 'selection %', 'serial %', 'longest path %', 'bound, 2 threads', 'bound, 4', 'bound, 8',
        'queue, 2 threads', 'queue, 4', 'queue, 8'])
    return tables


def medians(by_frame):
    return by_frame.groupby(level='image', sort=False).median()


def memory_tables(folder):
    memory = pandas.read_csv(os.path.join(folder, 'memory.csv'))
    values = ['first', 'later', 'kept']
    memory[values] = memory[values].div(memory['pixels'], axis=0)  # a pixel is a byte
    names = dict(build_names(memory['detector']), CV_ORB='cv::ORB')
    detectors = {detector: memory[memory['detector'] == detector].set_index(['image', 'threads'])[values]
                 for detector in names}
    heads = [name + ', ' * bool(name) + head
             for name in names.values() for head in ('first frame', 'later frames', 'kept')]
    rows = [[image, str(threads)] + [number(share) for detector in names
                                     for share in detectors[detector].loc[(image, threads)]]
            for image, threads in detectors['AQORB'].index]
    photographs = memory[~memory['image'].str.startswith('scene ')].groupby(['threads', 'detector'])[values].max()
    largest = [['largest of the photographs', str(threads)] +
               [number(share) for detector in names for share in photographs.loc[(threads, detector)]]
               for threads in photographs.index.unique('threads')]
    return {'Memory': pandas.DataFrame(rows + largest, columns=['image', 'threads'] + heads)}


def instruction_tables(folder):
    counts = pandas.read_csv(os.path.join(folder, 'instructions.csv'))
    images = list(counts['image'].unique())

    def of_kind(kind, detector):
        """Instructions with a row for each name and a column for each image, in the order of the file."""
        chosen = counts[(counts['kind'] == kind) & (counts['detector'] == detector)]
        table = chosen.pivot(index='name', columns='image', values='instructions')
        return table.loc[chosen['name'].unique(), images]

    orbs, ours = of_kind('frame', 'CV_ORB').loc['frame'], of_kind('frame', 'AQORB').loc['frame']
    rows = [[image, number(orbs[image] * 1e-6), number(ours[image] * 1e-6), number(orbs[image] / ours[image])]
            for image in images]
    tables = {'Instructions': pandas.DataFrame(rows, columns=[
        'image', 'cv::ORB, millions', 'AdaptiveQuadtreeORB, millions', 'ratio'])}

    stages = 100 * of_kind('stage', 'AQORB') / ours
    stages.loc['rest'] = 100 - stages.sum()
    tables['Instructions by stage'] = shares_table('% of a frame', stages)

    functions = 100 * of_kind('function', 'AQORB') / ours
    functions = functions.sort_values(images[0], ascending=False).head(15).fillna(0)
    functions.index = functions.index.map(short_function)
    tables['Instructions by function'] = shares_table('% of a frame, in the function itself', functions)
    return tables


def emulated_tables(folder):
    counts = pandas.read_csv(os.path.join(folder, 'instructions.csv'))
    table = counts.pivot(index='image', columns='detector', values='instructions').loc[counts['image'].unique()]
    rows = [[image, number(row['CV_ORB'] * 1e-6), number(row['AQORB'] * 1e-6), number(row['CV_ORB'] / row['AQORB'])]
            for image, row in table.iterrows()]
    return {'Instructions on AArch64': pandas.DataFrame(rows, columns=[
        'image', 'cv::ORB, millions', 'AdaptiveQuadtreeORB, millions', 'ratio'])}


def shares_table(head, shares):
    rows = [[name] + [number(share, 1) for share in row] for name, row in shares.iterrows()]
    return pandas.DataFrame(rows, columns=[head] + list(shares.columns))


def short_function(name):
    """'int cv::aqorb::stages::opt_AVX2::scoreRow<cv::aqorb::...>' without the namespaces and the type it returns."""
    return re.sub(r'^\w+ ', '', re.sub(r'cv::aqorb::|stages::', '', name))
