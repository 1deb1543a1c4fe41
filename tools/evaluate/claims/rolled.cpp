// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../measures.hpp"
#include "subjects.hpp"

#include <opencv2/aqorb/geometry.hpp>

using opencv_test::Matches;

RolledImage rollImage(const cv::Mat& image, double degrees)
{
    const cv::Point2f centre(float(image.cols - 1) / 2, float(image.rows - 1) / 2);
    const cv::Mat turn = cv::getRotationMatrix2D(centre, degrees, 1);
    RolledImage rolled;
    cv::warpAffine(image, rolled.image, turn, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    rolled.homography = cv::Mat::eye(3, 3, CV_64F);
    turn.copyTo(rolled.homography.rowRange(0, 2));
    return rolled;
}

Matches matchesInCommonPart(const Matches& matches, const cv::Mat& homography, cv::Size sizeA, cv::Size sizeB)
{
    if (matches.from.empty())
        return matches;
    std::vector<cv::Point2f> forward, back;
    cv::perspectiveTransform(matches.from, forward, homography);
    cv::perspectiveTransform(matches.to, back, homography.inv());
    const auto shows = [](cv::Size size, const cv::Point2f& p)
    { return p.x >= 0 && p.y >= 0 && p.x <= float(size.width - 1) && p.y <= float(size.height - 1); };
    Matches common;
    for (size_t i = 0; i < forward.size(); i++)
    {
        if (!shows(sizeB, forward[i]) || !shows(sizeA, back[i]))
            continue;
        common.from.push_back(matches.from[i]);
        common.to.push_back(matches.to[i]);
    }
    return common;
}

void measureRolled(const std::string& name, const cv::Mat& image, Method& method, int n,
                   Measurements& results)
{
    const int ANGLES = 12;
    const Features upright = method.compute(image, n);
    std::vector<RolledImage> rolled;
    std::vector<Features> features;
    for (int i = 0; i < ANGLES; i++)
    {
        rolled.push_back(rollImage(image, 15 + 30 * i));
        features.push_back(method.compute(rolled.back().image, n));
    }
    const int norm = method.norm();
    std::vector<Matching> counts(ANGLES);
    cv::parallel_for_(cv::Range(0, ANGLES),
                      [&](const cv::Range& range)
                      {
                          for (int i = range.start; i < range.end; i++)
                          {
                              const cv::Mat& homography = rolled[i].homography;
                              const Matches matches =
                                  matchesInCommonPart(opencv_test::matchFeatures(upright, features[i], norm),
                                                      homography, image.size(), image.size());
                              counts[i] = countMatches(
                                  matches, opencv_test::correctMatches(matches, homography), image.size());
                          }
                      });
    for (int i = 0; i < ANGLES; i++)
    {
        const std::string item = name + cv::format("/%d", 15 + 30 * i);
        results.add({"rolled", item, method.name, n, "distinct", double(counts[i].distinct)});
        results.add({"rolled", item, method.name, n, "places", double(counts[i].places)});
        results.add({"rolled", item, method.name, n, "precision", counts[i].precision()});
    }
}
