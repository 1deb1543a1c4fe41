#!/usr/bin/env python

# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.

import os
import tempfile
import unittest

import numpy as np
import cv2 as cv

try:
    from tests_common import NewOpenCVTests
except ImportError:  # outside of OpenCV's source tree

    class NewOpenCVTests(unittest.TestCase):
        bootstrap = staticmethod(unittest.main)


def squares(rows=480, cols=640):
    """A grey image full of corners: squares of random place, size and brightness."""
    rng = np.random.RandomState(1)
    image = np.full((rows, cols), 128, np.uint8)
    for _ in range(1500):
        side = rng.randint(5, 30)
        x, y = rng.randint(0, cols), rng.randint(0, rows)
        image[y:y + side, x:x + side] = rng.randint(0, 256)
    return image


class aqorb_test(NewOpenCVTests):

    def test_is_an_orb(self):
        orb = cv.aqorb.AdaptiveQuadtreeORB_create(700)
        self.assertIsInstance(orb, cv.aqorb.AdaptiveQuadtreeORB)
        self.assertIsInstance(orb, cv.ORB)
        self.assertIsInstance(orb, cv.Feature2D)
        self.assertEqual(orb.getDefaultName(), 'Feature2D.AdaptiveQuadtreeORB')
        self.assertEqual(orb.getMaxFeatures(), 700)
        self.assertEqual(orb.descriptorSize(), 32)
        self.assertEqual(orb.defaultNorm(), cv.NORM_HAMMING)
        self.assertFalse(orb.empty())

    def test_detect_and_compute(self):
        image = squares()
        orb = cv.aqorb.AdaptiveQuadtreeORB_create(nfeatures=400)
        keypoints, descriptors = orb.detectAndCompute(image, None)
        self.assertEqual(len(keypoints), 400)
        self.assertEqual(descriptors.shape, (400, 32))
        self.assertEqual(descriptors.dtype, np.uint8)

        detected = orb.detect(image)
        self.assertEqual([k.pt for k in detected], [k.pt for k in keypoints])
        computed, again = orb.compute(image, detected)
        self.assertEqual(len(computed), 400)
        np.testing.assert_array_equal(again, descriptors)

    def test_mask(self):
        image = squares()
        mask = np.zeros_like(image)
        mask[:, :320] = 1
        keypoints = cv.aqorb.AdaptiveQuadtreeORB_create().detect(image, mask)
        self.assertGreater(len(keypoints), 0)
        self.assertTrue(all(k.pt[0] < 320 for k in keypoints))

    def test_properties(self):
        orb = cv.aqorb.AdaptiveQuadtreeORB_create()
        for name, default, other in (('AdaptiveThreshold', True, False), ('MinThresholdRatio', 4, 2.5),
                                     ('CellSize', 35, 50), ('MaxDepth', -1, 3),
                                     ('OctaveSuppression', 0.5, 0), ('SubPixel', True, False),
                                     ('EdgeThreshold', 16, 31), ('FastThreshold', 20, 7)):
            get, set_ = getattr(orb, 'get' + name), getattr(orb, 'set' + name)
            self.assertEqual(get(), default, name)
            set_(other)
            self.assertEqual(get(), other, name)
        with self.assertRaisesRegex(cv.error, 'cellSize'):
            orb.setCellSize(1)
        self.assertEqual(orb.getCellSize(), 50)

    def test_write_and_read(self):
        orb = cv.aqorb.AdaptiveQuadtreeORB_create(123, 1.5, 4)
        orb.setMaxDepth(2)
        handle, path = tempfile.mkstemp(suffix='.yml')
        os.close(handle)
        try:
            orb.write(path)
            other = cv.aqorb.AdaptiveQuadtreeORB_create()
            storage = cv.FileStorage(path, cv.FILE_STORAGE_READ)
            other.read(storage.getFirstTopLevelNode() if storage.getNode('nfeatures').empty()
                       else storage.root())
            storage.release()
        finally:
            os.remove(path)
        self.assertEqual(other.getMaxFeatures(), 123)
        self.assertEqual(other.getScaleFactor(), 1.5)
        self.assertEqual(other.getNLevels(), 4)
        self.assertEqual(other.getMaxDepth(), 2)

    def test_adaptive_fast_threshold(self):
        image = np.full((10, 10), 90, np.uint8)
        image[:, 5:] = 110
        self.assertAlmostEqual(cv.aqorb.adaptiveFastThreshold(image), 100 / 100)  # variance over mean
        mask = np.zeros_like(image)
        mask[:, :5] = 255
        self.assertEqual(cv.aqorb.adaptiveFastThreshold(image, mask), 0)

    def test_distribution(self):
        size = (160, 120)
        even = [cv.KeyPoint(x + 5., y + 5., 1.) for y in range(0, 120, 10) for x in range(0, 160, 10)]
        left = [k for k in even if k.pt[0] < 80]
        self.assertLess(cv.aqorb.distributionUniformity(even, size),
                        cv.aqorb.distributionUniformity(left, size))
        self.assertEqual(cv.aqorb.distributionOccupancy(even, size), 1)
        self.assertEqual(cv.aqorb.distributionOccupancy(left, size), 0.5)
        self.assertEqual(cv.aqorb.distributionOccupancy(left, size, (1, 1)), 1)

    def test_retain_uniform(self):
        # A strong cluster and three weak points elsewhere: every corner of the image is kept.
        cluster = [cv.KeyPoint(10. + i, 10., 1., -1, 100.) for i in range(20)]
        far = [cv.KeyPoint(x, y, 1., -1, 1.) for x, y in ((90., 10.), (10., 90.), (90., 90.))]
        kept = cv.aqorb.retainUniform(cluster + far, (100, 100), 4)
        self.assertEqual(len(kept), 4)
        self.assertEqual({(k.pt[0] > 50, k.pt[1] > 50) for k in kept},
                         {(False, False), (True, False), (False, True), (True, True)})


if __name__ == '__main__':
    NewOpenCVTests.bootstrap()
