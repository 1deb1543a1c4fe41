#!/usr/bin/python3
# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Prints the table cv::ORB time / AdaptiveQuadtreeORB time from results of opencv_perf_aqorb.

Each file is one pass (--gtest_output=xml:FILE) with one number of threads. Within a pass the two
detectors of a case are measured one right after the other, so a ratio is taken from the medians of one
pass; the table holds the median of these ratios over the passes.
"""

import argparse
import math
import statistics
import sys
import xml.etree.ElementTree

OPERATIONS = ['detect', 'compute', 'detectAndCompute']
HEADINGS = {'detectAndCompute': 'both'}
# The images whose geometric mean is the aim of doc/performance.md.
REFERENCE_SET = ['bikes', 'leuven', 'bark', 'trees', 'ubc', '640x512', '1920x1080']


def short_name(image):
    """'.../leuven/img1.png' is leuven, 'stitching/a3.png' a3, 'scene_640x480' scene."""
    parts = image.split('/')
    if parts[-1] == 'img1.png':
        return parts[-2]
    return parts[-1].split('.')[0].split('_')[0]


class Results:
    def __init__(self):
        self.rows = {}      # (image, size, n) in the order of the run
        self.threads = []
        # (row, operation, threads) -> a pass each: {detector: (median in ms, keypoints)}
        self.times = {}
        self.samples = set()
        self.skipped = set()
        self.failed = []
        self.setting = ''

    def read(self, path):
        root = xml.etree.ElementTree.parse(path).getroot()
        threads = int(root.get('cv_num_threads'))
        if threads not in self.threads:
            self.threads.append(threads)
        self.setting = 'OpenCV {} ({}), CPU features {}'.format(
            root.get('cv_version'), root.get('cv_parallel_framework', 'no parallel framework'),
            root.get('cv_cpu_features'))

        this_pass = {}
        for case in root.iter('testcase'):
            if case.find('failure') is not None:
                self.failed.append('{} {}'.format(case.get('name'), case.get('value_param')))
                continue
            image, n, detector = (field.strip(' "()') for field in case.get('value_param').split(','))
            properties = {p.get('name'): p.get('value') for p in case.iter('property')}
            if 'median' not in properties:
                self.skipped.add(short_name(image))
                continue
            row = (short_name(image), properties['image_size'], int(n))
            self.rows.setdefault(row)
            self.samples.add(int(properties['samples']))
            milliseconds = 1e3 * float(properties['median']) / float(properties['frequency'])
            key = (row, case.get('name').split('/')[0], threads)
            this_pass.setdefault(key, {})[detector] = (milliseconds, int(properties['keypoints']))
        for key, pair in this_pass.items():
            if len(pair) == 2:  # a filter may have left one of the two out
                self.times.setdefault(key, []).append(pair)

    def ratios(self, row, operation, threads):
        return [p['CV_ORB'][0] / max(p['AQORB'][0], 1e-6)
                for p in self.times.get((row, operation, threads), [])]

    def ratio(self, row, operation, threads):
        ratios = self.ratios(row, operation, threads)
        return statistics.median(ratios) if ratios else None

    def milliseconds(self, row, threads):
        passes = self.times.get((row, 'detectAndCompute', threads))
        if not passes:
            return ''
        return ' / '.join('{:.2f}'.format(statistics.median(p[d][0] for p in passes))
                          for d in ('CV_ORB', 'AQORB'))

    def keypoints(self, row):
        for threads in self.threads:
            passes = self.times.get((row, 'detectAndCompute', threads))
            if passes:
                return '{} / {}'.format(passes[0]['CV_ORB'][1], passes[0]['AQORB'][1])
        return ''

    def spread(self):
        """How far apart the passes' ratios of a case typically are: half the range, relative."""
        spreads = []
        for key in self.times:
            ratios = self.ratios(*key)
            if len(ratios) > 1:
                spreads.append((max(ratios) - min(ratios)) / 2 / statistics.median(ratios))
        return statistics.median(spreads) if spreads else None


def geometric_mean(values):
    return math.exp(sum(math.log(v) for v in values) / len(values))


def table(results):
    columns = [(operation, threads) for operation in OPERATIONS for threads in results.threads]
    columns = [c for c in columns if any(key[1:] == c for key in results.times)]
    header = ['image', 'size', 'n'] + ['{} {}T'.format(HEADINGS.get(c[0], c[0]), c[1]) for c in columns]
    header += ['ms {}T'.format(t) for t in results.threads] + ['keypoints']
    lines = []
    for row in results.rows:
        ratios = [results.ratio(row, *c) for c in columns]
        lines.append(list(map(str, row)) + ['' if r is None else '{:.2f}'.format(r) for r in ratios]
                     + [results.milliseconds(row, t) for t in results.threads]
                     + [results.keypoints(row)])

    def summary(label, function, rows):
        cells = []
        for column in columns:
            ratios = [r for r in (results.ratio(row, *column) for row in rows) if r is not None]
            cells.append('{:.2f}'.format(function(ratios)) if ratios else '')
        if any(cells):
            blank = [''] * (len(header) - len(label) - len(cells))
            lines.append(label + cells + blank)

    rows = list(results.rows)
    summary(['lowest', '', ''], min, rows)
    for n in sorted(set(row[2] for row in rows)):
        summary(['geometric mean', 'all', str(n)], geometric_mean, [r for r in rows if r[2] == n])
    reference = [r for r in rows if r[0] in REFERENCE_SET]
    if set(r[0] for r in reference) == set(REFERENCE_SET):
        summary(['geometric mean', 'reference set', ''], geometric_mean, reference)
    scenes = [r for r in rows if r[0] == 'scene']
    if len(scenes) != len(rows):
        summary(['geometric mean', 'scenes', ''], geometric_mean, scenes)
    summary(['geometric mean', 'all', ''], geometric_mean, rows)

    widths = [max(len(line[i]) for line in lines + [header]) for i in range(len(header))]
    text = []
    for line in [header, ['-' * w for w in widths]] + lines:
        cells = [c.ljust(w) for c, w in zip(line[:2], widths)]
        cells += [c.rjust(w) for c, w in zip(line[2:], widths[2:])]
        text.append('| ' + ' | '.join(cells) + ' |')
    return '\n'.join(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--smoke', action='store_true', help='say that the numbers mean nothing')
    parser.add_argument('files', nargs='+', metavar='FILE', help='XML results, one a pass')
    arguments = parser.parse_args()

    results = Results()
    for path in arguments.files:
        results.read(path)
    if results.failed:
        sys.exit('failed:\n  ' + '\n  '.join(sorted(set(results.failed))))
    not_found = 'Not measured, as not found in OPENCV_TEST_DATA_PATH: {}.'.format(
        ', '.join(sorted(results.skipped)))
    if not results.times:
        sys.exit('No case was measured with both detectors. ' + (not_found if results.skipped else ''))

    if arguments.smoke:
        print('SMOKE RUN: one sample of each case, to show that everything runs. Do not quote these numbers.')
    print('Time of cv::ORB / time of AdaptiveQuadtreeORB, default parameters;'
          ' above 1 AdaptiveQuadtreeORB is faster')
    print()
    print(table(results))
    print()
    print('both: detectAndCompute. T: threads. ms: median time of both, cv::ORB / AdaptiveQuadtreeORB.'
          ' keypoints: found, likewise.')
    print('compute: on the n keypoints of cv::ORB. Reference set: {}.'.format(', '.join(REFERENCE_SET)))
    passes = max(len(p) for p in results.times.values())
    samples = sorted(results.samples)
    print('Median over {} pass{} of the ratio of the medians of {} sample{}.'.format(
        passes, 'es' if passes > 1 else '',
        samples[0] if len(samples) == 1 else '{} to {}'.format(samples[0], samples[-1]),
        '' if samples[-1] == 1 else 's'))
    spread = results.spread()
    if spread is not None:
        print('Between the passes a ratio varied by +-{:.0f} % (median over the cases).'.format(100 * spread))
    print(results.setting)
    if results.skipped:
        print(not_found)


if __name__ == '__main__':
    main()
