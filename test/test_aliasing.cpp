// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "opencv2/aqorb/slam.hpp"

// Outputs that lie in the memory of inputs: what is still read must not be written over.

namespace opencv_test
{
namespace
{

const int BYTES = 32;

// A tall image of 32 columns with so many keypoints that it has the shape of their descriptors.
struct Column
{
    Column() : detector(AdaptiveQuadtreeORB::create(ROWS, 1.2f, 3, 4)), image(makeNoise(Size(BYTES, ROWS)))
    {
        detector->setFastThreshold(5);
        expected = detectAndCompute(*detector, image);
    }
    static const int ROWS = 600;
    Ptr<AdaptiveQuadtreeORB> detector;
    Mat image;
    Features expected;
};

TEST(Aqorb_Aliasing, the_image_as_the_output)
{
    const Column column;
    ASSERT_EQ(int(Column::ROWS), column.expected.descriptors.rows);
    for (int threads = 1; threads <= 2; threads++)
    {
        setNumThreads(threads);
        KeyPoints keypoints;
        Mat m = column.image.clone();
        column.detector->detectAndCompute(m, noArray(), keypoints, m);
        EXPECT_TRUE(sameFeatures(column.expected, Features{keypoints, m}));

        m = column.image.clone();
        column.detector->compute(m, keypoints, m);
        EXPECT_TRUE(sameFeatures(column.expected, Features{keypoints, m}));
    }
    setNumThreads(-1);
}

TEST(Aqorb_Aliasing, the_mask_as_the_output)
{
    const Column column;
    const Mat mask(column.image.size(), CV_8UC1, Scalar(1));
    Mat m = mask.clone();
    KeyPoints keypoints;
    column.detector->detectAndCompute(column.image, m, keypoints, m);
    EXPECT_TRUE(sameFeatures(column.expected, Features{keypoints, m}));

    // Positions are looked up in the mask while descriptors are computed.
    Mat holes = makeNoise(column.image.size(), 3) > 40;
    column.detector->setMaxFeatures(500);
    const Features expected = detectAndCompute(*column.detector, column.image, holes);
    ASSERT_EQ(500, expected.descriptors.rows);
    Mat part = holes.rowRange(100, 600);
    column.detector->detectAndCompute(column.image, holes, keypoints, part);
    EXPECT_TRUE(sameFeatures(expected, Features{keypoints, part}));
}

TEST(Aqorb_Aliasing, outputs_of_umat)
{
    const Column column;
    UMat m;
    column.image.copyTo(m);
    KeyPoints keypoints;
    column.detector->detectAndCompute(m, noArray(), keypoints, m);
    EXPECT_TRUE(sameFeatures(column.expected, Features{keypoints, m.getMat(ACCESS_READ)}));

    // Of another shape, so that the output lets go of the image while it is in use.
    const Mat scene = makeScene(Size(160, 120), 3);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(100);
    const Features expected = detectAndCompute(*detector, scene);
    UMat image;
    scene.copyTo(image);
    ASSERT_NO_THROW(detector->detectAndCompute(image, noArray(), keypoints, image));
    EXPECT_TRUE(sameFeatures(expected, Features{keypoints, image.getMat(ACCESS_READ)}));
    UMat mask(scene.size(), CV_8UC1, Scalar(1));
    ASSERT_NO_THROW(detector->detectAndCompute(scene, mask, keypoints, mask));
    EXPECT_TRUE(sameFeatures(expected, Features{keypoints, mask.getMat(ACCESS_READ)}));
    UMat flat(scene.size(), CV_8UC1, Scalar(7));
    ASSERT_NO_THROW(detector->detectAndCompute(flat, noArray(), keypoints, flat));
    EXPECT_TRUE(keypoints.empty() && flat.empty());
}

TEST(Aqorb_Aliasing, the_pyramid_in_the_vector_that_holds_the_image)
{
    const Mat scene = makeScene(Size(160, 120), 3);
    const int firstLevels[] = {0, 1, 3};
    for (int firstLevel : firstLevels)
    {
        SCOPED_TRACE(firstLevel);
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500, 1.2f, 4, 16, firstLevel);
        std::vector<Mat> expected;
        detector->buildPyramid(scene, expected);
        ASSERT_EQ(4u, expected.size());
        for (int place = 0; place < 6; place++)  // also beyond the levels
        {
            std::vector<Mat> levels(6);
            levels[place] = scene.clone();
            std::vector<UMat> ulevels(6);
            scene.copyTo(ulevels[place]);
            detector->buildPyramid(levels[place], levels);
            ASSERT_NO_THROW(detector->buildPyramid(ulevels[place], ulevels));
            ASSERT_EQ(4u, levels.size());
            ASSERT_EQ(4u, ulevels.size());
            for (int i = 0; i < 4; i++)
            {
                EXPECT_TRUE(sameMat(expected[i], levels[i]));
                EXPECT_TRUE(sameMat(expected[i], ulevels[i].getMat(ACCESS_READ)));
            }
        }
    }
}

// The image has no reference to the memory, which the output owns and gives up. To read it then is found by the address
// sanitizer for certain.
TEST(Aqorb_Aliasing, an_image_in_memory_that_the_output_gives_up)
{
    const Mat scene = makeScene(Size(160, 120), 3);
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(200, 1.2f, 4, 16, 1);
    const Features expected = detectAndCompute(*detector, scene);
    Mat descriptors = scene.clone();
    KeyPoints keypoints;
    detector->detectAndCompute(Mat(scene.size(), CV_8UC1, descriptors.data), noArray(), keypoints,
                               descriptors);
    EXPECT_TRUE(sameFeatures(expected, Features{keypoints, descriptors}));

    std::vector<Mat> levels(1, scene.clone()), expectedLevels;
    detector->buildPyramid(scene, expectedLevels);
    detector->buildPyramid(Mat(scene.size(), CV_8UC1, levels[0].data), levels);
    ASSERT_EQ(expectedLevels.size(), levels.size());
    for (size_t i = 0; i < levels.size(); i++)
        EXPECT_TRUE(sameMat(expectedLevels[i], levels[i]));

    // A vector grows from the image to the descriptor.
    detector->setEdgeThreshold(0);
    detector->setFirstLevel(0);
    std::vector<uchar> pixels;
    for (int i = 0; i < 20; i++)
        pixels.push_back(uchar(i * 77));
    keypoints.assign(1, KeyPoint(Point2f(10, 0), 31, 0));
    Mat descriptor;
    detector->compute(Mat(pixels, true).reshape(1, 1), keypoints, descriptor);
    ASSERT_EQ(1u, keypoints.size());
    detector->compute(pixels, keypoints, pixels);
    ASSERT_EQ(32u, pixels.size());
    EXPECT_TRUE(sameMat(descriptor, Mat(pixels, true).reshape(1, 1)));
}

TEST(Aqorb_Aliasing, the_pyramid_of_the_extractor_is_that_of_the_image)
{
    const Column column;
    // It returns up to one keypoint more for each of the three levels.
    aqorb::SlamExtractor extractor(Column::ROWS - 3, 1.2f, 3, 20, 5);
    KeyPoints keypoints;
    Mat descriptors;
    extractor.detector()->setEdgeThreshold(4);
    extractor(column.image, noArray(), keypoints, descriptors);
    ASSERT_EQ(int(Column::ROWS), descriptors.rows);
    std::vector<Mat> expected;
    for (const Mat& level : extractor.mvImagePyramid)
        expected.push_back(level.clone());
    ASSERT_EQ(3u, expected.size());

    Mat m = column.image.clone();
    extractor(m, noArray(), keypoints, m);
    EXPECT_TRUE(sameMat(descriptors, m));
    for (int i = 0; i < 3; i++)
        EXPECT_TRUE(sameMat(expected[i], extractor.mvImagePyramid[i])) << i;

    // a level of the last pyramid as the image
    extractor(extractor.mvImagePyramid[0], noArray(), keypoints, m);
    EXPECT_TRUE(sameMat(descriptors, m));
    EXPECT_TRUE(sameMat(expected[0], extractor.mvImagePyramid[0]));
}

}  // namespace
}  // namespace opencv_test
