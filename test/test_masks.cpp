// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <array>

namespace opencv_test
{
namespace
{

// Whether a keypoint of cv::ORB lies on a pixel of a level that is made of usable input pixels only.
class UsablePixels
{
public:
    UsablePixels(const Mat& mask_, const reference::Settings& settings) : mask(mask_), s(settings)
    {
        for (int i = 0; i < s.nlevels && !mask.empty(); i++)
        {
            const Size size =
                reference::levelSize(mask.size(), reference::levelScale(i, s.firstLevel, s.scaleFactor));
            if (size.area() == 0)
                break;
            if (i == s.firstLevel)
                levels.push_back(mask);
            else
                levels.push_back(reference::resizeMask(i <= s.firstLevel + 1 ? mask : levels[i - 1], size));
        }
    }
    bool contain(const KeyPoint& k) const
    {
        if (mask.empty())
            return true;
        const float scale = reference::levelScale(k.octave, s.firstLevel, s.scaleFactor);
        const Mat& level = levels[k.octave];
        const int x = cvRound(k.pt.x / scale), y = cvRound(k.pt.y / scale);
        Point2f position;
        if (s.subPixel)
            return level.at<uchar>(y, x) != 0;
        return level.at<uchar>(y, x) && reference::usablePosition(mask, x, y, level.size(), scale,
                                                                  s.edgeThreshold, s.subPixel, position);
    }

private:
    Mat mask;
    reference::Settings s;
    std::vector<Mat> levels;
};

struct Counts
{
    size_t orb, usable;  // keypoints of cv::ORB, and those of them on usable pixels
};

// Compares with cv::ORB and adds to the counts.
void expectNoFewerThanOrb(const reference::Settings& s, const Mat& image, const Mat& mask, Counts& counts)
{
    SCOPED_TRACE(s.text());
    KeyPoints ours, theirs;
    s.create()->detect(image, ours, mask);
    s.createOrb()->detect(image, theirs, mask);
    const UsablePixels pixels(mask, s);
    const auto isUsable = [&](const KeyPoint& k) { return pixels.contain(k); };
    const size_t usable = size_t(std::count_if(theirs.begin(), theirs.end(), isUsable));
    ASSERT_GE(ours.size(), std::min(size_t(s.nfeatures), usable));
    counts.orb += theirs.size();
    counts.usable += usable;
    for (const KeyPoint& k : ours)
        ASSERT_TRUE(mask.empty() || mask.at<uchar>(cvRound(k.pt.y), cvRound(k.pt.x)));
    if (ours.size() == size_t(s.nfeatures))
        return;
    // With room for all corners, each of these keypoints of cv::ORB is one.
    typedef std::array<int, 3> Pixel;
    const auto pixelOf = [&](const KeyPoint& k)
    {
        const float scale = reference::levelScale(k.octave, s.firstLevel, s.scaleFactor);
        const Pixel pixel = {{k.octave, cvRound(k.pt.y / scale), cvRound(k.pt.x / scale)}};
        return pixel;
    };
    std::vector<Pixel> found;
    for (const KeyPoint& k : ours)
        found.push_back(pixelOf(k));
    std::sort(found.begin(), found.end());
    for (const KeyPoint& k : theirs)
    {
        const Pixel pixel = pixelOf(k);
        ASSERT_TRUE(!isUsable(k) || std::binary_search(found.begin(), found.end(), pixel))
            << "octave " << pixel[0] << ", row " << pixel[1] << ", column " << pixel[2];
    }
}

// The only exception is a pixel of a level that is made of usable and unusable input pixels.
TEST(Aqorb_Masks, never_fewer_keypoints_than_orb_finds)
{
    const float factors[] = {1.2f, 1.5f, 2.f, 2.5f, 4.f};
    const int limits[] = {7, 60, 1000000};
    Counts counts = {0, 0};
    for (int seed = 1; seed <= 1200 && !HasFailure(); seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        reference::Settings s;
        s.firstLevel = seed % 4;
        s.nlevels = s.firstLevel + rng.uniform(1, 5);
        s.scaleFactor = factors[rng.uniform(0, s.firstLevel < 2 ? 5 : s.firstLevel < 3 ? 3 : 2)];
        s.fastThreshold = rng.uniform(0, rng.uniform(0, 2) ? 30 : 256);
        s.nfeatures = limits[rng.uniform(0, 3)];
        s.edgeThreshold = rng.uniform(0, 20);
        s.subPixel = rng.uniform(0, 3) != 0;
        s.scoreType = rng.uniform(0, 2) ? ORB::HARRIS_SCORE : ORB::FAST_SCORE;
        const Size size(rng.uniform(30, 90), rng.uniform(30, 90));
        const Mat image = randomImage(rng, size);
        const Mat mask = seed % 9 ? randomMask(rng, size) : Mat();
        // cv::ORB has no levels without pixels.
        const float last = reference::levelScale(s.nlevels - 1, s.firstLevel, s.scaleFactor);
        if (std::min(size.width, size.height) >= 2 * last)
            expectNoFewerThanOrb(s, image, mask, counts);
    }
    EXPECT_GT(counts.usable, 10000u);
    EXPECT_GT(counts.orb, counts.usable);
}

}  // namespace
}  // namespace opencv_test
