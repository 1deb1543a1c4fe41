# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables of doc/reproduction.md from the CSV files that aqorb_evaluate wrote.

They are the tables of Yao et al. 2019 with the values measured here beside the printed ones, what is claimed of
them, and the measures beyond the paper. The functions that read the files serve evaluation_figures.py, too.
"""

import os

import numpy as np
import pandas as pd

PAPER_SETS = ['bikes', 'leuven', 'bark', 'trees', 'ubc']
IMAGES = range(1, 7)
DEGRADATIONS = ['', 'dark', 'gamma', 'noise', 'blur', 'shrunk', 'enlarged']


class Evaluation:
    """What one run of aqorb_evaluate measured.

    methods    titles by method, in the order of the run
    ablations  by method: what the ablation leaves out
    absent     by method: why it was not measured
    numbers    of features that were asked for; the first is the paper's
    features, matching, homography, odometry  the measures, one row each
    """

    def __init__(self, folder):
        def read(name):
            return pd.read_csv(os.path.join(folder, name), keep_default_na=False, na_values=[''])

        self.setting = read('setting.csv').set_index('name')['value']
        named = read('methods.csv').drop_duplicates()
        self.methods, self.ablations, self.absent = (
            named[named['role'] == role].set_index('method')['text'] for role in ('method', 'ablation', 'absent'))
        self.features = split_set(read('uniformity.csv'))
        self.matching = split_set(read('matching.csv'))
        self.homography = split_set(read('homography.csv'))
        odometry = os.path.join(folder, 'odometry.csv')
        self.odometry = read('odometry.csv') if os.path.exists(odometry) else None
        self.numbers = list(self.features['n'].unique())
        self.sets = list(self.features.loc[self.features['degradation'] == '', 'set'].unique())

    def paper_features(self):
        """The rows that the paper has, too: plain images of its sets and its number of features."""
        rows = self.features
        return rows[rows['set'].isin(PAPER_SETS) & (rows['degradation'] == '') & (rows['n'] == self.numbers[0])]

    def by_image(self, quantity):
        """A series of a quantity by set, method and image, of paper_features."""
        return self.paper_features().groupby(['set', 'method', 'image'])[quantity].mean()

    def by_set(self, quantity):
        """A frame of means by method (rows) and the paper's sets (columns) with the mean of these means."""
        means = self.by_image(quantity).groupby(level=['method', 'set']).mean().unstack('set')
        means = means.reindex(index=self.methods.index, columns=PAPER_SETS)
        means['mean'] = means.mean(axis=1, skipna=False)
        return means

    def area_under_curve(self, limit):
        """Of each pair of images, method and n: the area under the curve of the share of homographies whose error is
        below a limit, for limits from 0 to this one; 1 is perfect."""
        rows = self.homography
        score = (1 - rows['corner_error'] / limit).clip(lower=0)
        return score.groupby([rows[key] for key in ('set', 'degradation', 'pair', 'method', 'n')]).mean()


def split_set(rows):
    """Splits the name of a set of degraded images, such as bikes/dark, in two columns."""
    parts = rows['set'].str.partition('/')
    return rows.assign(set=parts[0], degradation=parts[2])


def read_paper():
    """The paper's numbers: a series by table, set, image, method and quantity."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'paper_tables.csv')
    rows = pd.read_csv(path, dtype={'table': str}).set_index(['table', 'set', 'method', 'quantity'])
    return rows.rename_axis(columns='image').stack().reorder_levels(['table', 'set', 'image', 'method', 'quantity'])


def printed(paper, table, set_name, method, quantity):
    """The paper's numbers of a method by image, not a number where it has none."""
    return [paper.get((table, set_name, str(image), method, quantity), np.nan) for image in IMAGES]


def cell(value, form='{:.2f}'):
    return '' if pd.isna(value) else form.format(value)


def titled(title, head, rows):
    """A title and its table."""
    return title, pd.DataFrame(rows, columns=head)


def three_methods_tables(data, paper, table, set_name):
    """Tables 1 and 2: A, B and C by image."""
    head = ['image', 'A paper', 'A here', 'B paper', 'B here', 'C paper', 'C here', 'as shipped']
    for quantity, words in (('uniformity', 'uniformity'), ('time_ms', 'CPU time in ms')):
        here = data.by_image(quantity)
        columns = []
        for method in ('orb', 'orb_slam', 'paper', 'aqorb'):
            if method != 'aqorb':
                columns.append(printed(paper, table, set_name, method, quantity))
            columns.append([here.get((set_name, method, image), np.nan) for image in IMAGES])
        yield titled('Table {} ({}): {}'.format(table, set_name, words), head,
                     [[str(image)] + [cell(value) for value in row] for image, *row in zip(IMAGES, *columns)])


def five_methods_tables(data, paper):
    """Table 3: methods that the paper has there by image and set, its rows above ours."""
    here = data.by_image('uniformity')
    rows = []
    for set_name in PAPER_SETS:
        for method, title in data.methods.items():
            theirs = printed(paper, '3', set_name, method, 'uniformity')
            ours = [here.get((set_name, method, image), np.nan) for image in IMAGES]
            for values, source in ((theirs, 'paper'), (ours, 'here')):
                if not np.isnan(theirs + values).any():
                    rows.append([', '.join((set_name, title, source))]
                                + [cell(value) for value in values + [sum(value / len(IMAGES) for value in values)]])
    yield titled('Table 3: uniformity', ['set, method'] + ['img{}'.format(i) for i in IMAGES] + ['mean'], rows)


def means_by_set_tables(data, paper):
    """Figures 6 to 8 in numbers."""
    head = ['method'] + PAPER_SETS + ['mean']
    for title, quantity, form in (('Uniformity by set', 'uniformity', '{:.2f}'),
                                  ('Occupied share of a 16x12 grid by set', 'occupancy', '{:.3f}'),
                                  ('CPU time in ms by set', 'time_ms', '{:.2f}')):
        means = data.by_set(quantity)
        yield titled(title, head, [[data.methods[method]] + [cell(value, form) for value in row]
                                   for method, row in zip(means.index, means.values)])

    times = data.by_set('time_ms').reindex(['orb', 'orb_slam', 'paper'])
    a, b, c = times.values
    less = [paper['text', name, 'mean', 'paper', 'percent_less_time_than_orb_slam'] for name in PAPER_SETS]
    rows = [('less than B, %, paper', less + [np.nan]), ('less than B, %, here', 100 * (1 - c / b)),
            ('B over C', b / c), ('A over C', a / c)]
    yield titled('Times of C', head, [[title] + [cell(value) for value in values] for title, values in rows])


def met(data, paper, table, set_name, method, images=IMAGES):
    """How many of the paper's values of a method are met within 0.3."""
    here = data.by_image('uniformity')
    values = dict(zip(IMAGES, printed(paper, table, set_name, method, 'uniformity')))
    return sum(abs(values[image] - here[set_name, method, image]) <= 0.3 + 1e-9 for image in images)


def claims_tables(data, paper):
    """What is claimed, and whether it holds in this run."""
    uniformity = data.by_set('uniformity')
    needed = ['orb', 'orb_slam', 'paper', 'aqorb', 'sift']
    if uniformity.reindex(needed).isna().any(axis=None):
        return  # not everything that is needed was measured
    rows = []

    def claim(what, asked, here, holds):
        rows.append([what, asked, str(here), 'yes' if holds else 'no'])

    a = met(data, paper, '1', 'bikes', 'orb', range(1, 5)) + met(data, paper, '2', 'leuven', 'orb')
    claim('column A within 0.3 of the paper: bikes 1 to 4, leuven', '10 of 10', '{} of 10'.format(a), a == 10)
    sift = sum(met(data, paper, '3', name, 'sift') for name in PAPER_SETS)
    claim('SIFT within 0.3 of the paper', '20 of 30', '{} of 30'.format(sift), sift >= 20)

    shipped, settings, b = uniformity['mean'][['aqorb', 'paper', 'orb_slam']]
    claim('uniformity as shipped, mean of five sets', 'at most 154', cell(shipped), shipped <= 154)
    claim("the same below B's", 'by at least 8', cell(b - shipped), b - shipped >= 8)
    of_sets = uniformity[PAPER_SETS]
    below = int((of_sets.loc['aqorb'] < of_sets.loc['orb_slam']).sum())
    claim('sets on which as shipped is below B', 'at least 4', below, below >= 4)
    others = of_sets.reindex(['sift', 'surf', 'brisk'])
    below = int((~(others <= of_sets.loc['aqorb'])).all().sum())  # a method that is absent does not count
    claim('sets on which it is below SIFT, SURF and BRISK', '5', below, below == 5)
    claim("uniformity with the paper's settings", "at most B's " + cell(b), cell(settings), settings <= b)

    plain = data.matching[data.matching['degradation'] == '']
    distinct = plain.groupby('method')['distinct'].mean()
    for other in ('orb', 'orb_slam'):
        percent = 100 * (distinct['aqorb'] / distinct[other] - 1)
        claim('distinct correct matches above {}, mean over n and sets'.format(data.methods[other]), 'by 15 %',
              cell(percent, '{:.1f} %'), percent >= 15)

    # By pair of images: the mean over n. The error is that of the difference as it varies between pairs.
    area = data.area_under_curve(5).xs('', level='degradation').groupby(level=['method', 'set', 'pair']).mean()
    ours, theirs = area['aqorb'], area['orb_slam']
    error = (ours - theirs).std() / np.sqrt(len(ours))
    claim('homography AUC@5, mean over n and sets', "at least B's " + cell(theirs.mean(), '{:.3f}'),
          cell(ours.mean(), '{:.3f}') + cell(error, ' (standard error of the difference {:.3f})'),
          ours.mean() >= theirs.mean())

    a, b, c = data.by_set('time_ms')['mean'][['orb', 'orb_slam', 'paper']]
    claim('time of A over time of C, mean of five sets', 'above 1', cell(a / c), c < a)
    claim('time of B over time of C', 'at least 5', cell(b / c), b >= 5 * c)
    yield titled('What is claimed', ['', 'asked', 'here', 'holds'], rows)


def quality_tables(data, title, degradation, methods):
    """Means over all sets of what a frame and a pair of images come to. methods: their titles by name."""
    key = ['method', 'n']
    features = data.features[data.features['degradation'] == degradation].groupby(key)
    matching = data.matching[data.matching['degradation'] == degradation].groupby(key)
    columns = [(features['keypoints'].mean(), '{:.0f}'), (features['uniformity'].mean(), '{:.1f}'),
               (features['occupancy'].mean(), '{:.3f}'), (matching['distinct'].mean(), '{:.1f}'),
               (matching['places'].mean(), '{:.1f}'), (matching['precision'].mean(), '{:.3f}'),
               (matching['repeatability'].mean(), '{:.3f}')]
    for limit in (3, 5, 10):
        area = data.area_under_curve(limit).xs(degradation, level='degradation')
        columns.append((area.groupby(level=key).mean(), '{:.3f}'))
    yield titled(title, ['method', 'n', 'keypoints', 'u', 'occupancy', 'distinct', 'places', 'precision',
                         'repeatability', 'AUC@3', 'AUC@5', 'AUC@10'],
                 [[words, str(n)] + [cell(values.get((method, n)), form) for values, form in columns]
                  for n in data.numbers for method, words in methods.items()])


def distinct_by_set_tables(data):
    plain = data.matching[data.matching['degradation'] == '']
    means = plain.groupby(['method', 'set'])['distinct'].mean()
    yield titled('Distinct correct matches by set, mean over n', ['method'] + data.sets,
                 [[title] + [cell(means.get((method, name)), '{:.1f}') for name in data.sets]
                  for method, title in data.methods.items()])


def odometry_tables(data):
    rows = []
    for n in data.numbers:
        for method, title in data.methods.items():
            steps = data.odometry[(data.odometry['method'] == method) & (data.odometry['n'] == n)]
            metres, degrees = (np.sqrt((steps[column] ** 2).mean())
                               for column in ('translation_error_m', 'rotation_error_deg'))
            rows.append([title, str(n)]
                        + [cell(steps[column].mean(), '{:.0f}') for column in ('stereo', 'matches', 'inliers')]
                        + [cell(100 * metres), cell(degrees, '{:.4f}'),
                           str(steps['translation_error_m'].isna().sum())])
    yield titled('Stereo odometry, from frame to frame',
                 ['method', 'n', 'stereo points', 'matches', 'inliers', 'translation error, cm, RMS',
                  'rotation error, degrees, RMS', 'frames without motion'], rows)


def evaluation_tables(folder):
    """All tables of a run by title."""
    data, paper = Evaluation(folder), read_paper()
    lines = ['Measured by aqorb_evaluate with OpenCV {}, {}.'.format(
        data.setting['OpenCV'], data.setting['CPU features'])]
    lines += ['Absent: {} ({}).'.format(method, reason) for method, reason in data.absent.items()]
    tables = {'Setting': '\n'.join(lines)}
    tables.update(three_methods_tables(data, paper, '1', 'bikes'))
    tables.update(three_methods_tables(data, paper, '2', 'leuven'))
    tables.update(five_methods_tables(data, paper))
    tables.update(means_by_set_tables(data, paper))
    tables.update(claims_tables(data, paper))
    for degradation in DEGRADATIONS:
        if degradation in data.features['degradation'].values:
            title = ', '.join(filter(None, ('Means over all sets', degradation)))
            tables.update(quality_tables(data, title, degradation, data.methods))
    tables.update(distinct_by_set_tables(data))
    if not data.ablations.empty:
        tables.update(quality_tables(data, 'Ablation: as shipped but for', '', data.ablations))
    if data.odometry is not None:
        tables.update(odometry_tables(data))
    return tables
