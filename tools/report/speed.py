# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables of what opencv_perf_aqorb measured.

Each file is one pass with one number of threads (--gtest_output=xml:FILE). Within a pass the two detectors of a case
are measured one right after the other, so a ratio is taken from the medians of one pass. What the tables show is the
median of this ratio over the passes, and means of such medians, none of them rounded before it is shown.
"""

import glob
import os
import xml.etree.ElementTree

import numpy
import pandas

from document import number

DETECTORS = ['CV_ORB', 'AQORB']
OPERATIONS = ['detect', 'compute', 'detectAndCompute', 'stream']
CASE = ['operation', 'image', 'size', 'n', 'threads']  # what tells cases apart
# The photographs that the aims of doc/performance.md are set for.
REFERENCE_SET = ['bikes', 'leuven', 'bark', 'trees', 'ubc', '640x512', '1920x1080']

GROWTH_REFERENCE = ('640x480', 1000)  # the case that the times of others are relative to


def geometric_mean(ratios):
    """The only mean of ratios that the documents show."""
    ratios = numpy.asarray(ratios, dtype=float)
    if not ratios.size or (ratios <= 0).any():
        raise ValueError('a geometric mean is of positive numbers, at least one: {}'.format(ratios))
    return float(numpy.exp(numpy.log(ratios).mean()))


# Words, operation, threads, numbers of features, what is made of the ratios of the reference set, at least
AIMS = [
    ('detectAndCompute, 1 thread', 'detectAndCompute', 1, (500, 1000, 2000), geometric_mean, 4.0),
    ('the same, lowest of an image and n', 'detectAndCompute', 1, (500, 1000, 2000), min, 2.5),
    ('detectAndCompute, 2 threads', 'detectAndCompute', 2, (500, 1000, 2000), geometric_mean, 6.5),
    ('detect, 1 thread', 'detect', 1, (500, 1000, 2000), geometric_mean, 3.5),
    ('compute of 1000 keypoints, 1 thread', 'compute', 1, (1000,), geometric_mean, 2.5),
]


def short_name(image):
    """'.../leuven/img1.png' is leuven, 'stitching/a3.png' a3, 'scene_640x480' scene."""
    parts = image.split('/')
    if parts[-1] == 'img1.png':
        return parts[-2]
    return parts[-1].split('.')[0].split('_')[0]


class Results:
    """What the files of a folder hold of a fixture, with the columns CASE, pass, detector, ms, keypoints, samples."""

    def __init__(self, folder, fixture):
        rows, failed, skipped = [], set(), set()
        files = sorted(glob.glob(os.path.join(folder, '*.xml')))
        for number_of_pass, path in enumerate(files):
            root = xml.etree.ElementTree.parse(path).getroot()
            self.setting = 'OpenCV {} ({}), CPU features {}'.format(
                root.get('cv_version'), root.get('cv_parallel_framework', 'no parallel framework'),
                root.get('cv_cpu_features'))
            for case in root.iter('testcase'):
                if not case.get('classname').startswith(fixture + '_'):
                    continue
                if case.find('failure') is not None:
                    failed.add('{} {}'.format(case.get('name'), case.get('value_param')))
                    continue
                image, n, detector = (field.strip(' "()') for field in case.get('value_param').split(','))
                properties = {p.get('name'): p.get('value') for p in case.iter('property')}
                if 'median' not in properties:
                    skipped.add(short_name(image))
                    continue
                rows.append({
                    'operation': case.get('name').split('/')[0], 'image': short_name(image),
                    'size': properties['image_size'], 'n': int(n), 'threads': int(root.get('cv_num_threads')),
                    'pass': number_of_pass, 'detector': detector,
                    'ms': 1e3 * float(properties['median']) / float(properties['frequency']),
                    'keypoints': int(properties['keypoints']), 'samples': int(properties['samples'])})
        if failed:
            raise ValueError('failed in {}:\n  {}'.format(folder, '\n  '.join(sorted(failed))))
        self.skipped = sorted(skipped)
        cases = pandas.DataFrame(rows, columns=CASE + ['pass', 'detector', 'ms', 'keypoints', 'samples'])
        # A filter of the harness may have left out one of the two.
        both = cases.groupby(CASE + ['pass'])['detector'].transform('nunique') == len(DETECTORS)
        self.cases = cases[both]
        if self.cases.empty:
            raise ValueError('no case of {} in {} was measured with both detectors. {}'.format(
                fixture, folder, self.not_measured() or '').strip())

    def not_measured(self):
        """A sentence about the images that were not there, or nothing."""
        if not self.skipped:
            return None
        return 'Not measured, as not found in OPENCV_TEST_DATA_PATH: {}.'.format(', '.join(self.skipped))

    def by_pass(self, value):
        """A value by case and pass, in the order of the run, with a column for each detector."""
        table = self.cases.pivot(index=CASE + ['pass'], columns='detector', values=value)
        in_order = self.cases.drop_duplicates(CASE + ['pass']).set_index(CASE + ['pass']).index
        return table.loc[in_order, DETECTORS]

    def by_case(self, value):
        """The medians of a value over the passes, likewise."""
        return self.by_pass(value).groupby(level=CASE, sort=False).median()

    def ratios_by_pass(self):
        times = self.by_pass('ms')
        return times['CV_ORB'] / times['AQORB']

    def ratios(self):
        """Time of cv::ORB / time of AdaptiveQuadtreeORB by case: the median over the passes."""
        return self.ratios_by_pass().groupby(level=CASE, sort=False).median()

    def spread(self):
        """How far apart the ratios of a case typically are: half their range, relative. None for one pass."""
        groups = self.ratios_by_pass().groupby(level=CASE, sort=False)
        spreads = ((groups.max() - groups.min()) / 2 / groups.median())[groups.size() > 1]
        return None if spreads.empty else float(spreads.median())


def speed_tables(folder):
    """Of the cases Features_*: photographs and scenes, with one thread and more."""
    results = Results(folder, 'Features')
    ratios = results.ratios()
    tables = {}
    if set(REFERENCE_SET) <= set(ratios.index.get_level_values('image')):
        tables['Aims'] = aims_table(ratios)
    tables['Against cv::ORB'] = case_table(results, ratios)
    tables['Against cv::ORB: notes'] = notes(results)
    return tables


def choose(ratios, **values):
    """The ratios of the cases whose levels have these values, or one of them."""
    chosen = pandas.Series(True, ratios.index)
    for level, value in values.items():
        chosen &= ratios.index.get_level_values(level).isin(value if isinstance(value, (list, tuple)) else [value])
    return ratios[chosen]


def aims_table(ratios):
    rows = []
    for words, operation, threads, numbers, summary, aim in AIMS:
        chosen = choose(ratios, operation=operation, threads=threads, n=numbers, image=REFERENCE_SET)
        if chosen.empty:  # measured with other numbers of threads or features
            continue
        ratio = summary(chosen)
        rows.append([words, 'at least {:.1f}'.format(aim), number(ratio), 'yes' if ratio >= aim else 'no'])
    return pandas.DataFrame(rows, columns=['time of cv::ORB / time of AdaptiveQuadtreeORB, reference set', 'aim',
                                           'here', 'reached'])


def case_table(results, ratios):
    """A row for each image and n, and below them the lowest ratios and the means."""
    times, keypoints = results.by_case('ms'), results.by_case('keypoints')
    threads = list(ratios.index.unique('threads'))
    measured = ratios.index.droplevel(['image', 'size', 'n']).unique()
    columns = [(operation, t) for operation in OPERATIONS for t in threads if (operation, t) in measured]
    rows = []
    for row in ratios.index.droplevel(['operation', 'threads']).unique():
        cells = list(map(str, row)) + [number(ratios.get((operation, *row, t))) for operation, t in columns]
        whole = [('detectAndCompute', *row, t) for t in threads]
        cells += [pair(times.loc[case], '{:.2f}') if case in times.index else '' for case in whole]
        found = [case for case in whole if case in keypoints.index]
        cells.append(pair(keypoints.loc[found[0]], '{:.0f}') if found else '')
        rows.append(cells)

    def summarise(label, summary, chosen):
        cells = []
        for operation, t in columns:
            column = choose(chosen, operation=operation, threads=t)
            cells.append('' if column.empty else number(summary(column)))
        if any(cells):
            rows.append(label + cells + [''] * (len(threads) + 1))

    images = set(ratios.index.unique('image'))
    summarise(['lowest', '', ''], min, ratios)
    for n in sorted(ratios.index.unique('n')):
        summarise(['geometric mean', 'all', str(n)], geometric_mean, choose(ratios, n=n))
    if set(REFERENCE_SET) <= images:
        summarise(['geometric mean', 'reference set', ''], geometric_mean, choose(ratios, image=REFERENCE_SET))
    if images != {'scene'}:
        summarise(['geometric mean', 'scenes', ''], geometric_mean, choose(ratios, image='scene'))
    summarise(['geometric mean', 'all', ''], geometric_mean, ratios)

    heads = ['image', 'size', 'n'] + ['{} {}T'.format(operation, t) for operation, t in columns]
    return pandas.DataFrame(rows, columns=heads + ['ms {}T'.format(t) for t in threads] + ['keypoints'])


def pair(values, form):
    """A value of cv::ORB / that of AdaptiveQuadtreeORB."""
    return ' / '.join(form.format(values[detector]) for detector in DETECTORS)


def notes(results):
    """What is to be known of the table, a sentence or two a line."""
    passes = int(results.by_pass('ms').groupby(level=CASE).size().max())
    samples = sorted(results.cases['samples'].unique())
    lines = [
        'Time of `cv::ORB` / time of `AdaptiveQuadtreeORB`, both with default parameters; above 1',
        '`AdaptiveQuadtreeORB` is faster. 1T and 2T: one thread and two. ms: the median times of detectAndCompute,',
        '`cv::ORB` / `AdaptiveQuadtreeORB`. keypoints: how many each of them found. compute is given the keypoints',
        'that `cv::ORB` finds. stream: detectAndCompute of different frames, with 16 MB of other memory touched',
        'between them. Reference set: {}.'.format(', '.join(REFERENCE_SET)),
        'A ratio is the median over {} pass{} of the ratio of the medians of {} sample{}.'.format(
            passes, '' if passes == 1 else 'es',
            samples[0] if len(samples) == 1 else '{} to {}'.format(samples[0], samples[-1]),
            '' if samples[-1] == 1 else 's')]
    spread = results.spread()
    if spread is not None:
        lines.append('Between the passes it varied by {} (median over the cases).'.format(
            number(100 * spread, 0, ' %')))
    lines.append(results.setting + '.')
    if results.skipped:
        lines.append(results.not_measured())
    return '\n'.join(lines)


def scaling_tables(folder):
    """Of the cases Scaling_*: scenes of all sizes, each with all numbers of features, one thread."""
    results = Results(folder, 'Scaling')
    is_grid = results.cases['image'] == 'dots'
    results.cases.loc[is_grid, 'size'] = 'dot grid ' + results.cases['size']
    if set(results.cases['threads']) != {1}:
        raise ValueError('{}: scaling is measured with one thread'.format(folder))
    dropped = ['operation', 'image', 'threads']
    ratios = results.ratios().droplevel(dropped)
    keypoints = results.by_case('keypoints').droplevel(dropped)

    def growth(detector):
        # Both times are of one pass, so that a change of the machine's speed between passes does not matter.
        by_pass = results.by_pass('ms').droplevel(dropped)[detector].unstack('pass')
        return by_pass.div(by_pass.loc[GROWTH_REFERENCE], axis=1).median(axis=1)

    def relative(value):
        return number(value, 2 if value < 9.95 else 1)

    def table(cell):
        rows = []
        for size in ratios.index.unique('size'):
            row = [size]
            for n in ratios.index.unique('n'):
                if (size, n) not in ratios.index:
                    row.append('')
                    continue
                fewer = keypoints.loc[(size, n), 'AQORB'] < n  # there are not more corners
                row.append(cell((size, n)) + ('*' if fewer else ''))
            rows.append(row)
        return pandas.DataFrame(rows, columns=['size'] + ['n = {}'.format(n) for n in ratios.index.unique('n')])

    tables = {'Speed by size and n': table(lambda case: number(ratios.loc[case]))}
    if GROWTH_REFERENCE in ratios.index:
        ours, orbs = growth('AQORB'), growth('CV_ORB')
        tables['Growth'] = table(lambda case: '{} ({})'.format(relative(ours.loc[case]), relative(orbs.loc[case])))
    return tables
