// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

#ifdef AQORB_HAVE_DLIB

#include <opencv2/imgproc.hpp>

#include <dlib/image_keypoint.h>
#include <dlib/opencv/cv_image.h>

namespace
{

class Surf : public Method
{
public:
    Features compute(const cv::Mat& image, int n) override
    {
        const cv::Mat gray = grayOf(image);
        // The strongest points come first. dlib drops points near the border, so half as many more are asked for.
        std::vector<dlib::surf_point> points = dlib::get_surf_points(dlib::cv_image<uchar>(gray), n + n / 2);
        points.resize(std::min(points.size(), size_t(n)));
        Features features;
        for (const dlib::surf_point& point : points)
        {
            const double degrees = point.angle * 180 / CV_PI;
            features.keypoints.emplace_back(
                float(point.p.center.x()), float(point.p.center.y()), float(20 * point.p.scale),
                float(degrees < 0 ? degrees + 360 : degrees), float(point.p.score));
            cv::Mat1f descriptor(1, 64);
            std::copy(point.des.begin(), point.des.end(), descriptor.begin());
            features.descriptors.push_back(descriptor);
        }
        return features;
    }

    int norm() const override { return cv::NORM_L2; }
};

}  // namespace

cv::Ptr<Method> makeSurf()
{
    return cv::makePtr<Surf>();
}

#else

cv::Ptr<Method> makeSurf()
{
    throw Absent{"built without dlib"};
}

#endif
