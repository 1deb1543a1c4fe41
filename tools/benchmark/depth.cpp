// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// aqorb_depth IMAGE ...: time that equation (9) saves against a depth of 15, for the tree and for a frame of 500
// features.

#include "corners.hpp"
#include "parameters.hpp"
#include "quadtree.hpp"
#include "selection.hpp"
#include "threshold.hpp"

#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cstdio>
#include <functional>

using namespace cv::aqorb;

static double milliseconds(const std::function<void()>& work)
{
    cv::TickMeter meter;
    meter.start();
    work();
    meter.stop();
    return meter.getTimeMilli();
}

int main(int argc, char** argv)
{
    const int FEATURES = 500, TURNS = 41, LIMIT = 15;
    cv::setNumThreads(1);
    const cv::Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(FEATURES);
    detector->setSelectionType(AdaptiveQuadtreeORB::QUADTREE_SELECTION);
    std::printf("\n| image | the tree at 15, times that at (9) | a frame at 15, times that at (9) "
                "|\n|---|---:|---:|\n");
    for (int arg = 1; arg < argc; arg++)
    {
        const cv::Mat image = cv::imread(argv[arg], cv::IMREAD_GRAYSCALE);
        std::vector<cv::Mat> pyramid;
        detector->buildPyramid(image, pyramid);
        std::vector<Level> levels(pyramid.size());
        std::vector<cv::Rect> regions;
        for (size_t i = 0; i < levels.size(); i++)
        {
            levels[i].image = pyramid[i];
            regions.push_back(Parameters().keypointRegion(pyramid[i].size()));
        }
        CornerSpace space;
        findCorners(levels, regions, {fastThresholds(varianceOverMean(image, cv::Mat(), 1), 20, 4), false}, 1,
                    space);
        const std::vector<int> quotas =
            quadtreeQuotas(FEATURES, detector->getScaleFactor(), int(levels.size()));
        std::vector<std::vector<CornerResponse>> corners;
        for (size_t i = 0; i < levels.size(); i++)
            corners.push_back(responsesOf(levels[i].image, space.corners[i], true));
        std::vector<double> times[3];  // tree by equation (9), tree at depth 15, frame
        std::vector<cv::KeyPoint> keypoints;
        cv::Mat descriptors;
        for (int turn = 0; turn < TURNS; turn++)
        {
            for (int isLimit = 0; isLimit < 2; isLimit++)
                times[isLimit].push_back(milliseconds(
                    [&]
                    {
                        for (size_t i = 0; i < levels.size(); i++)
                            quadtreeOrder(corners[i], regions[i], isLimit ? LIMIT : quadtreeDepth(quotas[i]),
                                          quotas[i]);
                    }));
            times[2].push_back(milliseconds(
                [&] { detector->detectAndCompute(image, cv::noArray(), keypoints, descriptors); }));
        }
        for (std::vector<double>& of : times)
            std::nth_element(of.begin(), of.begin() + TURNS / 2, of.end());
        const double tree = times[0][TURNS / 2], limit = times[1][TURNS / 2], frame = times[2][TURNS / 2];
        std::printf("| %s | %.2f | %.3f |\n", argv[arg], limit / tree, (frame + limit - tree) / frame);
    }
    return 0;
}
