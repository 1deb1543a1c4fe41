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

    def test_is_a_cv_orb(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        self.assertIsInstance(orb, cv.ORB)
        self.assertIsInstance(orb, cv.Feature2D)

    def test_is_an_orb(self):
        orb = aqorb.AdaptiveQuadtreeORB_create(700)
        self.assertIsInstance(orb, aqorb.AdaptiveQuadtreeORB)
        self.assertEqual(orb.getDefaultName(), 'Feature2D.AdaptiveQuadtreeORB')
        self.assertEqual(orb.getMaxFeatures(), 700)
        self.assertEqual(orb.descriptorSize(), 32)
        self.assertEqual(orb.defaultNorm(), cv.NORM_HAMMING)
        self.assertFalse(orb.empty())

    def test_detect_and_compute(self):
        image = squares()
        orb = aqorb.AdaptiveQuadtreeORB_create(nfeatures=400)
        keypoints, descriptors = orb.detectAndCompute(image, None)
        self.assertEqual(len(keypoints), 400)
        self.assertEqual(descriptors.shape, (400, 32))
        self.assertEqual(descriptors.dtype, np.uint8)

        detected = orb.detect(image)
        self.assertEqual([k.pt for k in detected], [k.pt for k in keypoints])
        computed, again = orb.compute(image, detected)
        self.assertEqual(len(computed), 400)
        np.testing.assert_array_equal(again, descriptors)

    def test_keypoints_keep_their_fields(self):
        image = squares()
        orb = aqorb.AdaptiveQuadtreeORB_create(50)
        for keypoint in orb.detect(image):
            self.assertIs(type(keypoint), cv.KeyPoint)
            self.assertTrue(0 <= keypoint.angle < 360)
            self.assertGreater(keypoint.response, 0)
            self.assertEqual(keypoint.class_id, -1)
            self.assertAlmostEqual(keypoint.size, 31 * 1.2 ** keypoint.octave, 2)
        given = cv.KeyPoint(100.25, 90.5, 7., 12., 0.125, 1, 5)
        kept, = aqorb.retainUniform([given], (640, 480), 1)
        for name in ('pt', 'size', 'angle', 'response', 'octave', 'class_id'):
            self.assertEqual(getattr(kept, name), getattr(given, name), name)

    def test_has_the_methods_of_orb(self):
        names = {name for name in dir(cv.ORB) if not name.startswith('_')}
        self.assertEqual(names - set(dir(aqorb.AdaptiveQuadtreeORB)), set())

    def test_arrays_of_any_strides(self):
        image = squares(200, 300)
        wide = np.zeros((200, 310), np.uint8)
        wide[:, 5:305] = image
        bgr = np.zeros((200, 300, 4), np.uint8)
        bgr[..., 1] = image
        orb = aqorb.AdaptiveQuadtreeORB_create(200)
        expected = orb.detectAndCompute(image, None)[1]
        self.assertEqual(len(expected), 200)
        for name, array in (('region', wide[:, 5:305]), ('Fortran', np.asfortranarray(image)),
                            ('flipped twice', image[::-1, ::-1].copy()[::-1, ::-1]),
                            ('transposed', image.T.copy().T), ('every second', image.repeat(2, 1)[:, ::2]),
                            ('one channel', image[..., np.newaxis]), ('a channel', bgr[..., 1])):
            found = orb.detectAndCompute(array, None)[1]
            np.testing.assert_array_equal(found, expected, name)
            mask = np.full(array.shape[:2], 255, np.uint8, 'F')
            np.testing.assert_array_equal(orb.detectAndCompute(image, mask)[1], expected)

    def test_colour(self):
        bgr = np.dstack([squares(200, 300), squares(200, 300)[::-1], squares(200, 300)[:, ::-1]])
        orb = aqorb.AdaptiveQuadtreeORB_create(200)
        expected = orb.detectAndCompute(cv.cvtColor(bgr, cv.COLOR_BGR2GRAY), None)[1]
        for array in (bgr, np.asfortranarray(bgr), bgr[..., ::-1].copy()[..., ::-1],
                      cv.cvtColor(bgr, cv.COLOR_BGR2BGRA)):
            np.testing.assert_array_equal(orb.detectAndCompute(array, None)[1], expected)

    def test_pyramid(self):
        image = squares()
        levels = aqorb.AdaptiveQuadtreeORB_create(nlevels=4).buildPyramid(image)
        self.assertEqual(len(levels), 4)
        self.assertTrue(np.array_equal(levels[0], image))
        self.assertEqual(levels[3].shape, (round(480 / 1.2 ** 3), round(640 / 1.2 ** 3)))

    def test_nothing_to_find(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        for image in (None, np.zeros((0, 0), np.uint8), np.zeros((100, 100), np.uint8)):
            self.assertEqual(len(orb.detect(image)), 0)
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
                self.assertEqual([k.pt for k in found], [k.pt for k in expected[0]])
            np.testing.assert_array_equal(descriptors[i], expected[1])
        masks = [np.zeros(image.shape, np.uint8) for image in images]
        self.assertEqual([len(k) for k in orb.detect(images, masks)], [0, 0])
        masks[1] = None
        self.assertEqual([len(k) for k in orb.detect(images, masks)], [0, len(keypoints[1])])

    def test_bad_arguments(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        image = squares(100, 100)
        storage = cv.FileStorage('{"patchSize": 1}', cv.FILE_STORAGE_READ | cv.FILE_STORAGE_MEMORY)
        for name, call in (('image', lambda: orb.detect(image.astype(np.float32))),
                           ('image', lambda: orb.detect(np.zeros((100, 100, 2), np.uint8))),
                           ('mask', lambda: orb.detectAndCompute(image, np.ones((99, 100), np.uint8))),
                           ('patchSize must be ', lambda: orb.setPatchSize(1)),
                           ('patchSize', lambda: orb.read(storage.root())),
                           ('WTA_K', lambda: aqorb.AdaptiveQuadtreeORB_create(WTA_K=5)),
                           ('imageSize', lambda: aqorb.distributionUniformity([], (0, 10)))):
            with self.assertRaisesRegex(cv.error, name):
                call()
        for call in (lambda: orb.detect('image'), lambda: orb.compute(image, [5]), lambda: orb.setPatchSize(31.5),
                     lambda: aqorb.AdaptiveQuadtreeORB_create(features=5)):
            self.assertRaises((cv.error, TypeError), call)

    def test_mask(self):
        image = squares()
        mask = np.zeros_like(image)
        mask[:, :320] = 1
        keypoints = aqorb.AdaptiveQuadtreeORB_create().detect(image, mask)
        self.assertGreater(len(keypoints), 0)
        self.assertTrue(all(k.pt[0] < 320 for k in keypoints))

    def test_properties(self):
        orb = aqorb.AdaptiveQuadtreeORB_create()
        for name, default in (('PatchSize', 31), ('SelectionType', aqorb.AdaptiveQuadtreeORB_RANKED_SELECTION),
                              ('SubPixel', True), ('EdgeThreshold', 16), ('StrengthWeight', 0.05)):
            self.assertEqual(getattr(orb, 'get' + name)(), default, name)
        for name in [name[3:] for name in dir(orb) if name.startswith('set')]:
            get, set_ = getattr(orb, 'get' + name), getattr(orb, 'set' + name)
            default = get()
            other = not default if isinstance(default, bool) else max(default, 0) + 1
            set_(other)
            self.assertEqual(get(), other, name)

    def test_write_and_read(self):
        orb = aqorb.AdaptiveQuadtreeORB_create(123, 1.5, 4)
        orb.setSelectionType(aqorb.AdaptiveQuadtreeORB_QUADTREE_SELECTION)
        orb.setSubPixel(False)
        handle, path = tempfile.mkstemp(suffix='.yml')
        os.close(handle)
        try:
            orb.write(path)
            other = aqorb.AdaptiveQuadtreeORB_create()
            storage = cv.FileStorage(path, cv.FILE_STORAGE_READ)
            other.read(storage.getFirstTopLevelNode() if storage.getNode('nfeatures').empty()
                       else storage.root())
            storage.release()
        finally:
            os.remove(path)
        for name in [name for name in dir(orb) if name.startswith('get')]:
            self.assertEqual(getattr(other, name)(), getattr(orb, name)(), name)

    def test_functions_of_keypoints(self):
        size = (160, 120)
        even = [cv.KeyPoint(x + 5., y + 5., 1.) for y in range(0, 120, 10) for x in range(0, 160, 10)]
        left = [k for k in even if k.pt[0] < 80]
        self.assertLess(aqorb.distributionUniformity(even, size), aqorb.distributionUniformity(left, size))
        self.assertEqual(aqorb.distributionOccupancy(left, size), 0.5)
        self.assertEqual(aqorb.distributionOccupancy(left, size, (1, 1)), 1)
        # A strong cluster and three weak points elsewhere: every corner of the image is kept.
        cluster = [cv.KeyPoint(10. + i, 10., 1., -1, 100.) for i in range(20)]
        far = [cv.KeyPoint(x, y, 1., -1, 1.) for x, y in ((90., 10.), (10., 90.), (90., 90.))]
        kept = aqorb.retainUniform(cluster + far, (100, 100), 4)
        self.assertEqual(len({(k.pt[0] > 50, k.pt[1] > 50) for k in kept}), 4)
        image = np.full((10, 10), 90, np.uint8)
        image[:, 5:] = 110
        self.assertAlmostEqual(aqorb.adaptiveFastThreshold(image), 100 / 100)  # variance over mean
        self.assertEqual(aqorb.adaptiveFastThreshold(image, np.uint8(image < 100)), 0)

    def test_hamming_matcher(self):
        descriptors = np.random.RandomState(1).randint(0, 256, (150, 32)).astype(np.uint8)
        query, train = descriptors[:100], descriptors[50:]
        expected = [(m.queryIdx, m.trainIdx, m.distance)
                    for m in cv.BFMatcher(cv.NORM_HAMMING, crossCheck=True).match(query, train)]
        matches = aqorb.HammingMatcher_create(cv.NORM_HAMMING, crossCheck=True).match(query, train)
        self.assertEqual([(m.queryIdx, m.trainIdx, m.distance) for m in matches], expected)
        pairs, distances = aqorb.matchArrays(query, train)
        self.assertEqual(np.column_stack([pairs, np.ravel(distances)]).tolist(), [list(m) for m in expected])
        keypoints = [cv.KeyPoint(float(i), float(i % 70), 31.) for i in range(150)]
        rows = np.float64([[0, 0, 0], [0, 0, -1], [0, 1, 0]])
        pairs, _ = aqorb.matchGuided(query, keypoints[:100], train, keypoints[50:], rows, 3)
        self.assertEqual(pairs.tolist(), [[i + 50, i] for i in range(50)])

    def test_refine_matches(self):
        image = cv.GaussianBlur(squares(), (0, 0), 1.5)
        keypoints1 = aqorb.AdaptiveQuadtreeORB_create(500).detect(image)
        # The second image begins three columns later, and its keypoints are a pixel off.
        keypoints2 = [cv.KeyPoint(k.pt[0] - 2, k.pt[1], k.size, k.angle) for k in keypoints1]
        matches = [cv.DMatch(i, i, 0) for i in range(len(keypoints1))]
        few = matches[::3]
        matches, points1, points2 = aqorb.refineMatches(image, keypoints1, image[:, 3:], keypoints2, matches)
        self.assertGreater(len(matches), 400)
        error = np.float32(points1).reshape(-1, 2) - (3, 0) - np.float32(points2).reshape(-1, 2)
        self.assertLess(np.median(np.abs(error)), 0.05)
        grown, grown1, grown2 = aqorb.growMatches(image, keypoints1, image[:, 3:], keypoints2, few)[:3]
        self.assertGreater(len(grown), 2 * len(few))
        self.assertLess(max(match.queryIdx for match in grown), len(grown1))
        self.assertLess(max(match.trainIdx for match in grown), len(grown2))
        points1, points2, deviations = (np.float32(each) for each in aqorb.matchImages(image, image[:, 3:], 500))
        self.assertLess(np.median(np.abs(points1.reshape(-1, 2) - (3, 0) - points2.reshape(-1, 2))), 0.05)
        self.assertGreater(deviations.size, 400)


if __name__ == '__main__':
    NewOpenCVTests.bootstrap()
