// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../measures.hpp"
#include "subjects.hpp"

#include <opencv2/aqorb.hpp>

using opencv_test::Matches;

namespace
{

//! What is measured of a pair of images.
struct PairMeasures
{
    Matching counts;
    double areaUnderCurve;  // negative: not measured
};

PairMeasures measurePair(const Matches& matches, const std::vector<size_t>& correct,
                         const cv::Mat& homography, cv::Size size, int seeds)
{
    PairMeasures measures = {countMatches(matches, correct, size), -1};
    if (!homography.empty() && seeds > 0)
        measures.areaUnderCurve = areaUnderCurve(homographyErrors(matches, homography, size, seeds), 5);
    return measures;
}

void addPair(const std::string& subject, const std::string& item, const Method& method, int n,
             const PairMeasures& measures, Measurements& results)
{
    const Matching& counts = measures.counts;
    results.add({subject, item, method.name, n, "distinct", double(counts.distinct)});
    results.add({subject, item, method.name, n, "places", double(counts.places)});
    results.add({subject, item, method.name, n, "precision", counts.precision()});
    if (measures.areaUnderCurve >= 0)
        results.add({subject, item, method.name, n, "auc5", measures.areaUnderCurve});
}

//! Features of several images, one after the other: a method keeps its detector.
std::vector<Features> computeAll(const std::vector<cv::Mat>& images, Method& method, int n)
{
    std::vector<Features> features;
    for (const cv::Mat& image : images)
        features.push_back(method.compute(image, n));
    return features;
}

void addUniformity(const std::string& subject, const ImageSet& set, const std::vector<Features>& features,
                   const Method& method, int n, Measurements& results)
{
    for (size_t i = 0; i < set.images.size(); i++)
    {
        const std::string item = set.name + cv::format("/%d", int(i + 1));
        const std::vector<cv::KeyPoint>& keypoints = features[i].keypoints;
        const cv::Size size = set.images[i].size();
        results.add({subject, item, method.name, n, "uniformity",
                     cv::aqorb::distributionUniformity(keypoints, size)});
        results.add(
            {subject, item, method.name, n, "occupancy", cv::aqorb::distributionOccupancy(keypoints, size)});
    }
}

}  // namespace

void measureUniformity(const std::string& subject, const ImageSet& set, Method& method, int n,
                       Measurements& results)
{
    addUniformity(subject, set, computeAll(set.images, method, n), method, n, results);
}

void measureSet(const std::string& subject, const ImageSet& set, Method& method, int n, int seeds,
                Measurements& results)
{
    const std::vector<Features> features = computeAll(set.images, method, n);
    addUniformity(subject, set, features, method, n, results);
    const int norm = method.norm();
    std::vector<PairMeasures> measures(set.images.size());
    cv::parallel_for_(cv::Range(1, int(set.images.size())),
                      [&](const cv::Range& range)
                      {
                          for (int i = range.start; i < range.end; i++)
                          {
                              const cv::Mat& homography = set.homographies[i];
                              const Matches matches =
                                  opencv_test::matchFeatures(features[0], features[i], norm);
                              measures[i] =
                                  measurePair(matches, opencv_test::correctMatches(matches, homography),
                                              homography, set.images[0].size(), seeds);
                          }
                      });
    for (size_t i = 1; i < set.images.size(); i++)
        addPair(subject, set.name + cv::format("/1-%d", int(i + 1)), method, n, measures[i], results);
}

void measureHeldOut(const std::vector<ImagePair>& pairs, Method& method, int n, int seeds,
                    Measurements& results)
{
    std::vector<Features> first, second;
    for (const ImagePair& pair : pairs)
    {
        first.push_back(method.compute(pair.first, n));
        second.push_back(method.compute(pair.second, n));
    }
    const int norm = method.norm();
    std::vector<PairMeasures> measures(pairs.size());
    cv::parallel_for_(cv::Range(0, int(pairs.size())),
                      [&](const cv::Range& range)
                      {
                          for (int i = range.start; i < range.end; i++)
                          {
                              const ImagePair& pair = pairs[i];
                              const Matches matches = opencv_test::matchFeatures(first[i], second[i], norm);
                              const std::vector<size_t> correct =
                                  pair.homography.empty()
                                      ? opencv_test::matchesOnEpipolarLines(matches, pair.fundamental)
                                      : opencv_test::correctMatches(matches, pair.homography);
                              measures[i] =
                                  measurePair(matches, correct, pair.homography, pair.first.size(), seeds);
                          }
                      });
    for (size_t i = 0; i < pairs.size(); i++)
        addPair("held-out", pairs[i].name, method, n, measures[i], results);
}
