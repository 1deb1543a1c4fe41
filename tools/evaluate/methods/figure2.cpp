// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

#include "detection.hpp"
#include "orientation.hpp"
#include "levels.hpp"
#include "threshold.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/imgproc.hpp>

// The paper's Figure 2 read to the letter, made of this module's stages: each leaf of the quadtree keeps the
// corner with its highest Harris response. Where that leaves more corners than features are asked for, those
// with the highest responses of all stay. No leaf gives a second corner.

namespace
{

using namespace cv::aqorb;

const int LEVELS = 8, EDGE = 16, CELL = 35, PATCH_SIZE = 31, FAST_THRESHOLD = 20;
const double SCALE_FACTOR = 1.2f, MIN_RATIO = 4;

class Figure2 : public Method
{
public:
    Features compute(const cv::Mat& image, int n) override
    {
        const cv::Mat gray = grayOf(image);
        const Thresholds thresholds =
            fastThresholds(varianceOverMean(gray, cv::Mat()), FAST_THRESHOLD, MIN_RATIO);
        const std::vector<int> quotas = levelQuotas(n, SCALE_FACTOR, LEVELS);
        Level input;
        input.image = gray;
        Levels levels;
        levels.reset(input, 0, SCALE_FACTOR, false);
        Features features;
        for (int i = 0, count = levels.layOut(LEVELS, 2 * EDGE + 1); i < count; i++)
        {
            levels.make(i);
            const Level& level = levels[i];
            for (const CornerResponse& corner : choose(level, thresholds, quotas[i]))
            {
                FeaturePoint point = {corner.x, corner.y, 0};
                orientations(level.image, circle, &point, 1);
                features.keypoints.emplace_back(corner.x * level.scale, corner.y * level.scale,
                                                PATCH_SIZE * level.scale, point.angle, corner.response, i);
            }
        }
        describe->compute(gray, features.keypoints, features.descriptors);
        return features;
    }

private:
    static std::vector<CornerResponse> choose(const Level& level, Thresholds thresholds, int quota)
    {
        const cv::Rect region(EDGE, EDGE, level.image.cols - 2 * EDGE, level.image.rows - 2 * EDGE);
        const DetectionRules rules = {{thresholds, CELL, true, false}, true, 0};
        LevelPlan plan = LevelPlan();
        plan.root = region;
        plan.depth = quadtreeDepth(quota);
        LevelDetection detection;
        DetectionScratch scratch;
        detection.reset(level, region, rules, 1);
        std::vector<CornerResponse> corners = detection.ordered(plan, scratch);
        std::stable_sort(corners.begin(), corners.end(),
                         [](const CornerResponse& a, const CornerResponse& b)
                         { return a.response > b.response; });

        const int side = 1 << quadtreeDepth(quota);
        cv::Mat1b taken(side, side, uchar(0));
        std::vector<CornerResponse> chosen;
        for (const CornerResponse& corner : corners)
        {
            uchar& leaf = taken((corner.y - region.y) * side / region.height,
                                (corner.x - region.x) * side / region.width);
            if (leaf || int(chosen.size()) >= quota)
                continue;
            leaf = 1;
            chosen.push_back(corner);
        }
        return chosen;
    }

    const OrientationPatch circle{circularPatch(PATCH_SIZE)};
    cv::Ptr<cv::ORB> describe = cv::aqorb::AdaptiveQuadtreeORB::create();
};

}  // namespace

cv::Ptr<Method> makeFigure2()
{
    return cv::makePtr<Figure2>();
}
