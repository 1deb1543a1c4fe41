// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "hash.hpp"
#include "reference.hpp"

// BALANCED_SELECTION is promised to give what version 0.1 gave, to the byte. The hashes were made by version 0.1. The
// images are drawn here by whole numbers alone, so that no version of OpenCV draws them otherwise.

namespace opencv_test
{
namespace
{

using reference::Settings;

//! A mask with a masked half, in which there are holes, and with holes in the other half.
Mat drawMask(Size size)
{
    Mat mask(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
        {
            const bool isHole = (x % 41) * (x % 41) + (y % 53) * (y % 53) < 200;
            mask.at<uchar>(y, x) = uchar((x < size.width / 2) != isHole ? 7 : 0);
        }
    return mask;
}

void expectHash(const char* expected, const Settings& settings, const Mat& image, const Mat& mask = Mat())
{
    const Features features = detectAndCompute(*settings.create(), image, mask);
    EXPECT_GT(features.keypoints.size(), 0u);
    Hash hash;
    hash.add(features.keypoints);
    hash.add(features.descriptors);
    EXPECT_EQ(expected, hash.text());
}

const Size SIZE(300, 220);

Settings balancedSettings()
{
    Settings settings;
    settings.selectionType = AdaptiveQuadtreeORB::BALANCED_SELECTION;
    return settings;
}

TEST(Aqorb_BalancedSelection, images_are_drawn_as_they_were)
{
    EXPECT_EQ("267b27acc3644926", hashOf(makeIntegerScene(SIZE, 1)));
    EXPECT_EQ("2d56131644821bfa", hashOf(makeIntegerScene(SIZE, 2)));
    EXPECT_EQ("082a6579ca36c5fe", hashOf(drawMask(SIZE)));
}

TEST(Aqorb_BalancedSelection, gives_the_bytes_of_version_0_1_by_default)
{
    const Settings settings = balancedSettings();
    expectHash("7a10f274378e2b9b", settings, makeIntegerScene(SIZE, 1));
    expectHash("8b188b939b81a8d9", settings, makeIntegerScene(SIZE, 2));
    expectHash("69710db72c5a7353", settings, makeIntegerScene(Size(SIZE.height, SIZE.width), 3));
    expectHash("5eacacf485f7a902", settings, makeIntegerScene(SIZE, 1), drawMask(SIZE));
    expectHash("0524c62cbe8c9e0c", settings, makeIntegerScene(Size(71, 64), 4));
}

TEST(Aqorb_BalancedSelection, gives_the_bytes_of_version_0_1_for_other_numbers_of_features)
{
    const int numbers[] = {1, 7, 60, 1000, 100000};
    const char* const hashes[] = {"2930fcf7baf4f085", "b960e8f2aa9908bc", "dfa9461154f61151",
                                  "b8970979eb72ffb7", "ddb528bd15ebcd76"};
    for (int i = 0; i < 5; i++)
    {
        SCOPED_TRACE(numbers[i]);
        Settings settings = balancedSettings();
        settings.nfeatures = numbers[i];
        expectHash(hashes[i], settings, makeIntegerScene(SIZE, 5));
    }
}

TEST(Aqorb_BalancedSelection, gives_the_bytes_of_version_0_1_for_other_parameters)
{
    const Mat image = makeIntegerScene(SIZE, 6), mask = drawMask(SIZE);
    Settings settings = balancedSettings();
    settings.scoreType = ORB::FAST_SCORE;
    expectHash("e3130240aa83a853", settings, image);
    settings = balancedSettings();
    settings.maxDepth = 0;
    expectHash("572b4b9abe95bab0", settings, image);
    settings.maxDepth = 15;
    expectHash("a3fb30a6dfe44928", settings, image, mask);
    settings = balancedSettings();
    settings.octaveSuppression = 0.5;  // what -1 stands for
    expectHash("f1966732afd42a75", settings, image);
    settings.octaveSuppression = 0;
    expectHash("5a3b0084f9b7c045", settings, image);
    settings.octaveSuppression = 6;
    expectHash("cc1d3268065f05bd", settings, image, mask);
    settings = balancedSettings();
    settings.scaleFactor = 1.5f;
    settings.nlevels = 5;
    settings.firstLevel = 1;
    settings.edgeThreshold = 5;
    settings.WTA_K = 4;
    expectHash("d6187b6bb7c361e8", settings, image, mask);
    settings = balancedSettings();
    settings.nlevels = 1;
    settings.patchSize = 21;
    settings.WTA_K = 3;
    settings.subPixel = false;
    expectHash("ad44acd24a2ed301", settings, image);
    settings = balancedSettings();
    settings.adaptiveThreshold = false;
    settings.fastThreshold = 12;
    settings.minThresholdRatio = 2;
    settings.cellSize = 20;
    expectHash("202d208995674295", settings, image);
}

// The dial and the radius are for the other selection alone.
}  // namespace
}  // namespace opencv_test
