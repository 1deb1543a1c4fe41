// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0
package org.opencv.test.aqorb;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Random;

import org.opencv.aqorb.AdaptiveQuadtreeORB;
import org.opencv.aqorb.Aqorb;
import org.opencv.core.Core;
import org.opencv.core.CvException;
import org.opencv.core.CvType;
import org.opencv.core.KeyPoint;
import org.opencv.core.Mat;
import org.opencv.core.MatOfKeyPoint;
import org.opencv.core.Scalar;
import org.opencv.core.Size;
import org.opencv.test.OpenCVTestCase;
import org.opencv.test.OpenCVTestRunner;

public class AdaptiveQuadtreeORBTest extends OpenCVTestCase {

    private static final int ROWS = 240;
    private static final int COLS = 320;

    AdaptiveQuadtreeORB detector;
    Mat image;

    // A grey image full of corners: squares of random place, size and brightness.
    static Mat squares() {
        Mat squares = new Mat(ROWS, COLS, CvType.CV_8U, new Scalar(128));
        Random random = new Random(1);
        for (int i = 0; i < 600; i++) {
            int side = 5 + random.nextInt(20);
            int x = random.nextInt(COLS - side), y = random.nextInt(ROWS - side);
            squares.submat(y, y + side, x, x + side).setTo(new Scalar(random.nextInt(256)));
        }
        return squares;
    }

    @Override
    protected void setUp() throws Exception {
        super.setUp();
        detector = AdaptiveQuadtreeORB.create(200);
        image = squares();
    }

    public void testCreate() {
        assertNotNull(detector);
        // Its name, because the package of ORB is another one in OpenCV 5.
        assertEquals("ORB", detector.getClass().getSuperclass().getSimpleName());
        assertEquals("Feature2D.AdaptiveQuadtreeORB", detector.getDefaultName());
        assertEquals(200, detector.getMaxFeatures());
        assertEquals(16, detector.getEdgeThreshold());
        assertEquals(32, detector.descriptorSize());
        assertEquals(Core.NORM_HAMMING, detector.defaultNorm());
        assertFalse(detector.empty());
    }

    public void testParameters() {
        detector = AdaptiveQuadtreeORB.create(300, 1.5f, 4, 20, 1, 3, 1, 35, 15);
        assertEquals(300, detector.getMaxFeatures());
        assertEquals(1.5, detector.getScaleFactor());
        assertEquals(4, detector.getNLevels());
        assertEquals(20, detector.getEdgeThreshold());
        assertEquals(1, detector.getFirstLevel());
        assertEquals(3, detector.getWTA_K());
        assertEquals(1, detector.getScoreType());
        assertEquals(35, detector.getPatchSize());
        assertEquals(15, detector.getFastThreshold());
        assertEquals(Core.NORM_HAMMING2, detector.defaultNorm());
        detector.setStrengthWeight(4);
        detector.setSubPixel(false);
        detector.setSelectionType(AdaptiveQuadtreeORB.QUADTREE_SELECTION);
        assertEquals(4.0, detector.getStrengthWeight());
        assertFalse(detector.getSubPixel());
        assertEquals(AdaptiveQuadtreeORB.QUADTREE_SELECTION, detector.getSelectionType());
    }

    public void testDetectAndCompute() {
        MatOfKeyPoint keypoints = new MatOfKeyPoint();
        Mat descriptors = new Mat();
        detector.detectAndCompute(image, new Mat(), keypoints, descriptors);
        assertEquals(200, keypoints.toArray().length);
        assertEquals(new Size(32, 200), descriptors.size());
        assertEquals(CvType.CV_8U, descriptors.type());

        MatOfKeyPoint detected = new MatOfKeyPoint();
        Mat computed = new Mat();
        detector.detect(image, detected);
        assertListKeyPointEquals(keypoints.toList(), detected.toList(), EPS);
        detector.compute(image, detected, computed);
        assertMatEqual(descriptors, computed);
    }

    public void testDetectAndComputeBatch() {
        Mat flat = new Mat(100, 100, CvType.CV_8U, new Scalar(128));
        List<MatOfKeyPoint> keypoints = new ArrayList<MatOfKeyPoint>();
        List<Mat> descriptors = new ArrayList<Mat>();
        detector.detectAndComputeBatch(Arrays.asList(image, flat, image), new ArrayList<Mat>(), keypoints, descriptors);
        Mat expected = new Mat();
        detector.detectAndCompute(image, new Mat(), new MatOfKeyPoint(), expected);
        assertEquals(3, keypoints.size());
        assertEquals(3, descriptors.size());
        assertEquals(0, keypoints.get(1).toArray().length);
        assertTrue(descriptors.get(1).empty());
        for (int i = 0; i < 3; i += 2) {
            assertEquals(200, keypoints.get(i).toArray().length);
            assertMatEqual(expected, descriptors.get(i));
        }
    }

    public void testErrors() {
        try {
            detector.setPatchSize(1);
            fail("no exception");
        } catch (CvException exception) {
            assertTrue(exception.getMessage().contains("patchSize must be "));
        }
        assertEquals(31, detector.getPatchSize());
        try {
            detector.detect(new Mat(ROWS, COLS, CvType.CV_32F), new MatOfKeyPoint());
            fail("no exception");
        } catch (CvException exception) {
            assertTrue(exception.getMessage().contains("image"));
        }
    }

    public void testWriteAndRead() {
        String filename = OpenCVTestRunner.getTempFileName("yml");
        detector.setPatchSize(40);
        detector.write(filename);
        AdaptiveQuadtreeORB other = AdaptiveQuadtreeORB.create();
        other.read(filename);
        assertEquals(200, other.getMaxFeatures());
        assertEquals(40, other.getPatchSize());
        new java.io.File(filename).delete();
    }

    // A strong cluster and three weak points elsewhere: every corner of the image is kept.
    public void testRetainUniform() {
        List<KeyPoint> all = new ArrayList<KeyPoint>();
        for (int i = 0; i < 20; i++)
            all.add(new KeyPoint(10 + i, 10, 1, -1, 100));
        all.add(new KeyPoint(90, 10, 1, -1, 1));
        all.add(new KeyPoint(10, 90, 1, -1, 1));
        all.add(new KeyPoint(90, 90, 1, -1, 1));
        MatOfKeyPoint keypoints = new MatOfKeyPoint();
        keypoints.fromList(all);
        Aqorb.retainUniform(keypoints, new Size(100, 100), 4);
        List<KeyPoint> kept = keypoints.toList();
        assertEquals(4, kept.size());
        assertListKeyPointEquals(all.subList(20, 23), kept.subList(1, 4), EPS);
    }
}
