// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include <opencv2/aqorb.hpp>
#include <opencv2/aqorb/slam.hpp>

#include <opencv2/imgcodecs.hpp>

#include <cstdio>
#include <limits>

// Writes the results to a file, so that the tests can compare programs built in different ways.
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
    std::vector<cv::DMatch> matches;
    std::vector<cv::Point2f> points1, points2;
    cv::aqorb::HammingMatcher(cv::NORM_HAMMING, true).match(descriptors, descriptors, matches);
    cv::aqorb::refineMatches(image, keypoints, image, keypoints, matches, points1, points2);
    cv::FileStorage results("results.yml", cv::FileStorage::WRITE);
    results << "keypoints" << keypoints << "descriptors" << descriptors << "points" << points2;

    bool isNanRefused = false;
    std::vector<cv::KeyPoint> given(keypoints);
    given[0].angle = std::numeric_limits<float>::quiet_NaN();
    try
    {
        orb->compute(image, given, descriptors);
    }
    catch (const cv::Exception&)
    {
        isNanRefused = true;
    }
    std::printf("%d keypoints, occupancy %.2f, %d refined matches, NaN %s\n", int(keypoints.size()),
                cv::aqorb::distributionOccupancy(keypoints, image.size()), int(matches.size()),
                isNanRefused ? "refused" : "accepted");
    return keypoints.size() == 300 && isNanRefused ? 0 : 1;
}
