// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

// FAST corners thinned out by suppression via square covering: Bailo, Rameau, Joo, Park, Bogdan, Kweon,
// "Efficient adaptive non-maximal suppression algorithms for homogeneous spatial keypoint distribution",
// Pattern Recognition Letters 106 (2018). Written from the paper.

namespace
{

/** Takes the keypoints from the best on; each one taken covers the square of half side `width` around it, and
 keypoints on covered ground are left out. As in the paper, the cover is a grid of cells of half that size. */
std::vector<cv::KeyPoint> coverSquares(const std::vector<cv::KeyPoint>& sorted, cv::Size size, double width)
{
    const double cell = width / 2;
    const int reach = 2;  // width in cells
    cv::Mat1b covered(int(size.height / cell) + 1, int(size.width / cell) + 1, uchar(0));
    const cv::Rect grid(0, 0, covered.cols, covered.rows);
    std::vector<cv::KeyPoint> kept;
    for (const cv::KeyPoint& point : sorted)
    {
        const int column = int(point.pt.x / cell), row = int(point.pt.y / cell);
        if (covered(row, column))
            continue;
        kept.push_back(point);
        covered(cv::Rect(column - reach, row - reach, 2 * reach + 1, 2 * reach + 1) & grid) = 1;
    }
    return kept;
}

//! Thins the keypoints out at the largest width that leaves at least n of them, and keeps the best n.
void suppressViaSquareCovering(std::vector<cv::KeyPoint>& keypoints, cv::Size size, int n)
{
    if (int(keypoints.size()) <= n)
        return;
    std::stable_sort(keypoints.begin(), keypoints.end(),
                     [](const cv::KeyPoint& a, const cv::KeyPoint& b) { return a.response > b.response; });
    double low = 1, high = std::max(size.width, size.height);
    std::vector<cv::KeyPoint> best = keypoints;
    while (high - low > 0.25)
    {
        const double width = (low + high) / 2;
        std::vector<cv::KeyPoint> kept = coverSquares(keypoints, size, width);
        if (int(kept.size()) >= n)
        {
            best.swap(kept);
            low = width;
        }
        else
            high = width;
    }
    best.resize(n);
    keypoints.swap(best);
}

//! The FAST corners of cv::ORB's pyramid, thinned out, with ORB's descriptors.
class Ssc : public Method
{
public:
    Features compute(const cv::Mat& image, int n) override
    {
        Features features;
        detector->detect(image, features.keypoints);
        suppressViaSquareCovering(features.keypoints, image.size(), n);
        detector->compute(image, features.keypoints, features.descriptors);
        return features;
    }

private:
    // The number of features is larger than any number of corners, so that all corners are kept.
    cv::Ptr<cv::ORB> detector = cv::ORB::create(1000000, 1.2f, 8, 31, 0, 2, cv::ORB::FAST_SCORE);
};

}  // namespace

cv::Ptr<Method> makeSsc()
{
    return cv::makePtr<Ssc>();
}
