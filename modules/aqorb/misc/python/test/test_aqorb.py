#!/usr/bin/env python

# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

import os
import tempfile

import numpy as np
import cv2 as cv

from tests_common import NewOpenCVTests

aqorb = cv.aqorb


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

    def assertSamePoints(self, expected, found):
        self.assertEqual([k.pt for k in expected], [k.pt for k in found])

    def test_is_a_cv_orb(self):
        self.assertIsInstance(aqorb.AdaptiveQuadtreeORB_create(), cv.ORB)

    def test_is_an_orb(self):
        orb = aqorb.AdaptiveQuadtreeORB_create(700)
        self.assertIsInstance(orb, aqorb.AdaptiveQuadtreeORB)
        self.assertEqual(orb.getDefaultName(), 'Feature2D.AdaptiveQuadtreeORB')
        self.assertEqual(orb.getMaxFeatures(), 700)
        self.assertEqual(orb.defaultNorm(), cv.NORM_HAMMING)
        names = {name for name in dir(cv.ORB) if not name.startswith('_')}
        self.assertEqual(names - set(dir(aqorb.AdaptiveQuadtreeORB)), set())

    def test_one_image(self):
        image = squares()
        orb = aqorb.AdaptiveQuadtreeORB_create(nfeatures=400, nlevels=4)
        keypoints, descriptors = orb.detectAndCompute(image, None)
        self.assertEqual(len(keypoints), 400)
        self.assertEqual((descriptors.shape, descriptors.dtype), ((400, 32), np.uint8))
        detected = orb.detect(image)
        self.assertSamePoints(keypoints, detected)
        np.testing.assert_array_equal(orb.compute(image, detected)[1], descriptors)
        orb.releaseMemory()
        mask = np.zeros_like(image)
        mask[:, :320] = 1
        self.assertTrue(all(k.pt[0] < 320 for k in orb.detect(image, mask)))
        levels = orb.buildPyramid(image)
        self.assertEqual([level.shape[0] for level in levels], [round(480 / 1.2 ** i) for i in range(4)])

    def test_nothing_to_find(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        for image in (None, np.zeros((0, 0), np.uint8), np.zeros((100, 100), np.uint8)):
            keypoints, descriptors = orb.detectAndCompute(image, None)
            self.assertEqual(len(keypoints), 0)
            self.assertIsNone(descriptors)

    def test_several_images(self):
        images = [squares(), squares(200, 300)]
        orb = aqorb.AdaptiveQuadtreeORB_create(100)
        keypoints = orb.detect(images)
        computed, descriptors = orb.compute(images, keypoints)
        for i, image in enumerate(images):
            expected = orb.detectAndCompute(image, None)
            for found in keypoints[i], computed[i]:
                self.assertSamePoints(expected[0], found)
            np.testing.assert_array_equal(descriptors[i], expected[1])
        masks = [np.zeros(images[0].shape, np.uint8), None]
        self.assertEqual([len(k) for k in orb.detect(images, masks)], [0, len(keypoints[1])])

    def test_batch(self):
        images = [squares(), squares(200, 300)]
        orb = aqorb.AdaptiveQuadtreeORB_create(100)
        for image, *found in zip(images, *orb.detectAndComputeBatch(images, None)):
            expected = orb.detectAndCompute(image, None)
            self.assertSamePoints(expected[0], found[0])
            np.testing.assert_array_equal(found[1], expected[1])

    def test_bad_arguments(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        image = squares(100, 100)
        for name, call in (('image', lambda: orb.detect(image.astype(np.float32))),
                           ('mask', lambda: orb.detectAndCompute(image, np.ones((99, 100), np.uint8))),
                           ('patchSize must be ', lambda: orb.setPatchSize(1)),
                           ('WTA_K', lambda: aqorb.AdaptiveQuadtreeORB_create(WTA_K=5)),
                           ('imageSize', lambda: aqorb.distributionUniformity([], (0, 10)))):
            with self.assertRaisesRegex(cv.error, name):
                call()

    def test_properties(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        self.assertEqual(orb.getSelectionType(), aqorb.AdaptiveQuadtreeORB_RANKED_SELECTION)
        for name in [name[3:] for name in dir(orb) if name.startswith('set')]:
            get, set_ = getattr(orb, 'get' + name), getattr(orb, 'set' + name)
            default = get()
            other = not default if isinstance(default, bool) else max(default, 0) + 1
            set_(other)
            self.assertEqual(get(), other, name)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'orb.yml')
            orb.write(path)
            copy = aqorb.AdaptiveQuadtreeORB_create()
            storage = cv.FileStorage(path, cv.FILE_STORAGE_READ)
            copy.read(storage.getFirstTopLevelNode() if storage.getNode('nfeatures').empty()
                      else storage.root())
            storage.release()
        for name in [name for name in dir(orb) if name.startswith('get')]:
            self.assertEqual(getattr(copy, name)(), getattr(orb, name)(), name)

    def test_functions_of_keypoints(self):
        size = (160, 120)
        even = [cv.KeyPoint(x + 5., y + 5., 1.) for y in range(0, 120, 10) for x in range(0, 160, 10)]
        left = [k for k in even if k.pt[0] < 80]
        self.assertLess(aqorb.distributionUniformity(even, size), aqorb.distributionUniformity(left, size))
        self.assertEqual(aqorb.distributionOccupancy(left, size), 0.5)
        self.assertEqual(aqorb.distributionOccupancy(left, size, (1, 1)), 1)
        given = cv.KeyPoint(100.25, 90.5, 7., 12., 0.125, 1, 5)
        kept, = aqorb.retainUniform([given], (640, 480), 1)
        for name in ('pt', 'size', 'angle', 'response', 'octave', 'class_id'):
            self.assertEqual(getattr(kept, name), getattr(given, name), name)
        moved, = aqorb.transformKeypoints([given], np.float64([[1, 0, 3], [0, 1, 0], [0, 0, 1]]))
        self.assertEqual(moved.pt, (103.25, 90.5))
        image = np.full((10, 10), 90, np.uint8)
        image[:, 5:] = 110
        self.assertAlmostEqual(aqorb.adaptiveFastThreshold(image), 100 / 100)  # variance over mean
        self.assertEqual(aqorb.adaptiveFastThreshold(image, np.uint8(image < 100)), 0)

    def test_matching(self):
        descriptors = np.random.RandomState(1).randint(0, 256, (150, 32)).astype(np.uint8)
        query, train = descriptors[:100], descriptors[50:]
        matches = aqorb.HammingMatcher_create(cv.NORM_HAMMING, crossCheck=True).match(query, train)
        expected = [(m.queryIdx, m.trainIdx, m.distance) for m in matches]
        self.assertGreaterEqual(set(expected), {(i + 50, i, 0) for i in range(50)})
        pairs, distances = aqorb.matchArrays(query, train)
        self.assertEqual(np.column_stack([pairs, np.ravel(distances)]).tolist(), [list(m) for m in expected])
        indices, distances = aqorb.knnMatchArrays(query, train, 2)
        self.assertEqual((indices.shape, distances.shape), ((100, 2), (100, 2)))
        keypoints = [cv.KeyPoint(float(i), float(i % 70), 31.) for i in range(150)]
        lines = np.float64([[0, 0, 0], [0, 0, -1], [0, 1, 0]])
        points = np.float32([k.pt for k in keypoints[:100]])
        same = [[i + 50, i] for i in range(50)]
        for pairs, _ in (aqorb.matchGuided(query, keypoints[:100], train, keypoints[50:], lines, 3),
                         aqorb.matchByPosition(query, points, train, keypoints[50:], (0, 0))):
            self.assertEqual(pairs.tolist(), same)

    def test_refinement(self):
        image = cv.GaussianBlur(squares(), (0, 0), 1.5)
        second = image[:, 3:]  # begins three columns later, and its keypoints are a pixel off
        keypoints1 = aqorb.AdaptiveQuadtreeORB_create(500).detect(image)
        keypoints2 = [cv.KeyPoint(k.pt[0] - 2, k.pt[1], k.size, k.angle) for k in keypoints1]
        matches = [cv.DMatch(i, i, 0) for i in range(len(keypoints1))]
        views = image, keypoints1, second, keypoints2
        grown, grown1, grown2 = aqorb.growMatches(*views, matches[::3])[:3]
        self.assertGreater(len(grown), 2 * len(matches[::3]))
        self.assertLess(max(match.queryIdx for match in grown), len(grown1))
        self.assertLess(max(match.trainIdx for match in grown), len(grown2))
        for points in (aqorb.refineMatches(*views, matches)[1:],
                       aqorb.refineMatchesWithDeviations(*views, matches, 0.8)[1:],
                       aqorb.matchImages(image, second, 500)):
            points1, points2 = (np.float32(each).reshape(-1, 2) for each in points[:2])
            self.assertGreater(len(points1), 400)
            self.assertLess(np.median(np.abs(points1 - (3, 0) - points2)), 0.05)


if __name__ == '__main__':
    NewOpenCVTests.bootstrap()
