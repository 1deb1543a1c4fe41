# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests evaluation.py on a small run whose tables are worked out by hand."""

import os
import tempfile
import unittest

import evaluation

FILES = {
    'setting.csv': 'name,value\nOpenCV,4.6.0\nCPU features,"SSE, AVX2"\n',
    'methods.csv': 'method,role,text\n'
                   'orb,method,cv::ORB (A)\naqorb,method,ours as shipped\naqorb,ablation,nothing\n'
                   'surf,absent,built without dlib\n',
    'matching.csv': 'set,pair,method,n,matches,correct,distinct,places,precision,repeatability,corner_error\n'
                    'bikes,1-2,orb,500,20,10,4,3,0.5,0.25,1\n'
                    'bikes,1-3,orb,500,20,5,7,4,0.25,0.75,1\n'
                    'bikes/dark,1-2,orb,500,0,0,0,0,0,0,1000000\n',
    'homography.csv': 'set,pair,method,n,seed,corner_error\n'
                      'bikes,1-2,orb,500,1,0\nbikes,1-2,orb,500,2,2.5\n'
                      'bikes,1-3,orb,500,1,1000000\nbikes,1-3,orb,500,2,5\n'
                      'bikes/dark,1-2,orb,500,1,1000000\n',
    'odometry.csv': 'method,n,frame,stereo,matches,inliers,translation_error_m,rotation_error_deg\n'
                    'orb,500,1,100,50,30,0.03,0.3\norb,500,2,100,51,30,0.04,0.4\norb,500,3,100,4,0,,\n',
}


def uniformity():
    """Six images of bikes: 100, 101, ... for cv::ORB, ten less for ours; the last time was not measured."""
    rows = ['set,image,method,n,keypoints,uniformity,occupancy,time_ms']
    for image in range(1, 7):
        time = '' if image == 6 else '8.5'
        rows.append('bikes,{},orb,500,{},{},0.5,{}'.format(image, 490 + image, 99 + image, time))
        rows.append('bikes,{},aqorb,500,500,{},0.75,2'.format(image, 89 + image))
    rows.append('bikes/dark,1,orb,500,7,24.4,0.02,')
    return '\n'.join(rows) + '\n'


class EvaluationTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in dict(FILES, **{'uniformity.csv': uniformity()}).items():
                with open(os.path.join(folder, name), 'w') as file:
                    file.write(text)
            cls.data = evaluation.Evaluation(folder)

    def table(self, function, *arguments):
        """The head and the rows of the tables of a function."""
        lines = []
        for _, table in function(self.data, *arguments):
            lines += [list(table.columns)] + table.values.tolist()
        return lines

    def test_names(self):
        self.assertEqual('SSE, AVX2', self.data.setting['CPU features'])
        self.assertEqual({'surf': 'built without dlib'}, self.data.absent.to_dict())
        self.assertEqual(['bikes'], self.data.sets)
        self.assertEqual([500], self.data.numbers)

    def test_quality(self):
        rows = self.table(evaluation.quality_tables, 'title', '', self.data.methods)
        # AUC@5: (1 + 0.5) / 2 for the first pair, 0 for the second.
        self.assertEqual(['cv::ORB (A)', '500', '494', '102.5', '0.500', '5.5', '3.5', '0.375', '0.500',
                          '0.292', '0.375', '0.562'], rows[1])
        self.assertEqual(['ours as shipped', '500', '500', '92.5', '0.750'] + [''] * 7, rows[2])

    def test_degraded_images_are_apart(self):
        rows = self.table(evaluation.quality_tables, 'title', 'dark', self.data.methods)
        self.assertEqual(['cv::ORB (A)', '500', '7', '24.4', '0.020', '0.0'], rows[1][:6])

    def test_image_by_image(self):
        paper = evaluation.read_paper()
        rows = self.table(evaluation.three_methods_tables, paper, '1', 'bikes')
        self.assertEqual(['1', '210.06', '100.00', '137.55', '', '140.81', '', '90.00'], rows[1])
        times = rows[8:]  # below a head of its own
        self.assertEqual(['5', '8.50', '2.00'], [times[4][0], times[4][2], times[4][7]])
        self.assertEqual(['6', '', '2.00'], [times[5][0], times[5][2], times[5][7]])
        three = self.table(evaluation.five_methods_tables, paper)
        self.assertEqual(['bikes, cv::ORB (A), here'] + ['{}.00'.format(100 + i) for i in range(6)] + ['102.50'],
                         three[1])

    def test_means_need_all_sets(self):
        means = self.data.by_set('uniformity')
        self.assertEqual(102.5, means.loc['orb', 'bikes'])
        self.assertTrue(means['mean'].isna().all())
        self.assertEqual([], self.table(evaluation.claims_tables, evaluation.read_paper()))

    def test_odometry(self):
        rows = self.table(evaluation.odometry_tables)
        # Errors are of the two frames with a motion: sqrt((3^2 + 4^2) / 2) cm.
        self.assertEqual(['cv::ORB (A)', '500', '100', '35', '20', '3.54', '0.3536', '1'], rows[1])
