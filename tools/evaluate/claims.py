# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What is claimed of the default selection, beside cv::ORB and the paper's selection, and whether it holds."""

import collections
import concurrent.futures
import math
from typing import NamedTuple

import cv2
import numpy as np

import held_out
import images
import measures
from methods import PAPER, Method

ORB = 'orb'
PAPER_SLAM = PAPER + ':octave=0.5'  # for SlamExtractor
STRONGEST = 'aqorb:strength=1000'
SCALES = [.4, .5, .6, .75, 1.5, 2, 2.5]
ROLLS = range(15, 360, 30)  # degrees
ROLLED_SETS = ['bikes', 'leuven', 'trees', 'graf']
OBJECT_NUMBERS = [250, 400, 500, 1000, 2000]  # that of find_obj.py, 400, is not judged
HALF_NUMBERS = {50: .27, 100: .32, 250: .35, 500: None}  # and the share of the weaker half that is asked
SUBJECTS = ['distinct', 'roll', 'scale', 'object', 'start', 'heldout']


def parallel(function, *arguments):
    with concurrent.futures.ThreadPoolExecutor() as pool:
        return list(pool.map(function, *arguments))


class Measurements:
    """The values of a quantity by subject, method and number of features, each with its item, such as its set."""

    def __init__(self):
        self.rows = collections.defaultdict(list)

    def add(self, subject, item, method, n, **quantities):
        for quantity, value in quantities.items():
            self.rows[subject, method, n, quantity].append((item, value))

    def values(self, subject, method, n, quantity, items=None):
        """In the order in which they were measured, the same for all methods."""
        rows = self.rows.get((subject, method, n, quantity), [])
        return np.array([value for item, value in rows if items is None or item in items])

    def mean(self, *which, **more):
        values = self.values(*which, **more)
        return values.mean() if len(values) else math.nan

    def at_scales(self, method, n):
        """The geometric mean over the scales of the mean number of distinct correct matches."""
        return math.exp(np.mean([math.log(self.mean('scale {:g}'.format(scale), method, n, 'distinct'))
                                 for scale in SCALES]))


class Case(NamedTuple):
    """Two images with their true geometry. A view was made from the first image: only matches count that lie where both
    images show the scene."""
    item: str
    first: np.ndarray
    second: np.ndarray
    homography: np.ndarray
    fundamental: np.ndarray = None  # if there is no homography
    is_view: bool = False


def measure_pairs(subject, cases, method, n, results, seeds=0):
    """What the matches of each case are worth. The area under the curve is measured with seeds, and a homography."""
    distinct = {id(image): image for case in cases for image in case[1:3]}
    features = {key: method.compute(image, n) for key, image in distinct.items()}

    def measure(case):
        points = measures.matched(features[id(case.first)], features[id(case.second)], method.norm)
        if case.is_view:
            keep = measures.in_common_part(*points, case.homography, case.first, case.second)
            points = [each[keep] for each in points]
        if case.homography is None:
            return measures.counts(*points, measures.agree_with_fundamental(*points, case.fundamental), case.first)
        found = measures.counts(*points, measures.agree_with_homography(*points, case.homography), case.first)
        if seeds:
            found['auc5'] = measures.area_under_curve(*points, case.homography, case.first, seeds)
        return found

    for case, found in zip(cases, parallel(measure, cases)):
        results.add(subject, case.item, method.name, n, **found)


def measure_start(frames, camera, poses, method, n, results):
    features = [method.compute(frame, n) for frame in frames]
    for step in (1, 10):
        def correct(i, step=step):
            motion = np.linalg.inv(poses[i + step]) @ poses[i]
            return measures.correct_starts(*measures.start_matches(features[i], features[i + step]), camera, motion)
        for found in parallel(correct, range(len(frames) - step)):
            results.add('start', step, method.name, n, correct=found)


def slam_of(name):
    return 'slam' + name[len('aqorb'):] if name.split(':')[0] == 'aqorb' else None


def measure(options):
    results = Measurements()
    methods = [Method(name) for name in dict.fromkeys([ORB, PAPER] + options.methods)]
    sets = {name: images.read_set(options.datasets, name) for name in images.SETS}
    cases = [(method, n) for n in options.n for method in methods]
    if 'distinct' in options.only:
        for name, (pictures, homographies) in sets.items():
            pairs = [Case(name, pictures[0], *other) for other in zip(pictures[1:], homographies[1:])]
            for method, n in cases:
                measure_pairs('sets', pairs, method, n, results, options.seeds)
                for image in pictures:
                    found = method.compute(image, n)
                    results.add('sets', name, method.name, n, uniformity=measures.uniformity(found, image),
                                occupancy=measures.occupancy(found, image))
            scene, weaker = images.with_weaker_half(pictures[0])
            for method in methods:
                for n in HALF_NUMBERS:
                    x = method.compute(scene, n).keypoints['pt'][:, 0]
                    results.add('half', name, method.name, n, share=np.mean(x >= weaker))
        for name in images.PAPER_SETS:
            for image in images.read_set(options.datasets, name, cv2.IMREAD_COLOR)[0]:
                for method in methods:
                    results.add('colour', name, method.name, 500,
                                uniformity=measures.uniformity(method.compute(image, 500), image))
    if 'roll' in options.only:
        for name in ROLLED_SETS:
            image = sets[name][0][0]
            views = [Case(name, image, *images.rolled(image, angle), is_view=True) for angle in ROLLS]
            for method in methods:
                measure_pairs('rolled', views, method, 1000, results)
    if 'scale' in options.only:
        for scale in SCALES:
            views = [Case(name, pictures[0], *images.scaled(pictures[0], scale), is_view=True)
                     for name, (pictures, _) in sets.items()]
            for method, n in cases:
                measure_pairs('scale {:g}'.format(scale), views, method, n, results)
    if 'object' in options.only:
        objects = images.small_objects(options.object, sets)
        for method in methods + [Method(STRONGEST)] * (STRONGEST not in options.methods):
            for n in OBJECT_NUMBERS:
                for name, *pair in objects:
                    found = measures.inliers_on_object(*[method.compute(image, n) for image in pair], method.norm)
                    results.add('object' if name == 'box' else 'drawn object', name, method.name, n, **found)
    if 'start' in options.only:
        sequence = images.read_sequence(options.sequence)
        for name in dict.fromkeys([ORB] + [slam_of(name) for name in [PAPER_SLAM] + options.methods]):
            for n in options.n if name else ():
                measure_start(*sequence, Method(name), n, results)
    if 'heldout' in options.only:
        pairs = [Case(*pair) for pair in held_out.read_pairs(options.heldout)]
        for method, n in cases:
            measure_pairs('held-out', pairs, method, n, results, options.seeds)
    return results


class Judge:
    """Makes the rows of the claims of a method. A row has a bound that is asked for, or only tells."""

    def __init__(self, measured, method):
        self.measured, self.method = measured, method
        self.rows, self.failed = [], []

    def means(self, subject, n, quantity, items=None):
        return [self.measured.mean(subject, name, n, quantity, items) for name in (self.method, ORB, PAPER)]

    def add(self, what, n, values, digits, at_least=None, at_most=None, note=''):
        """A row of the values here, of cv::ORB and of the paper's selection."""
        if math.isnan(values[0]):
            return
        bound, words = (at_most, 'at most') if at_least is None else (at_least, 'at least')
        asked = '' if bound is None else '{} {:.{}f}'.format(words, bound, digits)
        is_met = bound is None or (values[0] <= bound if at_least is None else values[0] >= bound)
        holds = '' if bound is None else 'yes' if is_met else 'no'
        numbers = ['' if math.isnan(value) else '{:.{}f}'.format(value, digits) for value in values]
        self.rows.append([what, str(n or '')] + numbers + [(asked + note).strip(), holds])
        if not is_met:
            self.failed.append(what)

    def mean(self, what, subject, n, quantity, digits, items=None, **bound):
        self.add(what, n, self.means(subject, n, quantity, items), digits, **bound)

    def ratio(self, what, n, here, orb, paper, at_least=None):
        self.add(what, n, [here / orb, 1, paper / orb], 3, at_least)

    def distinct(self, what, subject, n, at_least=None, items=None):
        self.ratio(what, n, *self.means(subject, n, 'distinct', items), at_least)

    def area(self, what, subject, n, is_asked):
        """Homographies must not be worse than those of the paper's selection beyond chance."""
        here, orb, paper = (self.measured.values(subject, name, n, 'auc5') for name in (self.method, ORB, PAPER))
        if not len(here):
            return
        error = (here - paper).std(ddof=1) / math.sqrt(len(here))
        self.add(what, n, [here.mean(), orb.mean(), paper.mean()], 3,
                 at_least=paper.mean() - 2 * error if is_asked else None, note=' (standard error {:.3f})'.format(error))

    def distinct_inliers(self, method):
        return sum(self.measured.mean('object', method, n, 'distinct') for n in OBJECT_NUMBERS if n != 400)


def judge(measured, options, method):
    """The Judge with all claims of a method; what was not measured is left out."""
    judging = Judge(measured, method)
    times = ": distinct correct matches, times cv::ORB's"
    for n in options.n:
        judging.distinct("distinct correct matches, times cv::ORB's", 'sets', n,
                         {500: 1.52, 1000: 1.48, 2000: 1.43}.get(n))
    for n in options.n:
        judging.distinct('the same on graf', 'sets', n, 1.3, ['graf'])
    for n in options.n:
        judging.mean("uniformity u of the paper's sets, grey", 'sets', n, 'uniformity', 2,
                     at_most={500: 145}.get(n), items=images.PAPER_SETS)
    judging.mean("uniformity u of the paper's sets, in colour", 'colour', 500, 'uniformity', 2, at_most=147)
    for quantity, digits, asked in (('occupancy', 3, {500: .67, 1000: .86}),
                                    ('places', 1, {500: 57, 1000: 85, 2000: 108}), ('precision', 3, {})):
        for n in options.n:
            judging.mean(quantity, 'sets', n, quantity, digits, at_least=asked.get(n))
    for n, asked in HALF_NUMBERS.items():
        judging.mean('share of the keypoints in the weaker half', 'half', n, 'share', 3, at_least=asked)
    for n in options.n:
        judging.area('homography AUC@5', 'sets', n, True)
    judging.distinct('rolled' + times, 'rolled', 1000, 1.5)
    judging.mean('rolled: precision', 'rolled', 1000, 'precision', 3)
    for scale in SCALES if 'scale' in options.only else ():
        subject = 'scale {:g}'.format(scale)
        for n in options.n:
            here, orb, paper = judging.means(subject, n, 'distinct')
            judging.ratio(subject + times, n, here, orb, paper, max(1.3, paper / orb))
    for n in options.n if 'scale' in options.only else ():
        judging.ratio('the geometric mean of the scales', n,
                      *(measured.at_scales(name, n) for name in (method, ORB, PAPER)), 1.5)
    orb_inliers = measured.mean('object', ORB, 500, 'inliers')  # 2000 features must have more
    for n in OBJECT_NUMBERS:
        judging.mean('inliers on a small object', 'object', n, 'inliers', 0,
                     at_least={250: 8, 500: 10, 2000: orb_inliers + 1}.get(n))
    for subject, words in (('object', 'a small object'), ('drawn object', 'three that are drawn into photographs')):
        for n in OBJECT_NUMBERS:
            judging.mean('distinct inliers on ' + words, subject, n, 'distinct', 1)
    here, orb, paper, strongest = (judging.distinct_inliers(name) for name in (method, ORB, PAPER, STRONGEST))
    judging.ratio("distinct inliers on a small object, times cv::ORB's", 0, here, orb, paper, .85)
    judging.ratio('the same with StrengthWeight 1000', 0, strongest, orb, math.nan, 1)
    for step, words in ((1, 'the next frame'), (10, 'the frame a second later')):
        for n in options.n:
            values = [measured.mean('start', name, n, 'correct', [step])
                      for name in (slam_of(method), ORB, slam_of(PAPER_SLAM))]
            judging.add('start with one camera: correct matches with ' + words, n, values, 1,
                        at_least=max(values[1:]) if step == 1 else values[2])
    for n in options.n:
        judging.distinct('held-out pairs' + times, 'held-out', n)
        judging.mean('held-out pairs: precision', 'held-out', n, 'precision', 3)
        judging.area('held-out pairs: homography AUC@5', 'held-out', n, False)
    return judging


def rows_by_method(measured, options):
    """What each method reaches on the sets at the first n, at other scales, and on the small object at each n."""
    n = options.n[0]
    for name in options.methods + [PAPER, ORB]:
        means = ['{:.{}f}'.format(measured.mean('sets', name, n, quantity), digits) for quantity, digits in
                 (('uniformity', 1), ('occupancy', 3), ('distinct', 1), ('places', 1), ('precision', 3))]
        inliers = [str(int(measured.mean('object', name, each, 'inliers'))) for each in OBJECT_NUMBERS]
        yield [name] + means + ['{:.1f}'.format(measured.at_scales(name, n)), ' '.join(inliers)]
