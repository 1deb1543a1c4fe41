// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../../test/start_matches.hpp"
#include "subjects.hpp"

#include <opencv2/imgcodecs.hpp>

using opencv_test::PointPair;

namespace
{

//! Whether a match is within 2 pixels of the line on which the motion between two frames puts its point.
bool agrees(const PointPair& match, const cv::Matx33d& fundamental)
{
    const cv::Vec3d line = fundamental * cv::Vec3d(match.from.x, match.from.y, 1);
    return std::abs(line.dot(cv::Vec3d(match.to.x, match.to.y, 1))) <= 2 * std::hypot(line[0], line[1]);
}

cv::Matx33d fundamentalOf(const StereoSequence& sequence, int from, int to)
{
    const cv::Matx44d motion = sequence.poses[to].inv() * sequence.poses[from];
    const cv::Vec3d t(motion(0, 3), motion(1, 3), motion(2, 3));
    const cv::Matx33d cross(0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0);
    return sequence.camera.inv().t() * cross * motion.get_minor<3, 3>(0, 0) * sequence.camera.inv();
}

}  // namespace

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
            const cv::Matx33d fundamental = fundamentalOf(sequence, i, i + step);
            const auto correct =
                std::count_if(matches[i].begin(), matches[i].end(),
                              [&](const PointPair& match) { return agrees(match, fundamental); });
            results.add({"start", item, method.name, n, "matches", double(matches[i].size())});
            results.add({"start", item, method.name, n, "correct", double(correct)});
        }
    }
}
