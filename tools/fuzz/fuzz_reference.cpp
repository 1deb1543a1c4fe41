// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

#include "../../test/reference.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <cmath>

// Compares the detector with the tests' plain reference, byte for byte: on the best kernels of the CPU and on the
// baseline, with one thread and with two. Also compares its descriptors with cv::ORB's. Calls with any image, mask and
// keypoints give a valid result, or an exception that states the accepted values.

using namespace opencv_test;

static void requireSame(const char* what, const ::testing::AssertionResult& result)
{
    fuzz::require(bool(result), std::string(what) + ": " + result.message());
}

static reference::Settings settingsFrom(FuzzedDataProvider& data)
{
    reference::Settings s;
    s.nfeatures =
        data.ConsumeBool() ? data.ConsumeIntegralInRange(0, 3000) : 60 - data.ConsumeIntegralInRange(0, 60);
    s.scaleFactor = data.ConsumeBool() ? data.ConsumeFloatingPointInRange(1.02f, 2.5f) : 1.2f;
    s.firstLevel = data.ConsumeIntegralInRange(0, s.scaleFactor < 1.3f ? 2 : s.scaleFactor < 2 ? 1 : 0);
    s.nlevels = s.firstLevel + 8 - data.ConsumeIntegralInRange(0, 7);
    s.edgeThreshold = data.ConsumeIntegralInRange(0, 20);
    s.WTA_K = data.ConsumeIntegralInRange(2, 4);
    s.scoreType = data.ConsumeBool() ? ORB::HARRIS_SCORE : ORB::FAST_SCORE;
    s.patchSize = data.ConsumeIntegralInRange(2, 64);
    s.fastThreshold = data.ConsumeIntegralInRange(0, 80);
    s.adaptiveThreshold = data.ConsumeBool();
    s.minThresholdRatio = data.ConsumeFloatingPointInRange(1., 8.);
    s.octaveSuppression = data.ConsumeBool() ? data.ConsumeFloatingPointInRange(0., 8.) : -1;
    s.subPixel = data.ConsumeBool();
    if (data.ConsumeBool())
        s.selectionType = AdaptiveQuadtreeORB::QUADTREE_SELECTION;
    if (data.ConsumeBool())
        s.strengthWeight = data.ConsumeFloatingPointInRange(0., data.ConsumeBool() ? 1000. : 1.);
    if (data.ConsumeBool())
        s.rankRadius = data.ConsumeFloatingPointInRange(0., data.ConsumeBool() ? 16. : 3.);
    return s;
}

// A failed call leaves its outputs as they were.
template <typename Call>
static void callWithAnything(const Mat& image, std::vector<KeyPoint> keypoints, const Call& call)
{
    const size_t count = keypoints.size();
    Mat descriptors(2, 5, CV_16SC1);
    if (!fuzz::isCalled([&] { call(keypoints, descriptors); }))
    {
        fuzz::require(keypoints.size() == count && descriptors.cols == 5, "outputs changed");
        return;
    }
    fuzz::require(image.empty() || descriptors.rows == int(keypoints.size()),
                  "a descriptor for each keypoint");
    for (size_t i = 0; i < keypoints.size() && !image.empty(); i++)
        fuzz::require(
            Rect2f(-.5f, -.5f, float(image.cols) + .5f, float(image.rows) + .5f).contains(keypoints[i].pt),
            "a keypoint lies off the image");
}

static void callWithAnything(FuzzedDataProvider& data, AdaptiveQuadtreeORB& detector)
{
    const Mat image = fuzz::image(data, 64, true), mask = fuzz::mask(data, image.size(), true);
    const std::vector<KeyPoint> given = fuzz::keypoints(data, Size(64, 64));
    callWithAnything(image, given,
                     [&](std::vector<KeyPoint>& keypoints, Mat& descriptors)
                     { detector.detectAndCompute(image, mask, keypoints, descriptors); });
    // A keypoint of a high octave is slow by design: the pyramid is built up to it.
    if (std::all_of(given.begin(), given.end(), [](const KeyPoint& k) { return k.octave < 9; }))
        callWithAnything(image, given,
                         [&](std::vector<KeyPoint>& keypoints, Mat& descriptors)
                         { detector.compute(image, keypoints, descriptors); });
    std::vector<KeyPoint> kept = given;
    const Size size(fuzz::number(data, 1, 400), fuzz::number(data, 1, 400));
    const int npoints = fuzz::number(data, 0, 20);
    fuzz::isCalled(
        [&]
        {
            aqorb::retainUniform(kept, size, npoints);
            fuzz::require(int(kept.size()) <= npoints, "retainUniform kept too many");
            fuzz::require(std::isfinite(aqorb::distributionUniformity(given, size)),
                          "distributionUniformity");
        });
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    FuzzedDataProvider data(bytes, size);
    const reference::Settings settings = settingsFrom(data);
    const Mat image = fuzz::image(data, 72, false);
    if (image.empty())
        return 0;
    const Mat mask = fuzz::mask(data, image.size(), false);

    const Features expected = reference::detectAndCompute(image, mask, settings);
    const Ptr<AdaptiveQuadtreeORB> detector = settings.create();
    setNumThreads(1);
    requireSame("one thread", sameFeatures(detectAndCompute(*detector, image, mask), expected));
    setNumThreads(2);
    requireSame("two threads", sameFeatures(detectAndCompute(*detector, image, mask), expected));
    {
        const WithoutOptimization baseline;
        requireSame("baseline kernels", sameFeatures(detectAndCompute(*detector, image, mask), expected));
    }

    Features computed = {expected.keypoints, Mat()};
    detector->compute(image, computed.keypoints, computed.descriptors);
    static const bool comparable = orbBlursWithFMA();
    if (comparable && !expected.keypoints.empty())
    {
        Features orbFeatures = {expected.keypoints, Mat()};
        // A copy, because cv::ORB reads the pixels around a part of a larger image.
        settings.createOrb()->compute(image.clone(), orbFeatures.keypoints, orbFeatures.descriptors);
        requireSame("compute of cv::ORB", sameFeatures(computed, orbFeatures));
    }
    // With firstLevel > 0 compute drops some detected keypoints, because it applies the border to the image.
    if (settings.firstLevel == 0)
        requireSame("compute of what was detected", sameFeatures(computed, expected));
    callWithAnything(data, *detector);
    return 0;
}
