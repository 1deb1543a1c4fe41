// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "opencv2/aqorb/slam.hpp"

#include <thread>

namespace opencv_test
{
namespace
{

using aqorb::SlamExtractor;

Features extract(SlamExtractor& extractor, const Mat& image, const Mat& mask = Mat())
{
    Features features;
    extractor(image, mask, features.keypoints, features.descriptors);
    return features;
}

//! The detector that a SlamExtractor stands for while there are enough corners.
Ptr<AdaptiveQuadtreeORB> detectorFor(int nfeatures, int nlevels, int iniThFAST, int minThFAST)
{
    const auto detector = AdaptiveQuadtreeORB::create(nfeatures + nlevels, 1.2f, nlevels);
    detector->setAdaptiveThreshold(false);
    detector->setFastThreshold(iniThFAST);
    detector->setMinThresholdRatio(iniThFAST / double(minThFAST));
    detector->setSubPixel(false);
    detector->setStrengthWeight(0.15);
    detector->setOctaveSuppression(0);
    detector->setRankRadius(2.25);
    return detector;
}

// As a SLAM system holds it: an ORBextractor for each camera, which two threads call.
TEST(Aqorb_Slam, a_system_holds_it_as_its_or_bextractor)
{
    using ORBextractor = SlamExtractor;
    ORBextractor extractors[] = {ORBextractor(600, 1.2f, 8, 20, 7), ORBextractor(600, 1.2f, 8, 20, 7)};
    int outside[2];
    Features features[2];
    const auto extractORB = [&](int camera)
    {
        std::vector<int> lapping = {0, 0};
        outside[camera] =
            extractors[camera](makeScene(Size(400, 300), camera + 1), Mat(), features[camera].keypoints,
                               features[camera].descriptors, lapping);
    };
    std::thread left(extractORB, 0), right(extractORB, 1);
    left.join();
    right.join();
    for (int camera = 0; camera < 2; camera++)
    {
        EXPECT_EQ(608u, features[camera].keypoints.size());
        EXPECT_EQ(608, features[camera].descriptors.rows);
        EXPECT_EQ(608, outside[camera]);  // no keypoint lies in column 0
    }
    ORBextractor& extractor = extractors[0];
    EXPECT_EQ(8, extractor.GetLevels());
    EXPECT_EQ(1.2f, extractor.GetScaleFactor());
    ASSERT_EQ(8u, extractor.GetScaleFactors().size());
    for (int i = 0; i < 8; i++)
    {
        const float scale = reference::levelScale(i, 0, 1.2f);
        EXPECT_EQ(scale, extractor.GetScaleFactors()[i]);
        EXPECT_FLOAT_EQ(1 / scale, extractor.GetInverseScaleFactors()[i]);
        EXPECT_FLOAT_EQ(scale * scale, extractor.GetScaleSigmaSquares()[i]);
        EXPECT_FLOAT_EQ(1 / (scale * scale), extractor.GetInverseScaleSigmaSquares()[i]);
    }
}

TEST(Aqorb_Slam, keypoints_are_the_detectors_at_the_given_thresholds)
{
    // So much contrast that too few corners do not lower the thresholds.
    Mat image = makeScene(Size(320, 240));
    image.convertTo(image, CV_8U, 2, -130);
    ASSERT_GT(aqorb::adaptiveFastThreshold(image), 20);
    const int thresholds[][2] = {{20, 7}, {20, 20}, {40, 9}, {254, 1}, {1, 1}, {13, 11}};
    for (const int* pair : thresholds)
    {
        SCOPED_TRACE(format("%d, %d", pair[0], pair[1]));
        SlamExtractor extractor(5000, 1.2f, 4, pair[0], pair[1]);
        const Features found = extract(extractor, image);
        const reference::Thresholds expected = reference::thresholds(
            0, false, extractor.detector()->getFastThreshold(), extractor.detector()->getMinThresholdRatio());
        EXPECT_EQ(pair[0], expected.ini);
        EXPECT_EQ(pair[1], expected.min);

        const auto detector = detectorFor(5000, 4, pair[0], pair[1]);
        EXPECT_TRUE(sameFeatures(detectAndCompute(*detector, image), found));
    }
}

TEST(Aqorb_Slam, properties_of_the_detector_are_heeded)
{
    const Mat image = makeScene(Size(400, 300));
    SlamExtractor extractor(500, 1.2f, 8, 20, 7);
    AdaptiveQuadtreeORB& detector = *extractor.detector();
    detector.setMaxFeatures(500);
    detector.setSubPixel(true);
    detector.setAdaptiveThreshold(true);
    detector.setMinThresholdRatio(4);
    detector.setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION);
    detector.setOctaveSuppression(3);
    const Ptr<AdaptiveQuadtreeORB> expected = AdaptiveQuadtreeORB::create(500);
    expected->setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION);
    expected->setOctaveSuppression(3);
    EXPECT_TRUE(sameFeatures(detectAndCompute(*expected, image), extract(extractor, image)));
}

// ORB-SLAM2's tracker starts on a frame with more than 500 keypoints, whatever the settings ask for.
TEST(Aqorb_Slam, one_keypoint_more_a_level_than_asked_for)
{
    const Mat image = makeScene(Size(640, 480));
    for (int nlevels : {1, 2, 8, 12})
        for (int nfeatures : {1, 10, 500, 1000})
        {
            SCOPED_TRACE(format("%d features, %d levels", nfeatures, nlevels));
            SlamExtractor extractor(nfeatures, 1.2f, nlevels, 20, 7);
            EXPECT_EQ(nfeatures + nlevels, extractor.detector()->getMaxFeatures());
            EXPECT_EQ(nlevels, extractor.GetLevels());
            const Features found = extract(extractor, image);
            EXPECT_EQ(size_t(nfeatures + nlevels), found.keypoints.size());
            EXPECT_EQ(nfeatures + nlevels, found.descriptors.rows);
            for (size_t i = 1; i < found.keypoints.size(); i++)
                ASSERT_LE(found.keypoints[i - 1].octave, found.keypoints[i].octave) << i;
        }
}

TEST(Aqorb_Slam, no_keypoints_all_keypoints_and_an_empty_image)
{
    const Mat image = makeScene(Size(320, 240));
    SlamExtractor none(0, 1.2f, 8, 20, 7);
    EXPECT_TRUE(sameFeatures(Features(), extract(none, image)));
    EXPECT_EQ(8u, none.mvImagePyramid.size());

    SlamExtractor plenty(100000, 1.2f, 8, 20, 7);
    Features all = extract(plenty, image);
    for (int less : {0, 1, 7, 8, 9})
    {
        SlamExtractor maximal(INT_MAX - less, 1.2f, 8, 20, 7);
        EXPECT_EQ(less > 8 ? INT_MAX - less + 8 : INT_MAX, maximal.detector()->getMaxFeatures());
        EXPECT_TRUE(sameFeatures(all, extract(maximal, image))) << less;
    }
    EXPECT_EQ(0, plenty(Mat(), noArray(), all.keypoints, all.descriptors, std::vector<int>(2)));
    EXPECT_TRUE(sameFeatures(Features(), all));
    EXPECT_TRUE(plenty.mvImagePyramid[0].empty());
}

TEST(Aqorb_Slam, positions_are_pixels_of_the_level_times_its_scale)
{
    SlamExtractor extractor(1000, 1.2f, 8, 20, 7);
    const Features found = extract(extractor, makeScene(Size(500, 350)));
    ASSERT_EQ(1008u, found.keypoints.size());
    const std::vector<float> scales = extractor.GetScaleFactors();
    for (const KeyPoint& keypoint : found.keypoints)
    {
        const float scale = scales[keypoint.octave];
        const Point pixel(cvRound(keypoint.pt.x / scale), cvRound(keypoint.pt.y / scale));
        ASSERT_EQ(Point2f(pixel.x * scale, pixel.y * scale), keypoint.pt);
        // the 11x11 patch and the range of 5 pixels to either side that ORB-SLAM's stereo matching reads
        const Rect read(pixel.x - 10, pixel.y - 5, 21, 11);
        ASSERT_EQ(read, read & Rect(Point(), extractor.mvImagePyramid[keypoint.octave].size()));
    }
}

// The mean error of disparities, in pixels, on drawn pairs of a known one. As stereo matching in SLAM does, the sum of
// squared differences is minimised around the right keypoint's pixel of the left one's level, and a parabola refines
// it; the disparity counts from the left keypoint's position.
double meanDisparityError(bool subPixel)
{
    const int RADIUS = 5;
    SlamExtractor left(1000, 1.2f, 8, 20, 7), right(1000, 1.2f, 8, 20, 7);
    left.detector()->setSubPixel(subPixel);
    right.detector()->setSubPixel(subPixel);
    const Mat scene = makeScene(Size(1300, 900));
    double sum = 0;
    int count = 0;
    for (int twice : {16, 17, 21, 40})  // the disparity, in pixels of the scene, which is reduced to a half
    {
        Mat images[2], pairs, distances;
        for (int i = 0; i < 2; i++)
            resize(scene(Rect(i * twice, 0, 1200, 900)), images[i], Size(), 0.5, 0.5, INTER_AREA);
        const Features a = extract(left, images[0]), b = extract(right, images[1]);
        std::vector<Point2f> expected;
        for (const KeyPoint& keypoint : a.keypoints)
            expected.push_back(keypoint.pt - Point2f(twice / 2.f, 0));
        aqorb::matchByPosition(a.descriptors, expected, b.descriptors, b.keypoints, Size2f(4, 2), pairs,
                               distances);
        for (int i = 0; i < pairs.rows; i++)
        {
            const KeyPoint &from = a.keypoints[pairs.at<int>(i, 0)], &to = b.keypoints[pairs.at<int>(i, 1)];
            const float scale = left.GetScaleFactors()[from.octave];
            const Mat &level = left.mvImagePyramid[from.octave], &other = right.mvImagePyramid[from.octave];
            const int y = cvRound(from.pt.y / scale), x = cvRound(from.pt.x / scale);
            const Rect patch(x - RADIUS, y - RADIUS, 2 * RADIUS + 1, 2 * RADIUS + 1);
            const Rect row =
                Rect(cvRound(to.pt.x / scale) - 2 * RADIUS, patch.y, 4 * RADIUS + 1, patch.height);
            if ((row & Rect(Point(), other.size())) != row)
                continue;
            Mat differences;
            matchTemplate(other(row), level(patch), differences, TM_SQDIFF);
            Point best;
            minMaxLoc(differences, nullptr, nullptr, &best);
            if (best.x == 0 || best.x == 2 * RADIUS)
                continue;
            const float* d = differences.ptr<float>() + best.x;
            const double offset = (d[-1] - d[1]) / (2. * (d[-1] + d[1] - 2 * d[0]));
            sum += from.pt.x - scale * (row.x + RADIUS + best.x + offset) - twice / 2.;
            count++;
        }
    }
    EXPECT_GT(count, 2000);
    return sum / count;
}

TEST(Aqorb_Slam, disparities_are_too_large_with_sub_pixel_positions)
{
    EXPECT_NEAR(0, meanDisparityError(false), 0.05);
    EXPECT_NEAR(0.3, meanDisparityError(true), 0.1);
}

TEST(Aqorb_Slam, keypoints_are_parted_by_the_overlap)
{
    const Mat image = makeScene(Size(400, 300));
    SlamExtractor extractor(800, 1.2f, 8, 20, 7);
    const Features all = extract(extractor, image);
    const int areas[][2] = {{0, 0}, {0, 400}, {100, 250}, {250, 399}, {-50, 30}, {250, 100}};
    for (const int* area : areas)
    {
        SCOPED_TRACE(format("%d to %d", area[0], area[1]));
        Features expected;
        std::vector<int> order;
        for (int inside = 0; inside <= 1; inside++)
        {
            for (int i = 0; i < int(all.keypoints.size()); i++)
            {
                const float x = all.keypoints[i].pt.x;
                if ((x >= area[0] && x <= area[1]) == (inside == 1))
                {
                    expected.keypoints.push_back(all.keypoints[i]);
                    expected.descriptors.push_back(all.descriptors.row(i));
                }
            }
            order.push_back(int(expected.keypoints.size()));
        }
        Features found;
        const int outside =
            extractor(image, noArray(), found.keypoints, found.descriptors, std::vector<int>(area, area + 2));
        EXPECT_EQ(order[0], outside);
        EXPECT_TRUE(sameFeatures(expected, found));
    }
}

TEST(Aqorb_Slam, the_pyramid_is_the_detectors_and_its_memory_can_be_given_back)
{
    SlamExtractor extractor(500, 1.2f, 8, 20, 7);
    const Mat images[] = {makeScene(Size(301, 247)), makeScene(Size(123, 456), 2)};
    for (const Mat& image : images)
    {
        KeyPoints keypoints;
        Mat output = image.clone();  // The descriptors may replace the image.
        extractor(output, noArray(), keypoints, output);
        const std::vector<Mat> expected = reference::pyramid(image, 8, 0, 1.2f);
        ASSERT_EQ(8u, extractor.mvImagePyramid.size());
        for (int i = 0; i < 8; i++)
        {
            const Mat& level = extractor.mvImagePyramid[i];
            EXPECT_TRUE(sameMat(expected[i], level)) << "level " << i;
            const float scale = extractor.GetScaleFactors()[i];
            EXPECT_EQ(Size(cvRound(image.cols / scale), cvRound(image.rows / scale)), level.size());
        }
        extractor.releaseMemory();
        EXPECT_TRUE(extractor.mvImagePyramid.empty());
    }
}

TEST(Aqorb_Slam, a_mask_is_heeded_and_a_fixed_one_stands_in_for_an_empty_one)
{
    const Mat image = makeScene(Size(320, 240));
    Mat left(image.size(), CV_8UC1, Scalar(0)), lower = left.clone();
    left.colRange(0, 160).setTo(1);
    lower.rowRange(120, 240).setTo(1);
    SlamExtractor plain(500, 1.2f, 8, 20, 7), masked(500, 1.2f, 8, 20, 7);
    masked.setMask(left);
    const Features expected = extract(plain, image, left);
    EXPECT_FALSE(expected.keypoints.empty());
    for (const KeyPoint& keypoint : expected.keypoints)
        EXPECT_LT(cvRound(keypoint.pt.x), 160);
    left.setTo(0);  // the mask was copied
    EXPECT_TRUE(sameFeatures(expected, extract(masked, image)));
    EXPECT_TRUE(sameFeatures(extract(plain, image, lower), extract(masked, image, lower)));
    AQORB_BAD("mask", "320 x 240", extract(masked, image.rowRange(0, 200)));
    EXPECT_NE(std::string::npos,
              messageOf([&] { extract(masked, image.rowRange(0, 200)); }).find("320 x 200, got"));
    masked.setMask(Mat());
    EXPECT_TRUE(sameFeatures(extract(plain, image), extract(masked, image)));
}

// In the dark the given thresholds leave few corners. The properties of the detector hold in the second search, too.
TEST(Aqorb_Slam, the_thresholds_adapt_where_corners_do_not_suffice)
{
    const Mat bright = makeScene(Size(640, 480)), dark = bright * 0.1;
    SlamExtractor extractor(1000, 1.2f, 8, 20, 7);
    const auto fixed = detectorFor(1000, 8, 20, 7), adaptive = detectorFor(1000, 8, 20, 7);
    adaptive->setAdaptiveThreshold(true);
    for (ORB::ScoreType score : {ORB::HARRIS_SCORE, ORB::FAST_SCORE})
    {
        for (AdaptiveQuadtreeORB* detector : {&*extractor.detector(), &*fixed, &*adaptive})
            detector->setScoreType(score);
        const Features inTheDark = extract(extractor, dark);
        EXPECT_LT(detectAndCompute(*fixed, dark).keypoints.size(), 900u);
        EXPECT_EQ(1008u, inTheDark.keypoints.size());
        EXPECT_TRUE(sameFeatures(detectAndCompute(*adaptive, dark), inTheDark));
        EXPECT_TRUE(sameFeatures(detectAndCompute(*fixed, bright), extract(extractor, bright)));
        // Equation (7) would raise the thresholds of a bright drawing with few corners.
        Mat drawing(240, 320, CV_8UC1, Scalar(255));
        rectangle(drawing, Rect(80, 80, 130, 70), Scalar(0), -1);
        EXPECT_TRUE(sameFeatures(detectAndCompute(*fixed, drawing), extract(extractor, drawing)));
    }
    EXPECT_FALSE(extractor.detector()->getAdaptiveThreshold());
}

// New points for a tracker that has lost half of its points, away from the others. Prints what the tutorial says.
TEST(Aqorb_Slam, a_tracker_replenishes_its_points)
{
    AQORB_NEEDS_DATA();
    const int DISTANCE = 15, POINTS = 300;
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(POINTS / 2, 1.2f, 1);
    double found[2] = {0, 0}, cells[2] = {0, 0};
    TickMeter time[2];
    for (const Mat& image : photographs())
    {
        std::vector<Point2f> tracked, corners;
        goodFeaturesToTrack(image, tracked, POINTS, 0.01, DISTANCE);
        tracked.resize(tracked.size() / 2);
        Mat mask(image.size(), CV_8UC1, Scalar(255));
        for (const Point2f& p : tracked)
            circle(mask, p, DISTANCE, Scalar(0), -1);
        KeyPoints keypoints[2];
        detector->detect(image, keypoints[0], mask);  // so that the memory is there
        time[0].start();
        detector->detect(image, keypoints[0], mask);
        time[0].stop();
        time[1].start();
        goodFeaturesToTrack(image, corners, POINTS / 2, 0.01, DISTANCE, mask);
        time[1].stop();
        KeyPoint::convert(corners, keypoints[1]);
        for (int i = 0; i < 2; i++)
        {
            found[i] += double(keypoints[i].size());
            for (const Point2f& p : tracked)
                keypoints[i].push_back(KeyPoint(p, 1));
            cells[i] += aqorb::distributionOccupancy(keypoints[i], image.size());
        }
    }
    std::cout << "times goodFeaturesToTrack's: new points " << found[0] / found[1] << ", occupied cells "
              << cells[0] / cells[1] << ", time " << time[0].getTimeSec() / time[1].getTimeSec() << std::endl;
    EXPECT_GE(found[0], found[1]);
    EXPECT_GE(cells[0], cells[1]);
}

TEST(Aqorb_Slam, bad_arguments)
{
    for (int nfeatures : {-1, -8, INT_MIN})
        EXPECT_THROW(SlamExtractor(nfeatures, 1.2f, 8, 20, 7), cv::Exception) << nfeatures;
    EXPECT_THROW(SlamExtractor(500, 0, 8, 20, 7), cv::Exception);
    for (int nlevels : {0, -1, INT_MIN, 65537, INT_MAX})
        EXPECT_THROW(SlamExtractor(500, 1.2f, nlevels, 20, 7), cv::Exception) << nlevels;
    const int bad[][2] = {{0, 0}, {-20, 7}, {255, 7}, {20, 0}, {20, -7}, {7, 20}};
    for (const int* pair : bad)
        EXPECT_THROW(SlamExtractor(500, 1.2f, 8, pair[0], pair[1]), cv::Exception) << pair[0];

    SlamExtractor extractor(500, 1.2f, 8, 20, 7);
    const Mat image = makeScene(Size(200, 150));
    Features features;
    EXPECT_THROW(extractor(image, noArray(), features.keypoints, features.descriptors, std::vector<int>(1)),
                 cv::Exception);
    Mat_<float> floats(1, 1, 7.f);
    features.keypoints.resize(3);
    EXPECT_THROW(extractor(image, noArray(), features.keypoints, floats, std::vector<int>(2)), cv::Exception);
    EXPECT_EQ(3u, features.keypoints.size());
    EXPECT_EQ(7.f, floats(0));
    EXPECT_THROW(extract(extractor, Mat(150, 200, CV_16UC1, Scalar(0))), cv::Exception);
    EXPECT_THROW(extract(extractor, image, Mat(150, 199, CV_8UC1, Scalar(1))), cv::Exception);
}

}  // namespace
}  // namespace opencv_test
