// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// matchImages: the calls of the module that lead from two images to pairs of points.

#include "precomp.hpp"

#include "common/images.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

void matchImages(InputArray image1, InputArray image2, std::vector<Point2f>& points1,
                 std::vector<Point2f>& points2, std::vector<float>& deviations, int nfeatures)
{
    CV_TRACE_FUNCTION();
    const _InputArray* const inputs[] = {&image1, &image2};
    const char* const names[] = {"image1", "image2"};
    const UMat retained[] = {retainUMat(image1), retainUMat(image2)};
    Mat images[2], descriptors[2];
    for (int i = 0; i < 2; i++)
    {
        if (inputs[i]->empty())
            continue;
        checkImage(*inputs[i], names[i]);
        images[i] = grayImage(*inputs[i]);
        checkPyramidInput(images[i].size(), names[i]);
    }
    std::vector<KeyPoint> keypoints[2];
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(nfeatures);
    for (int i = 0; i < 2; i++)
        detector->detectAndCompute(images[i], noArray(), keypoints[i], descriptors[i]);
    std::vector<DMatch> matches;
    HammingMatcher(NORM_HAMMING, true).match(descriptors[0], descriptors[1], matches);
    std::vector<Point2f> grown1, grown2;
    std::vector<float> unsorted;
    growMatches(images[0], keypoints[0], images[1], keypoints[1], matches, keypoints[0], keypoints[1], grown1,
                grown2, unsorted);

    std::vector<std::pair<float, size_t>> order;
    for (size_t i = 0; i < unsorted.size(); i++)
        order.push_back(std::make_pair(unsorted[i], i));
    std::sort(order.begin(), order.end());
    points1.clear();
    points2.clear();
    deviations.clear();
    for (const std::pair<float, size_t>& match : order)
    {
        points1.push_back(grown1[match.second]);
        points2.push_back(grown2[match.second]);
        deviations.push_back(match.first);
    }
}

}  // namespace aqorb
}  // namespace cv
