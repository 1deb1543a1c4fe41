// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "lines.hpp"

#include "../../test/hash.hpp"
#include "../../test/scenes.hpp"

#include <algorithm>
#include <vector>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;
using opencv_test::Hash;
using opencv_test::hashOf;

namespace
{

//! A detector with random values of all parameters that have an effect with the selection. The other parameters are the
//! same with both selections.
Ptr<AdaptiveQuadtreeORB> makeDetector(RNG& rng, AdaptiveQuadtreeORB::SelectionType selection)
{
    const float scaleFactors[] = {1.1f, 1.2f, 1.33f, 1.5f, 2.f};
    const int patchSizes[] = {31, 31, 31, 24, 15};
    const int nfeatures = rng.uniform(50, 2500), nlevels = rng.uniform(1, 9),
              edgeThreshold = rng.uniform(0, 32);
    const float scaleFactor = scaleFactors[rng.uniform(0, 5)];
    const int firstLevel = rng.uniform(0, std::min(nlevels, 3)), tupleSize = rng.uniform(2, 5);
    const ORB::ScoreType score = rng.uniform(0, 3) == 0 ? ORB::FAST_SCORE : ORB::HARRIS_SCORE;
    const int patchSize = patchSizes[rng.uniform(0, 5)], fastThreshold = rng.uniform(3, 41);
    const Ptr<AdaptiveQuadtreeORB> detector =
        AdaptiveQuadtreeORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, tupleSize,
                                    score, patchSize, fastThreshold);
    detector->setAdaptiveThreshold(rng.uniform(0, 3) != 0);
    detector->setMinThresholdRatio(rng.uniform(1., 6.));
    detector->setCellSize(rng.uniform(8, 80));
    detector->setMaxDepth(rng.uniform(-1, 7));
    detector->setOctaveSuppression(rng.uniform(0., 3.));
    detector->setSubPixel(rng.uniform(0, 4) != 0);
    detector->setSelectionType(selection);
    RNG ofSelection(rng.state);
    const double strengthWeights[] = {0, 0.15, 0.5, 2}, rankRadii[] = {0, 0.5, 1, 2.5};
    detector->setStrengthWeight(strengthWeights[ofSelection.uniform(0, 4)]);
    detector->setRankRadius(rankRadii[ofSelection.uniform(0, 4)]);
    return detector;
}

Ptr<AdaptiveQuadtreeORB> makeDefault(int nfeatures, AdaptiveQuadtreeORB::SelectionType selection)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(nfeatures);
    detector->setSelectionType(selection);
    return detector;
}

std::string line(const std::string& name, const Mat& image, const Mat& mask, AdaptiveQuadtreeORB& detector)
{
    std::vector<Mat> levels;
    detector.buildPyramid(image, levels);
    Hash pyramid;
    for (const Mat& level : levels)
        pyramid.add(level);

    std::vector<KeyPoint> keypoints;
    Mat descriptors;
    detector.detectAndCompute(image, mask, keypoints, descriptors);

    const double measures[] = {aqorb::adaptiveFastThreshold(image, mask),
                               aqorb::distributionUniformity(keypoints, image.size()),
                               aqorb::distributionOccupancy(keypoints, image.size())};
    Hash hashOfMeasures;
    hashOfMeasures.addNumbers(measures, 3);

    return name + " image " + hashOf(image) + " pyramid " + pyramid.text() + " measures " +
           hashOfMeasures.text() + " keypoints " + std::to_string(keypoints.size()) + " " +
           hashOf(keypoints) + " descriptors " + hashOf(descriptors) + "\n";
}

}  // namespace

std::string FingerprintLines::scenes()
{
    std::string lines;
    for (int i = 0; i < 60; i++)
    {
        const int channels[] = {1, 3, 4};
        const Size size{rng.uniform(40, 500), rng.uniform(40, 400)};
        const Mat scene = opencv_test::makeIntegerScene(size, rng.next(), channels[i % 3]);
        Mat mask;
        if (i % 4 == 3)
        {
            mask = Mat::zeros(size, CV_8UC1);
            mask(Rect(size.width / 5, size.height / 5, size.width / 2, size.height / 2))
                .setTo(rng.uniform(1, 256));
        }
        lines += line("scene " + std::to_string(i), scene, mask,
                      *(i == 0 ? makeDefault(500, selection) : makeDetector(rng, selection)));
    }
    return lines;
}

std::string FingerprintLines::image(const std::string& name, const Mat& image)
{
    return line(name + " by default", image, Mat(), *makeDefault(1000, selection)) +
           line(name + " with drawn parameters", image, Mat(), *makeDetector(rng, selection));
}
