// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0
package org.opencv.test.aqorb;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Random;

import org.opencv.aqorb.Aqorb;
import org.opencv.aqorb.HammingMatcher;
import org.opencv.core.Core;
import org.opencv.core.CvException;
import org.opencv.core.CvType;
import org.opencv.core.DMatch;
import org.opencv.core.KeyPoint;
import org.opencv.core.Mat;
import org.opencv.core.MatOfDMatch;
import org.opencv.core.MatOfKeyPoint;
import org.opencv.core.MatOfPoint2f;
import org.opencv.core.Point;
import org.opencv.core.Size;
import org.opencv.imgproc.Imgproc;
import org.opencv.test.OpenCVTestCase;

public class HammingMatcherTest extends OpenCVTestCase {

    private static final int WIDTH = 32;  // bytes of a descriptor

    HammingMatcher matcher;
    Mat query, train;

    @Override
    protected void setUp() throws Exception {
        super.setUp();
        matcher = HammingMatcher.create(Core.NORM_HAMMING, true);
        byte[] bytes = new byte[150 * WIDTH];
        new Random(1).nextBytes(bytes);
        Mat descriptors = new Mat(150, WIDTH, CvType.CV_8U);
        descriptors.put(0, 0, bytes);
        query = descriptors.rowRange(0, 100);
        train = descriptors.rowRange(50, 150);  // query row 50 + i is train row i
    }

    public void testCreate() {
        assertNotNull(matcher);
        assertEquals("BFMatcher", matcher.getClass().getSuperclass().getSimpleName());
        assertNotNull(new HammingMatcher(Core.NORM_HAMMING2));
        assertNotNull(HammingMatcher.create());
        try {
            HammingMatcher.create(Core.NORM_L2);
            fail("no exception");
        } catch (CvException exception) {
            assertTrue(exception.getMessage().contains("normType"));
        }
    }

    public void testMatch() {
        MatOfDMatch matches = new MatOfDMatch();
        List<MatOfDMatch> lists = new ArrayList<MatOfDMatch>();
        HammingMatcher.create().match(query, train, matches);
        HammingMatcher.create().knnMatch(query, train, lists, 2);
        assertEquals(100, matches.rows());
        assertEquals(100, lists.size());
        for (int i = 0; i < 100; i++) {
            DMatch match = matches.toArray()[i];
            DMatch[] pair = lists.get(i).toArray();
            assertEquals(i, match.queryIdx);
            assertEquals(match.trainIdx, pair[0].trainIdx);
            assertTrue(pair[0].distance <= pair[1].distance);
            if (i >= 50)
                assertEquals(i - 50, match.trainIdx);
        }
    }

    public void testMatchArrays() {
        MatOfDMatch expected = new MatOfDMatch();
        matcher.match(query, train, expected);
        Mat pairs = new Mat(), distances = new Mat();
        Aqorb.matchArrays(query, train, pairs, distances);
        DMatch[] matches = expected.toArray();
        assertEquals(matches.length, pairs.rows());
        for (int i = 0; i < matches.length; i++) {
            assertEquals(matches[i].queryIdx, (int) pairs.get(i, 0)[0]);
            assertEquals(matches[i].trainIdx, (int) pairs.get(i, 1)[0]);
            assertEquals((int) matches[i].distance, (int) distances.get(i, 0)[0]);
        }
    }

    public void testMatchByPosition() {
        List<Point> predicted = new ArrayList<Point>();
        List<KeyPoint> keypoints = new ArrayList<KeyPoint>();
        for (int i = 0; i < 100; i++) {
            predicted.add(new Point(10 * (i - 50) + 1, 5));
            keypoints.add(new KeyPoint(10 * i, 5, 1));
        }
        MatOfPoint2f positions = new MatOfPoint2f();
        positions.fromList(predicted);
        MatOfKeyPoint trainKeypoints = new MatOfKeyPoint();
        trainKeypoints.fromList(keypoints);
        Mat pairs = new Mat(), distances = new Mat();
        Aqorb.matchByPosition(query, positions, train, trainKeypoints, new Size(2, 2), pairs, distances);
        assertEquals(50, pairs.rows());
        for (int i = 0; i < 50; i++) {
            assertEquals(50 + i, (int) pairs.get(i, 0)[0]);
            assertEquals(i, (int) pairs.get(i, 1)[0]);
            assertEquals(0, (int) distances.get(i, 0)[0]);
        }
    }

    public void testRefineMatches() {
        Mat image = new Mat(200, 200, CvType.CV_8UC1);
        Core.randu(image, 0, 256);
        Imgproc.GaussianBlur(image, image, new Size(9, 9), 2);
        Core.normalize(image, image, 0, 255, Core.NORM_MINMAX);
        // The second image begins three columns later, and its keypoints are a pixel off.
        Mat part = image.colRange(3, 200);
        MatOfKeyPoint keypoints1 = new MatOfKeyPoint(new KeyPoint(100, 90, 31, 10), new KeyPoint(60, 120, 31, 20));
        MatOfKeyPoint keypoints2 = new MatOfKeyPoint(new KeyPoint(98, 90, 31, 10), new KeyPoint(57, 121, 31, 20));
        MatOfDMatch matches = new MatOfDMatch(new DMatch(0, 0, 0), new DMatch(1, 1, 0), new DMatch(0, 1, 0));
        MatOfPoint2f points1 = new MatOfPoint2f(), points2 = new MatOfPoint2f();
        Aqorb.refineMatches(image, keypoints1, part, keypoints2, matches, points1, points2);
        assertEquals(2, matches.rows());
        for (int i = 0; i < 2; i++) {
            assertEquals(points1.toArray()[i].x - 3, points2.toArray()[i].x, 0.1);
            assertEquals(points1.toArray()[i].y, points2.toArray()[i].y, 0.1);
        }
    }
}
