// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../../test/start_matches.hpp"
#include "subjects.hpp"

#include <opencv2/imgcodecs.hpp>

using opencv_test::PointPair;

void measureStart(const StereoSequence& sequence, Method& method, int n, Measurements& results)
{
    const int frames = int(sequence.left.size());
    std::vector<Features> finest;
    for (const std::string& file : sequence.left)
        finest.push_back(opencv_test::finestLevel(method.compute(cv::imread(file, cv::IMREAD_GRAYSCALE), n)));
    for (const int step : {1, 10})
    {
        const int pairs = std::max(frames - step, 0);
        std::vector<std::vector<PointPair>> matches(pairs);
        cv::parallel_for_(cv::Range(0, pairs),
                          [&](const cv::Range& range)
                          {
                              for (int i = range.start; i < range.end; i++)
                                  matches[i] = opencv_test::matchToStart(finest[i], finest[i + step]);
                          });
        for (int i = 0; i < pairs; i++)
        {
            const std::string item = cv::format("%d/%d", step, i);
            const cv::Matx33d fundamental = opencv_test::fundamentalMatrix(
                sequence.camera, sequence.poses[i + step].inv() * sequence.poses[i]);
            const auto correct = std::count_if(matches[i].begin(), matches[i].end(),
                                               [&](const PointPair& match)
                                               { return opencv_test::isOnEpipolarLine(match, fundamental); });
            results.add({"start", item, method.name, n, "matches", double(matches[i].size())});
            results.add({"start", item, method.name, n, "correct", double(correct)});
        }
    }
}
