// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include <opencv2/aqorb.hpp>
#include <opencv2/aqorb/slam.hpp>

#include <opencv2/imgcodecs.hpp>

#include <cstdio>

int main()
{
    cv::Mat noise(480, 640, CV_8UC1);
    cv::randu(noise, 0, 256);
    cv::imwrite("noise.png", noise);
    const cv::Mat image = cv::imread("noise.png", cv::IMREAD_GRAYSCALE);

    cv::Ptr<cv::ORB> orb = cv::aqorb::AdaptiveQuadtreeORB::create(300);
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    orb->detectAndCompute(image, cv::noArray(), keypoints, descriptors);

    std::printf("%d keypoints, occupancy %.2f\n", int(keypoints.size()),
                cv::aqorb::distributionOccupancy(keypoints, image.size()));
    return keypoints.size() == 300 && descriptors.rows == 300 ? 0 : 1;
}
