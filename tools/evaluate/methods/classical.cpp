// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

namespace
{

//! The best n features of a detector that does not take a number of features.
class BestOf : public Method
{
public:
    explicit BestOf(const cv::Ptr<cv::Feature2D>& detector_) : detector(detector_) {}

    Features compute(const cv::Mat& image, int n) override
    {
        Features features;
        detector->detect(image, features.keypoints);
        cv::KeyPointsFilter::retainBest(features.keypoints, n);
        detector->compute(image, features.keypoints, features.descriptors);
        return features;
    }

    int norm() const override { return detector->defaultNorm(); }

private:
    cv::Ptr<cv::Feature2D> detector;
};

}  // namespace

cv::Ptr<Method> makeSift()
{
    return cv::makePtr<Feature2DMethod>([](int n) { return cv::SIFT::create(n); });
}

cv::Ptr<Method> makeBrisk()
{
    return cv::makePtr<BestOf>(cv::BRISK::create());
}

cv::Ptr<Method> makeAkaze()
{
    return cv::makePtr<BestOf>(cv::AKAZE::create());
}
