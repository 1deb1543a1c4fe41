// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../common/median.hpp"
#include "subjects.hpp"

#include <opencv2/imgcodecs.hpp>

#include <limits>

namespace
{

struct Error
{
    double metres, degrees;
};

Error errorOf(const OdometryStep& step)
{
    const double infinite = std::numeric_limits<double>::infinity();
    return step.found ? Error{step.metres, step.degrees} : Error{infinite, infinite};
}

double medianOf(const std::vector<Error>& errors, double Error::*quantity)
{
    std::vector<double> values;
    for (const Error& error : errors)
        values.push_back(error.*quantity);
    return tools::median(values);
}

}  // namespace

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
        const int steps = std::max(frames - gap, 0);
        std::vector<std::vector<Error>> errors(seeds, std::vector<Error>(steps));
        cv::parallel_for_(cv::Range(0, steps),
                          [&](const cv::Range& range)
                          {
                              for (int i = range.start; i < range.end; i++)
                              {
                                  const StereoFrame &earlier = stereo[i], &later = stereo[i + gap];
                                  const std::vector<cv::DMatch> matches =
                                      matchFrames(earlier, later, *opencv_test::makeMatcher(norm, true));
                                  for (int seed = 1; seed <= seeds; seed++)
                                      errors[seed - 1][i] = errorOf(estimateMotion(
                                          sequence, earlier, i, later, i + gap, matches, seed));
                              }
                          });
        for (int seed = 1; seed <= seeds; seed++)
        {
            const std::vector<Error>& all = errors[seed - 1];
            std::vector<Error> resampled;
            cv::RNG random(seed);
            for (int i = 0; i < steps; i++)
                resampled.push_back(all[random.uniform(0, steps)]);
            const std::string item = cv::format("%d/%d", gap, seed);
            const auto add = [&](const char* quantity, double value) {
                results.add({"stereo", item, method.name, n, quantity, value});
            };
            add("metres", medianOf(all, &Error::metres));
            add("degrees", medianOf(all, &Error::degrees));
            add("metres, resampled", medianOf(resampled, &Error::metres));
            add("degrees, resampled", medianOf(resampled, &Error::degrees));
        }
    }
}
