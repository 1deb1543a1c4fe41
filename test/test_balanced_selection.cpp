// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

// BALANCED_SELECTION is promised to give what version 0.1 gave, to the byte. The hashes were made by version 0.1. The
// images are drawn here by whole numbers alone, so that no version of OpenCV draws them otherwise.

namespace opencv_test
{
namespace
{

using reference::Settings;

//! FNV-1a of 64 bits.
class Hash
{
public:
    Hash() : state(0xcbf29ce484222325u) {}
    void add(const void* data, size_t size)
    {
        const uchar* bytes = static_cast<const uchar*>(data);
        for (size_t i = 0; i < size; i++)
            state = (state ^ bytes[i]) * 0x100000001b3u;
    }
    void add(const Mat& mat)
    {
        for (int y = 0; y < mat.rows; y++)
            add(mat.ptr(y), mat.cols * mat.elemSize());
    }
    std::string text() const { return format("%08x%08x", unsigned(state >> 32), unsigned(state)); }

private:
    uint64 state;
};

std::string hashOf(const Mat& mat)
{
    Hash hash;
    hash.add(mat);
    return hash.text();
}

std::string hashOf(const Features& features)
{
    Hash hash;
    hash.add(features.keypoints.data(), features.keypoints.size() * sizeof(KeyPoint));
    hash.add(features.descriptors);
    return hash.text();
}

//! Discs and boxes of all greys on a slope, with noise that is strong on the left.
Mat drawScene(Size size, int seed)
{
    RNG rng(seed);
    Mat image(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
            image.at<uchar>(y, x) = uchar(80 + 70 * x / size.width + 40 * y / size.height);
    }
    for (int i = size.area() / 500; i > 0; i--)
    {
        const int centerX = rng.uniform(0, size.width), centerY = rng.uniform(0, size.height);
        const int radius = rng.uniform(1, 14), grey = rng.uniform(0, 256), isDisc = rng.uniform(0, 2);
        for (int y = std::max(centerY - radius, 0); y < std::min(centerY + radius, size.height); y++)
        {
            for (int x = std::max(centerX - radius, 0); x < std::min(centerX + radius, size.width); x++)
            {
                const int dx = x - centerX, dy = y - centerY;
                if (!isDisc || dx * dx + dy * dy < radius * radius)
                    image.at<uchar>(y, x) = uchar(grey);
            }
        }
    }
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
        {
            const int noise = x < size.width / 3 ? 20 : 3;
            const int grey = image.at<uchar>(y, x) + rng.uniform(-noise, noise + 1);
            image.at<uchar>(y, x) = uchar(std::min(std::max(grey, 0), 255));
        }
    }
    return image;
}

//! A mask with a masked half, in which there are holes, and with holes in the other half.
Mat drawMask(Size size)
{
    Mat mask(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
        {
            const bool isHole = (x % 41) * (x % 41) + (y % 53) * (y % 53) < 200;
            mask.at<uchar>(y, x) = uchar((x < size.width / 2) != isHole ? 7 : 0);
        }
    }
    return mask;
}

void expectHash(const char* expected, const Settings& settings, const Mat& image, const Mat& mask = Mat())
{
    const Features features = detectAndCompute(*settings.create(), image, mask);
    EXPECT_GT(features.keypoints.size(), 0u);
    EXPECT_EQ(expected, hashOf(features));
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
    EXPECT_EQ("b21bd0ef6094b12b", hashOf(drawScene(SIZE, 1)));
    EXPECT_EQ("4f9a8020c953d4c9", hashOf(drawScene(SIZE, 2)));
    EXPECT_EQ("7736fadc8aa96849", hashOf(drawMask(SIZE)));
}

TEST(Aqorb_BalancedSelection, gives_the_bytes_of_version_0_1_by_default)
{
    const Settings settings = balancedSettings();
    expectHash("8836ffbdb080db52", settings, drawScene(SIZE, 1));
    expectHash("24dc758fe70c1e18", settings, drawScene(SIZE, 2));
    expectHash("665ef83800b6255f", settings, drawScene(Size(SIZE.height, SIZE.width), 3));
    expectHash("817077cc42b45374", settings, drawScene(SIZE, 1), drawMask(SIZE));
    expectHash("36efe1cdc630e822", settings, drawScene(Size(71, 64), 4));
}

TEST(Aqorb_BalancedSelection, gives_the_bytes_of_version_0_1_for_other_numbers_of_features)
{
    const int numbers[] = {1, 7, 60, 1000, 100000};
    const char* const hashes[] = {"9d51cfa5e89115ef", "2b853d93e8fc3681", "d38f4b4b8dff96d1",
                                  "b7a9ad603df10e7c", "cb8bca3a8915ed9a"};
    for (int i = 0; i < 5; i++)
    {
        SCOPED_TRACE(numbers[i]);
        Settings settings = balancedSettings();
        settings.nfeatures = numbers[i];
        expectHash(hashes[i], settings, drawScene(SIZE, 5));
    }
}

TEST(Aqorb_BalancedSelection, gives_the_bytes_of_version_0_1_for_other_parameters)
{
    const Mat image = drawScene(SIZE, 6), mask = drawMask(SIZE);
    Settings settings = balancedSettings();
    settings.scoreType = ORB::FAST_SCORE;
    expectHash("7fad780e143222f1", settings, image);
    settings = balancedSettings();
    settings.maxDepth = 0;
    expectHash("d90bb4b44fe9b89c", settings, image);
    settings.maxDepth = 15;
    expectHash("75db0bcb4db42134", settings, image, mask);
    settings = balancedSettings();
    settings.octaveSuppression = 0.5;  // what -1 stands for
    expectHash("29f1e6d47e5991bb", settings, image);
    settings.octaveSuppression = 0;
    expectHash("ee503437d5f9bac8", settings, image);
    settings.octaveSuppression = 6;
    expectHash("bca11882e824f1ca", settings, image, mask);
    settings = balancedSettings();
    settings.scaleFactor = 1.5f;
    settings.nlevels = 5;
    settings.firstLevel = 1;
    settings.edgeThreshold = 5;
    settings.WTA_K = 4;
    expectHash("1ce69374ac8692b2", settings, image, mask);
    settings = balancedSettings();
    settings.nlevels = 1;
    settings.patchSize = 21;
    settings.WTA_K = 3;
    settings.subPixel = false;
    expectHash("e8d94baf96f5ddda", settings, image);
    settings = balancedSettings();
    settings.adaptiveThreshold = false;
    settings.fastThreshold = 12;
    settings.minThresholdRatio = 2;
    settings.cellSize = 20;
    expectHash("921dd5603634772f", settings, image);
}

// The dial and the radius are for the other selection alone.
TEST(Aqorb_BalancedSelection, does_not_depend_on_strength_weight_and_rank_radius)
{
    const Mat image = drawScene(SIZE, 1);
    for (double value : {0., 0.5, 16.})
    {
        SCOPED_TRACE(value);
        Settings settings = balancedSettings();
        settings.strengthWeight = settings.rankRadius = value;
        expectHash("8836ffbdb080db52", settings, image);
    }
}

}  // namespace
}  // namespace opencv_test
