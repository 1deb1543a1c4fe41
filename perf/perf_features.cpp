// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// cv::ORB and AdaptiveQuadtreeORB side by side, both with their default parameters. The detector is
// the last parameter, so that the two of a case run one right after the other and see the same load of
// the machine.

#include "perf_precomp.hpp"
#include "perf_scene.hpp"

namespace opencv_test
{
namespace
{

enum DetectorId
{
    CV_ORB,
    AQORB
};
CV_ENUM(Detector, CV_ORB, AQORB)

typedef tuple<std::string, int, Detector> Image_NFeatures_Detector_t;

class Features : public perf::TestBaseWithParam<Image_NFeatures_Detector_t>
{
protected:
    void detectAndCompute();
};

//! How the time grows with the size of the image and with the number of features.
typedef Features Scaling;

#define EVALUATION_IMAGE(name) "cv/detectors_descriptors_evaluation/images_datasets/" name "/img1.png"

const std::string IMAGES[] = {
    // of OpenCV's own perf tests of features2d
    EVALUATION_IMAGE("leuven"), "stitching/a3.png",
    // its other planar scenes, and photographs of other sizes
    EVALUATION_IMAGE("bikes"), EVALUATION_IMAGE("bark"), EVALUATION_IMAGE("trees"), EVALUATION_IMAGE("ubc"),
    "perf/640x512.png", "perf/1920x1080.png",
    // makeStreetScene, which needs no data
    "scene_640x480", "scene_1280x720", "scene_1920x1080"};

#define FEATURES_PARAMS \
    testing::Combine(testing::ValuesIn(IMAGES), testing::Values(500, 1000, 2000), Detector::all())

#define SCALING_PARAMS                                                                                      \
    testing::Combine(testing::Values("scene_320x240", "scene_640x480", "scene_1280x720", "scene_1920x1080", \
                                     "scene_2560x1440", "scene_3840x2160"),                                 \
                     testing::Values(250, 500, 1000, 2000, 4000, 8000), Detector::all())

Ptr<Feature2D> createDetector(Detector detector, int nfeatures)
{
    if (detector == AQORB)
        return aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    return ORB::create(nfeatures);
}

//! Throws what makes the harness skip the test where the file is not in OPENCV_TEST_DATA_PATH.
Mat loadImage(const std::string& name)
{
    static std::string lastName;  // kept, as reading or drawing an image takes longer than a case
    static Mat last;
    if (name != lastName)
    {
        Size size;
        if (sscanf(name.c_str(), "scene_%dx%d", &size.width, &size.height) == 2)
            last = makeStreetScene(size);
        else
            last = imread(cvtest::findDataFile(name, false), IMREAD_GRAYSCALE);
        lastName = name;
    }
    return last;
}

//! Notes what was measured, for the tables.
void recordCase(const Mat& image, size_t keypoints)
{
    testing::Test::RecordProperty("image_size", cv::format("%dx%d", image.cols, image.rows));
    testing::Test::RecordProperty("keypoints", (int)keypoints);
}

void Features::detectAndCompute()
{
    const Mat image = loadImage(get<0>(GetParam()));
    ASSERT_FALSE(image.empty());
    Ptr<Feature2D> detector = createDetector(get<2>(GetParam()), get<1>(GetParam()));
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
    detector->detectAndCompute(image, noArray(), keypoints, descriptors);

    TEST_CYCLE() detector->detectAndCompute(image, noArray(), keypoints, descriptors);

    EXPECT_GT(keypoints.size(), 20u);
    EXPECT_EQ((int)keypoints.size(), descriptors.rows);
    recordCase(image, keypoints.size());
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Features, detect, FEATURES_PARAMS)
{
    const Mat image = loadImage(get<0>(GetParam()));
    ASSERT_FALSE(image.empty());
    Ptr<Feature2D> detector = createDetector(get<2>(GetParam()), get<1>(GetParam()));
    std::vector<KeyPoint> keypoints;
    detector->detect(image, keypoints);  // the first call also fills caches and allocates

    TEST_CYCLE() detector->detect(image, keypoints);

    EXPECT_GT(keypoints.size(), 20u);
    recordCase(image, keypoints.size());
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Features, compute, FEATURES_PARAMS)
{
    const Mat image = loadImage(get<0>(GetParam()));
    ASSERT_FALSE(image.empty());
    // cv::ORB's keypoints for both. They lie inside both borders, so that none is dropped.
    std::vector<KeyPoint> keypoints;
    ORB::create(get<1>(GetParam()))->detect(image, keypoints);
    const size_t given = keypoints.size();
    Ptr<Feature2D> detector = createDetector(get<2>(GetParam()), get<1>(GetParam()));
    Mat descriptors;
    detector->compute(image, keypoints, descriptors);

    TEST_CYCLE() detector->compute(image, keypoints, descriptors);

    EXPECT_GT(given, 20u);
    EXPECT_EQ(given, keypoints.size());
    EXPECT_EQ((int)given, descriptors.rows);
    recordCase(image, given);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Features, detectAndCompute, FEATURES_PARAMS)
{
    detectAndCompute();
}

PERF_TEST_P(Scaling, detectAndCompute, SCALING_PARAMS)
{
    detectAndCompute();
}

}  // namespace
}  // namespace opencv_test
