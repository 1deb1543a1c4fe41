// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../common/median.hpp"
#include "subjects.hpp"

#include <opencv2/imgcodecs.hpp>

#include <limits>

void measureStereo(const StereoSequence& sequence, Method& method, int n, int seeds, Measurements& results)
{
    const int GAPS = 3, norm = method.norm(), frames = int(sequence.left.size());
    std::vector<Features> left, right;
    for (int i = 0; i < frames; i++)
    {
        left.push_back(method.compute(cv::imread(sequence.left[i], cv::IMREAD_GRAYSCALE), n));
        right.push_back(method.compute(cv::imread(sequence.right[i], cv::IMREAD_GRAYSCALE), n));
    }
    std::vector<StereoFrame> stereo(frames);
    cv::parallel_for_(cv::Range(0, frames),
                      [&](const cv::Range& range)
                      {
                          for (int i = range.start; i < range.end; i++)
                              stereo[i] = triangulate(sequence, left[i], right[i], norm);
                      });
    for (int gap = 1; gap <= GAPS; gap++)
    {
        for (int seed = 1; seed <= seeds; seed++)
        {
            std::vector<double> metres(std::max(frames - gap, 0)), degrees(metres.size());
            cv::parallel_for_(cv::Range(0, int(metres.size())),
                              [&](const cv::Range& range)
                              {
                                  for (int i = range.start; i < range.end; i++)
                                  {
                                      const OdometryStep step = estimateMotion(
                                          sequence, stereo[i], i, stereo[i + gap], i + gap, norm, seed);
                                      const double infinite = std::numeric_limits<double>::infinity();
                                      metres[i] = step.found ? step.metres : infinite;
                                      degrees[i] = step.found ? step.degrees : infinite;
                                  }
                              });
            const std::string item = cv::format("%d/%d", gap, seed);
            results.add({"stereo", item, method.name, n, "metres", tools::median(metres)});
            results.add({"stereo", item, method.name, n, "degrees", tools::median(degrees)});
        }
    }
}
