// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "lines.hpp"

#include "../../test/scenes.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace
{

//! FNV-1a hash of 64 bits. It takes numbers from their lowest byte on, on CPUs of either byte order.
class Hash
{
public:
    void add(const void* data, size_t size)
    {
        const unsigned char* bytes = static_cast<const unsigned char*>(data);
        for (size_t i = 0; i < size; i++)
            state = (state ^ bytes[i]) * 0x100000001b3u;
    }
    //! Adds the size and the pixels.
    void add(const Mat& mat)
    {
        addNumbers(&mat.rows, 1);
        addNumbers(&mat.cols, 1);
        for (int y = 0; y < mat.rows; y++)
            addNumbers(mat.ptr(y), size_t(mat.cols) * mat.channels(), mat.elemSize1());
    }
    void add(const std::vector<KeyPoint>& keypoints)
    {
        static_assert(sizeof(KeyPoint) == 5 * sizeof(float) + 2 * sizeof(int), "a KeyPoint has no padding");
        addNumbers(keypoints.data(), keypoints.size() * 7, sizeof(float));
    }
    template <typename T> void addNumbers(const T* numbers, size_t count)
    {
        addNumbers(numbers, count, sizeof(T));
    }
    //! The hash in 16 hexadecimal digits.
    std::string text() const { return format("%08x%08x", unsigned(state >> 32), unsigned(state)); }

private:
    void addNumbers(const void* numbers, size_t count, size_t size)
    {
        const uint16_t one = 1;
        const bool lowestFirst = *reinterpret_cast<const unsigned char*>(&one) == 1;
        const unsigned char* bytes = static_cast<const unsigned char*>(numbers);
        for (size_t i = 0; i < count * size; i++)
            add(&bytes[lowestFirst ? i : i - i % size + (size - 1 - i % size)], 1);
    }

    uint64_t state = 0xcbf29ce484222325u;
};

template <typename T> std::string hashOf(const T& what)
{
    Hash hash;
    hash.add(what);
    return hash.text();
}

//! Makes a detector with random values of all parameters that affect the selection type. Common parameters have the
//! same values for both types.
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
    detector->setOctaveSuppression(rng.uniform(0., 3.));
    detector->setSubPixel(rng.uniform(0, 4) != 0);
    detector->setSelectionType(selection);
    RNG selectionRng(rng.state);
    const double strengthWeights[] = {0, 0.15, 0.5, 2}, rankRadii[] = {0, 0.5, 1, 2.5};
    detector->setStrengthWeight(strengthWeights[selectionRng.uniform(0, 4)]);
    detector->setRankRadius(rankRadii[selectionRng.uniform(0, 4)]);
    return detector;
}

Ptr<AdaptiveQuadtreeORB> makeDefault(int nfeatures, AdaptiveQuadtreeORB::SelectionType selection)
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(nfeatures);
    detector->setSelectionType(selection);
    return detector;
}

//! Hashes positions and deviations of refined and grown matches: keypoints a little off in a part of the image, half of
//! them without a match.
std::string hashOfGrown(const Mat& image, const std::vector<KeyPoint>& keypoints)
{
    const Mat part = image(Rect(1, 1, image.cols - 1, image.rows - 1));
    std::vector<KeyPoint> moved = keypoints;
    std::vector<DMatch> matches;
    for (size_t i = 0; i < moved.size(); i++)
    {
        moved[i].pt += Point2f(-0.25f, -1.5f);
        moved[i].angle += 4;
        moved[i].size *= 1.125f;
        if (i % 2 == 0)
            matches.push_back(DMatch(int(i), int(i), 0));
    }
    std::vector<Point2f> points1, points2;
    std::vector<float> deviations;
    aqorb::growMatches(image, keypoints, part, moved, matches, moved, points1, points2, deviations, -1);
    Hash hash;
    for (size_t i = 0; i < points2.size(); i++)
    {
        hash.addNumbers(&points2[i].x, 2);
        hash.addNumbers(&deviations[i], 1);
    }
    return hash.text() + " keypoints " + hashOf(moved);
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
           hashOf(keypoints) + " descriptors " + hashOf(descriptors) + " grown " +
           hashOfGrown(image, keypoints) + "\n";
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
