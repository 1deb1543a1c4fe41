// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../../test/geometry.hpp"
#include "../measures.hpp"
#include "subjects.hpp"

using opencv_test::Matches;

namespace
{

//! An image that shows a scene again, and where the points of the first one are in it.
struct View
{
    std::string item;
    cv::Mat image, homography;
};

//! An image rolled about its centre, on a canvas of the same size. The corners are filled by reflection.
View rolledView(const std::string& item, const cv::Mat& image, double degrees)
{
    const cv::Point2f centre(float(image.cols - 1) / 2, float(image.rows - 1) / 2);
    const cv::Mat turn = cv::getRotationMatrix2D(centre, degrees, 1);
    View rolled = {item, cv::Mat(), cv::Mat::eye(3, 3, CV_64F)};
    cv::warpAffine(image, rolled.image, turn, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
    turn.copyTo(rolled.homography.rowRange(0, 2));
    return rolled;
}

/** Those of the matches that lie, by the known homography, where both images show the scene: not where a canvas was
 filled. */
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

void measureViews(const std::string& subject, const cv::Mat& image, const std::vector<View>& views,
                  Method& method, int n, Measurements& results)
{
    const Features first = method.compute(image, n);
    std::vector<Features> features;
    for (const View& view : views)
        features.push_back(method.compute(view.image, n));
    const int norm = method.norm(), count = int(views.size());
    std::vector<Matching> counts(views.size());
    cv::parallel_for_(cv::Range(0, count),
                      [&](const cv::Range& range)
                      {
                          for (int i = range.start; i < range.end; i++)
                          {
                              const View& view = views[i];
                              const Matches matches =
                                  matchesInCommonPart(opencv_test::matchFeatures(first, features[i], norm),
                                                      view.homography, image.size(), view.image.size());
                              counts[i] =
                                  countMatches(matches, opencv_test::correctMatches(matches, view.homography),
                                               image.size());
                          }
                      });
    for (size_t i = 0; i < views.size(); i++)
    {
        results.add({subject, views[i].item, method.name, n, "distinct", double(counts[i].distinct)});
        results.add({subject, views[i].item, method.name, n, "places", double(counts[i].places)});
        results.add({subject, views[i].item, method.name, n, "precision", counts[i].precision()});
    }
}

}  // namespace

void measureRolled(const std::string& subject, const std::string& name, const cv::Mat& image,
                   const std::vector<int>& angles, double scale, Method& method, int n, Measurements& results)
{
    const ScaledImage scaled = scaleImage(image, scale);
    std::vector<View> views;
    for (const int angle : angles)
    {
        views.push_back(rolledView(name + cv::format("/%d", angle), scaled.image, angle));
        views.back().homography = views.back().homography * scaled.homography;
    }
    measureViews(subject, image, views, method, n, results);
}

std::string subjectOfScale(double scale)
{
    return cv::format("scale %g", scale);
}

void measureScaled(const std::string& name, const cv::Mat& image, const std::vector<double>& scales,
                   Method& method, int n, Measurements& results)
{
    for (const double scale : scales)
    {
        const ScaledImage scaled = scaleImage(image, scale);
        measureViews(subjectOfScale(scale), image, {{name, scaled.image, scaled.homography}}, method, n,
                     results);
    }
}
