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

TEST(Aqorb_Masks, positions_off_the_pixels_a_level_is_made_of)
{
    // Without SubPixel, and with large steps of the pyramid, a position may round to a pixel that is not
    // one of those that the level's pixel was made of: the mask must be looked up there, too.
    const Mat image = makeNoise(Size(200, 160), 4);
    Mat mask(image.size(), CV_8UC1, Scalar(1));
    RNG rng(9);
    for (int i = 0; i < 1500; i++)
        mask.at<uchar>(rng.uniform(0, mask.rows), rng.uniform(0, mask.cols)) = 0;
    const float factors[] = {1.2f, 1.5f, 2.f, 2.7f, 4.f};
    for (float factor : factors)
        for (int subPixel = 0; subPixel <= 1; subPixel++)
        {
            reference::Settings settings;
            settings.nfeatures = 4000;
            settings.scaleFactor = factor;
            settings.nlevels = 4;
            settings.edgeThreshold = 3;
            settings.subPixel = subPixel != 0;
            SCOPED_TRACE(format("scaleFactor %g, sub-pixel %d", factor, subPixel));
            const Features features = detectAndCompute(*settings.create(), image, mask);
            EXPECT_GT(features.keypoints.size(), 300u);
            for (const KeyPoint& keypoint : features.keypoints)
                ASSERT_NE(0, mask.at<uchar>(cvRound(keypoint.pt.y), cvRound(keypoint.pt.x)))
                    << "octave " << keypoint.octave;
            EXPECT_TRUE(sameFeatures(features, reference::detectAndCompute(image, mask, settings)));
        }
}

// Random pixels, dots, lines or rectangles that may be used or may not.
Mat maskOfKind(RNG& rng, Size size, int kind)
{
    Mat mask(size, CV_8UC1, Scalar(kind % 2 ? 0 : 255));
    const Scalar value(kind % 2 ? 255 : 0);
    const int counts[] = {size.area() / 80, 40, 12, 8};
    for (int i = rng.uniform(1, counts[kind / 2] + 1); i > 0; i--)
    {
        const Point p(rng.uniform(0, size.width), rng.uniform(0, size.height));
        const Point q(rng.uniform(0, size.width), rng.uniform(0, size.height));
        switch (kind / 2)
        {
        case 0:
            mask.at<uchar>(p) = uchar(value[0]);
            break;
        case 1:
            circle(mask, p, rng.uniform(0, 9), value, -1);
            break;
        case 2:
            line(mask, p, q, value, rng.uniform(1, 9));
            break;
        default:
            rectangle(mask, p, q, value, -1);
        }
    }
    return mask;
}

const int MASK_KINDS = 8;

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
    const int thresholds[] = {0, 1, 5, 20, 60}, limits[] = {7, 60, 1000000};
    Counts counts = {0, 0};
    for (int seed = 1; seed <= 1200 && !HasFailure(); seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        reference::Settings s;
        s.firstLevel = seed % 4;
        s.nlevels = s.firstLevel + rng.uniform(1, 5);
        s.scaleFactor = factors[rng.uniform(0, s.firstLevel < 2 ? 5 : s.firstLevel < 3 ? 3 : 2)];
        s.fastThreshold = thresholds[rng.uniform(0, 5)];
        s.nfeatures = limits[rng.uniform(0, 3)];
        s.edgeThreshold = rng.uniform(0, 20);
        s.subPixel = rng.uniform(0, 3) != 0;
        s.scoreType = rng.uniform(0, 2) ? ORB::HARRIS_SCORE : ORB::FAST_SCORE;
        const Size size(rng.uniform(30, 90), rng.uniform(30, 90));
        const Mat image = rng.uniform(0, 2) ? makeScene(size, seed) : makeNoise(size, seed);
        const Mat mask = seed % 9 ? maskOfKind(rng, size, rng.uniform(0, MASK_KINDS)) : Mat();
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
