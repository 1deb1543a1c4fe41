// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

#include "../../test/reference.hpp"

#include <opencv2/core/utility.hpp>

// Compares the detector with the tests' plain reference, byte for byte: on the best kernels of the CPU and on the
// baseline, with one thread and with two. Also compares its descriptors with cv::ORB's.

using namespace opencv_test;

static void requireSame(const char* what, const ::testing::AssertionResult& result)
{
    fuzz::require(bool(result), std::string(what) + ": " + result.message());
}

// Draws valid parameters. fuzz_api also draws invalid parameters.
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
    data.ConsumeIntegral<uint16_t>();  // two removed properties: older inputs keep their meaning
    s.octaveSuppression = data.ConsumeBool() ? data.ConsumeFloatingPointInRange(0., 8.) : -1;
    s.subPixel = data.ConsumeBool();
    return s;
}

// Draws these properties after the image, because the corpus is older than they are.
static void drawSelection(FuzzedDataProvider& data, reference::Settings& s)
{
    if (data.ConsumeBool())
        s.selectionType = AdaptiveQuadtreeORB::QUADTREE_SELECTION;
    if (data.ConsumeBool())
        s.strengthWeight = data.ConsumeFloatingPointInRange(0., data.ConsumeBool() ? 1000. : 1.);
    if (data.ConsumeBool())
        s.rankRadius = data.ConsumeFloatingPointInRange(0., data.ConsumeBool() ? 16. : 3.);
    if (data.ConsumeBool())  // properties newer than the corpus
    {
        RNG rng(data.ConsumeIntegral<uint64>());
        s = reference::randomSettings(rng);
    }
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    FuzzedDataProvider data(bytes, size);
    reference::Settings settings = settingsFrom(data);
    const Mat image = fuzz::image(data, 72, false);
    if (image.empty())
        return 0;
    const Mat mask = fuzz::mask(data, image.size(), false);
    drawSelection(data, settings);

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
    return 0;
}
