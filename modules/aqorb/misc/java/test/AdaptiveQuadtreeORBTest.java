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
import org.opencv.aqorb.HammingMatcher;
import org.opencv.core.Core;
import org.opencv.core.CvException;
import org.opencv.core.CvType;
import org.opencv.core.KeyPoint;
import org.opencv.core.Mat;
import org.opencv.core.MatOfDMatch;
import org.opencv.core.MatOfKeyPoint;
import org.opencv.core.MatOfPoint2f;
import org.opencv.core.Point;
import org.opencv.core.Scalar;
import org.opencv.core.Size;
import org.opencv.test.OpenCVTestCase;

// Calls the wrapped functions.
public class AdaptiveQuadtreeORBTest extends OpenCVTestCase {

    // A grey image full of corners: squares of random place, size and brightness.
    static Mat squares(Size size) {
        Mat squares = new Mat(size, CvType.CV_8U, new Scalar(128));
        Random random = new Random(1);
        for (int i = 0; i < 600; i++) {
            int side = 5 + random.nextInt(20);
            int x = random.nextInt((int) size.width - side), y = random.nextInt((int) size.height - side);
            squares.submat(y, y + side, x, x + side).setTo(new Scalar(random.nextInt(256)));
        }
        return squares;
    }

    public void testDetectMatchAndRefine() {
        AdaptiveQuadtreeORB detector = AdaptiveQuadtreeORB.create(200);
        // Its name, because the package of ORB is another one in OpenCV 5.
        assertEquals("ORB", detector.getClass().getSuperclass().getSimpleName());
        try {
            detector.setPatchSize(1);
            fail("no exception");
        } catch (CvException exception) {
            assertTrue(exception.getMessage().contains("patchSize must be "));
        }

        // The second image begins three columns later.
        Mat image = squares(new Size(320, 240)), part = image.colRange(3, 320);
        List<MatOfKeyPoint> keypoints = new ArrayList<MatOfKeyPoint>();
        List<Mat> descriptors = new ArrayList<Mat>();
        detector.detectAndComputeBatch(Arrays.asList(image, part), new ArrayList<Mat>(), keypoints, descriptors);
        Mat expected = new Mat();
        detector.detectAndCompute(image, new Mat(), new MatOfKeyPoint(), expected);
        assertEquals(new Size(32, 200), expected.size());
        assertMatEqual(expected, descriptors.get(0));

        MatOfDMatch matches = new MatOfDMatch();
        HammingMatcher.create(Core.NORM_HAMMING, true).match(descriptors.get(0), descriptors.get(1), matches);
        Mat pairs = new Mat(), distances = new Mat();
        Aqorb.matchArrays(descriptors.get(0), descriptors.get(1), pairs, distances);
        assertEquals(matches.rows(), pairs.rows());
        List<Point> predicted = new ArrayList<Point>();
        for (KeyPoint keypoint : keypoints.get(0).toArray())
            predicted.add(new Point(keypoint.pt.x - 3, keypoint.pt.y));
        MatOfPoint2f positions = new MatOfPoint2f();
        positions.fromList(predicted);
        Aqorb.matchByPosition(descriptors.get(0), positions, descriptors.get(1), keypoints.get(1), new Size(2, 2),
                pairs, distances);
        assertTrue(pairs.rows() > 100);

        MatOfPoint2f points1 = new MatOfPoint2f(), points2 = new MatOfPoint2f();
        Aqorb.refineMatches(image, keypoints.get(0), part, keypoints.get(1), matches, points1, points2);
        int exact = 0;
        for (int i = 0; i < matches.rows(); i++) {
            Point p = points1.toArray()[i], q = points2.toArray()[i];
            if (Math.abs(p.x - 3 - q.x) < 0.1 && Math.abs(p.y - q.y) < 0.1)
                exact++;
        }
        assertTrue(exact > 100);
        Aqorb.retainUniform(keypoints.get(0), image.size(), 50);
        assertEquals(50, keypoints.get(0).rows());
    }
}
