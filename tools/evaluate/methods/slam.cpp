// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

#include <opencv2/aqorb/slam.hpp>

namespace
{

//! SlamExtractor with the pyramid and the thresholds of ORB-SLAM's example settings.
class Slam : public Method
{
public:
    explicit Slam(const std::string& settings_) : settings(settings_) { extractor(1); }

    Features compute(const cv::Mat& image, int n) override
    {
        Features features;
        extractor(n)(image, cv::noArray(), features.keypoints, features.descriptors);
        return features;
    }

private:
    cv::aqorb::SlamExtractor& extractor(int n)
    {
        if (!last || n != lastN)
        {
            last = cv::makePtr<cv::aqorb::SlamExtractor>(n, 1.2f, 8, 20, 7);
            applySettings(*last->detector(), settings);
            lastN = n;
        }
        return *last;
    }

    const std::string settings;
    cv::Ptr<cv::aqorb::SlamExtractor> last;  // for lastN features
    int lastN = -1;
};

}  // namespace

cv::Ptr<Method> makeSlam(const std::string& settings)
{
    return cv::makePtr<Slam>(settings);
}
