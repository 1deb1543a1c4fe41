# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables and figures of Yao et al. 2019 with the values measured here beside the printed ones, and more of them."""

import csv
import os
import time

import cv2
import numpy as np

import images
import measures
from methods import PAPER, TITLES, Method

ABLATIONS = [('aqorb', 'nothing'), ('aqorb:threshold=0', 'fixed FAST threshold 20'),
             ('aqorb:ratio=1', 'no lower threshold in empty cells'),
             ('aqorb:selection=quadtree', "the paper's selection"), ('aqorb:strength=0', 'no strength: rank alone'),
             ('aqorb:radius=0', 'no rank: strength alone'), ('aqorb:octave=0', 'no octave suppression'),
             ('aqorb:subpixel=0', 'whole pixels'), ('aqorb:edge=31', 'border 31'),
             ('aqorb:score=fast', 'FAST score instead of Harris')]
COLUMNS = [('keypoints', 0), ('uniformity', 1), ('occupancy', 3), ('distinct', 1), ('places', 1), ('precision', 3),
           ('auc5', 3)]
COLOURS = {'orb': 'tab:gray', 'orb_slam': 'tab:orange', PAPER: 'tab:blue', 'aqorb': 'black', 'sift': 'tab:green',
           'brisk': 'tab:purple', 'akaze': 'tab:brown', 'surf': 'tab:olive', 'superpoint': 'tab:red'}


METHODS = ['orb', 'orb_slam', PAPER, 'aqorb', 'sift', 'brisk', 'akaze']
RUNS, SEEDS = 15, 15  # of a time measurement, and of a homography's estimation


class Rows(list):
    """Measures, each a dictionary."""

    def mean(self, quantity, **which):
        values = [row[quantity] for row in self if quantity in row and all(row.get(key) == which[key] for key in which)]
        return np.mean(values) if values else np.nan

    def by_image(self, name, method, n):
        return [self.mean('uniformity', set=name, method=method, image=i, n=n) for i in range(1, 7)]

    def by_set(self, quantity, method, n):
        return [self.mean(quantity, set=name, method=method, n=n) for name in images.PAPER_SETS]


def read_paper():
    """{(table, set, method): the uniformity of six images that the paper prints}"""
    names = {'paper': PAPER}
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'paper_tables.csv'), encoding='utf-8') as file:
        return {(row['table'], row['set'], names.get(row['method'], row['method'])):
                [float(row[str(i)] or 'nan') for i in range(1, 7)] for row in csv.DictReader(file)}


def measure_images(rows, name, pictures, method, n, runs):
    """Adds the measures of each image, and returns the features. The time is the median on one thread. B is written in
    Python here, so its times would say nothing."""
    features = []
    for i, image in enumerate(pictures):
        found = method.compute(image, n)
        features.append(found)
        row = dict(set=name, image=i + 1, method=method.name, n=n, keypoints=len(found.keypoints),
                   uniformity=measures.uniformity(found, image), occupancy=measures.occupancy(found, image))
        if runs and method.name != 'orb_slam':
            spent = []
            for _ in range(runs):
                start = time.process_time()
                method.detector.detectAndCompute(image, None)
                spent.append(1e3 * (time.process_time() - start))
            row['time_ms'] = np.median(spent)
        rows.append(row)
    return features


def measure(options):
    """Colour images, as the paper's column A shows that its authors had."""
    rows = Rows()
    methods = [Method(name) for name in METHODS]
    more = [Method(name) for name, _ in ABLATIONS if name not in METHODS] if options.ablation else []
    cv2.setNumThreads(1)
    for name in images.SETS:
        pictures, homographies = images.read_set(options.datasets, name, cv2.IMREAD_COLOR)
        for n in options.n:
            for method in methods + more:
                runs = RUNS if method in methods and n == options.n[0] else 0
                features = measure_images(rows, name, pictures, method, n, runs)
                for i in range(1, 6):
                    points = measures.matched(features[0], features[i], method.norm)
                    correct = measures.agree_with_homography(*points, homographies[i])
                    area = measures.area_under_curve(*points, homographies[i], pictures[0], SEEDS)
                    found = measures.counts(*points, correct, pictures[0])
                    rows.append(dict(set=name, method=method.name, n=n, auc5=area, **found))
    return rows


def cell(value, digits=2):
    return '' if np.isnan(value) else '{:.{}f}'.format(value, digits)


def tables(rows, options):
    """Yields each table's title, head and rows."""
    paper, n = read_paper(), options.n[0]
    for table, name in (('1', 'bikes'), ('2', 'leuven')):
        columns = []
        for method in ('orb', 'orb_slam', PAPER):
            columns += [paper[table, name, method], rows.by_image(name, method, n)]
        columns.append(rows.by_image(name, 'aqorb', n))
        yield ('Table {} ({}): uniformity'.format(table, name),
               ['image', 'A paper', 'A here', 'B paper', 'B here', 'C paper', 'C here', 'as shipped'],
               [[str(i)] + [cell(value) for value in row] for i, *row in zip(range(1, 7), *columns)])
    table = []
    for (number, name, method), values in paper.items():
        for source, each in (('paper', values), ('here', rows.by_image(name, method, n))):
            if number == '3' and not np.isnan(each).any():
                table.append(['{}, {}, {}'.format(name, TITLES.get(method, method), source)]
                             + [cell(value) for value in each + [np.mean(each)]])
    yield 'Table 3: uniformity', ['set, method'] + ['img{}'.format(i) for i in range(1, 7)] + ['mean'], table
    for title, quantity, digits in (('Uniformity by set', 'uniformity', 2), ('CPU time in ms by set', 'time_ms', 2),
                                    ('Occupied share of a 16x12 grid by set', 'occupancy', 3)):
        means = {method: rows.by_set(quantity, method, n) for method in METHODS}
        table = [[TITLES[method]] + [cell(value, digits) for value in each + [np.mean(each)]]
                 for method, each in means.items() if not np.isnan(each).any()]
        yield title, ['method'] + images.PAPER_SETS + ['mean'], table
    titled = {'Means over the six sets': [(name, TITLES[name]) for name in METHODS],
              'Ablation: as shipped but for': ABLATIONS if options.ablation else []}
    for title, methods in titled.items():
        if methods:
            yield (title, ['method', 'n'] + [name for name, _ in COLUMNS],
                   [[words, str(each)] + [cell(rows.mean(quantity, method=method, n=each), digits)
                                          for quantity, digits in COLUMNS]
                    for each in options.n for method, words in methods])


def met(rows, table, name, method, n, images=6):
    """How many of the paper's values of a method are met within 0.3."""
    pairs = list(zip(read_paper()[table, name, method], rows.by_image(name, method, n)))
    return sum(abs(paper - here) <= .3 + 1e-9 for paper, here in pairs[:images])


def claims(rows, options):
    """Rows of what is claimed of the paper's tables: what, asked, here, whether it holds."""
    n = options.n[0]
    found = met(rows, '1', 'bikes', 'orb', n, 4) + met(rows, '2', 'leuven', 'orb', n)
    yield ['column A within 0.3 of the paper: bikes 1 to 4, leuven', '10', str(found), found == 10]
    found = sum(met(rows, '3', name, 'sift', n) for name in images.PAPER_SETS)
    yield ['SIFT within 0.3 of the paper, of 30', 'at least 20', str(found), found >= 20]
    shipped, settings, b = (np.mean(rows.by_set('uniformity', method, n)) for method in ('aqorb', PAPER, 'orb_slam'))
    yield ['uniformity as shipped, mean of five sets', 'at most 147', cell(shipped), shipped <= 147]
    yield ["the same below B's", 'by at least 8', cell(b - shipped), b - shipped >= 8]
    yield ["uniformity with the paper's settings, mean of five sets", 'at most 164.3', cell(settings), settings <= 164.3]
    yield ["the same above B's", 'by at most 5', cell(settings - b), settings - b <= 5]
    for other in ('orb', 'orb_slam'):
        percent = 100 * (rows.mean('distinct', method='aqorb') / rows.mean('distinct', method=other) - 1)
        yield ['distinct correct matches above those of ' + TITLES[other], 'by 15 %', cell(percent, 1) + ' %',
               percent >= 15]


def draw_figures(rows, options):
    """Draws the paper's figures 3, 6 and 8 with its values marked."""
    import matplotlib
    matplotlib.use('Agg')
    import matplotlib.pyplot as plt

    def pictures(number, title, methods):
        figure, axes = plt.subplots(1, len(methods), figsize=(12, 3.2))
        image = images.read_set(options.datasets, 'bikes', cv2.IMREAD_COLOR)[0][0]
        for axis, method in zip(axes, methods):
            keypoints = [cv2.KeyPoint(float(x), float(y), 7) for x, y in
                         Method(method).compute(image, options.n[0]).keypoints['pt']]
            axis.imshow(cv2.drawKeypoints(image, keypoints, None, (0, 255, 0))[:, :, ::-1])
            axis.set_title(TITLES[method], fontsize=10)
            axis.axis('off')
        finish(figure, number, title, 'jpg')

    def finish(figure, number, title, kind):
        figure.suptitle('Figure {}: {}'.format(number, title))
        figure.tight_layout()
        figure.savefig(os.path.join(options.out, 'figure{}.{}'.format(number, kind)), dpi=80)
        plt.close(figure)

    def panels(number, title, methods):
        figure, axes = plt.subplots(2, 3, figsize=(13, 8), sharey=True)
        for axis, name in zip(axes.flat, images.PAPER_SETS):
            printed = {key[2]: values for key, values in read_paper().items() if key[1] == name}
            for method in methods:
                axis.plot(range(1, 7), rows.by_image(name, method, options.n[0]), color=COLOURS[method], marker='o',
                          markersize=4)
                if method in printed:
                    axis.plot(range(1, 7), printed[method], color=COLOURS[method], marker='o', linestyle=':',
                              linewidth=.8, markerfacecolor='none')
            axis.set_title(name)
            axis.set_xlabel('image')
        lines = [plt.Line2D([], [], color=COLOURS[method], label=TITLES.get(method, method)) for method in methods]
        lines.append(plt.Line2D([], [], color='black', linestyle=':', label="the paper's values"))
        axes.flat[-1].axis('off')
        axes.flat[-1].legend(handles=lines, loc='center', frameon=False)
        finish(figure, number, title, 'png')

    pictures(3, '500 keypoints of bikes img1', ['orb', 'orb_slam', PAPER])
    panels(6, 'uniformity u by image, less is more uniform', ['orb', 'orb_slam', PAPER, 'aqorb'])
    panels(8, 'uniformity u by image', [PAPER, 'aqorb', 'surf', 'superpoint', 'sift', 'brisk', 'akaze'])
