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
    medians = times.groupby(['image', 'stage'])['ns'].median().unstack()[times['stage'].unique()]
    shares = 100 * medians.div(medians.sum(axis=1), axis=0)  # medians need not add up to that of the frames
    return {'Stages': shares_table('% of a frame', shares.loc[images].T)}


def collection_tables(folder):
    """Ratios are medians of those of one turn, as the speed of a machine varies from turn to turn."""
    times = pandas.read_csv(os.path.join(folder, 'collection.csv'))
    rates = (times['images'] / times['seconds']).groupby([times['repeat'], times['way']]).first().unstack()
    rows = [[way, number(rates[way].median(), 0)] +
            [number((rates[way] / rates[other]).median(), 3) for other in ('1 thread', '2 processes')]
            for way in times['way'].unique()]
    return {'Many images': pandas.DataFrame(rows, columns=['', 'images a second', 'of 1 thread', 'of 2 processes'])}


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
    counts = pandas.read_csv(os.path.join(folder, 'aarch64.csv'))
    table = counts.pivot(index='image', columns='detector', values='instructions').loc[counts['image'].unique()]
    rows = [[image, number(row['CV_ORB'] * 1e-6), number(row['AQORB'] * 1e-6), number(row['CV_ORB'] / row['AQORB'])]
            for image, row in table.iterrows()]
    return {'Instructions on AArch64': pandas.DataFrame(rows, columns=[
        'image', 'cv::ORB, millions', 'AdaptiveQuadtreeORB, millions', 'ratio'])}


def shares_table(head, shares):
    rows = [[name] + [number(share, 1) for share in row] for name, row in shares.iterrows()]
    return pandas.DataFrame(rows, columns=[head] + list(shares.columns))


def short_function(name):
    """'int cv::aqorb::opt_AVX2::scoreRow<cv::aqorb::...>' without the namespaces and the type it returns."""
    return re.sub(r'^\w+ ', '', name.replace('cv::aqorb::', ''))
