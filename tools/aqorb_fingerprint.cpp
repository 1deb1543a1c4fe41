// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Prints hashes of the module's results, to compare CPUs, compilers and versions of OpenCV:
//
//   aqorb_fingerprint [--plain] [--quadtree] [IMAGE ...]
//
// One line stands for a scene or an image and a set of parameters. The hashes of the image and of the pyramid show
// whether a difference comes from the input or from the detector. --plain calls cv::setUseOptimized(false). --quadtree
// sets QUADTREE_SELECTION. Standard error lists the CPU features that OpenCV uses.

#include "../test/scenes.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace
{

//! FNV-1a hash of 64 bits. It takes numbers as they lie in memory: only CPUs of the same byte order compare.
class Hash
{
public:
    Hash& add(const void* numbers, size_t bytes)
    {
        for (size_t i = 0; i < bytes; i++)
            state = (state ^ static_cast<const unsigned char*>(numbers)[i]) * 0x100000001b3u;
        return *this;
    }
    //! Adds the size and the pixels.
    Hash& add(const Mat& mat)
    {
        add(&mat.rows, sizeof(int)).add(&mat.cols, sizeof(int));
        for (int y = 0; y < mat.rows; y++)
            add(mat.ptr(y), mat.cols * mat.elemSize());
        return *this;
    }
    Hash& add(const std::vector<KeyPoint>& keypoints)
    {
        static_assert(sizeof(KeyPoint) == 5 * sizeof(float) + 2 * sizeof(int), "a KeyPoint has no padding");
        return add(keypoints.data(), keypoints.size() * sizeof(KeyPoint));
    }
    //! The hash in 16 hexadecimal digits.
    std::string text() const { return format("%08x%08x", unsigned(state >> 32), unsigned(state)); }

private:
    uint64_t state = 0xcbf29ce484222325u;
};

//! Makes a detector with random values of all parameters but the selection type.
Ptr<AdaptiveQuadtreeORB> makeDetector(RNG& rng)
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
    RNG selectionRng(rng.state);
    const double strengthWeights[] = {0, 0.15, 0.5, 2}, rankRadii[] = {0, 0.5, 1, 2.5};
    detector->setStrengthWeight(strengthWeights[selectionRng.uniform(0, 4)]);
    detector->setRankRadius(rankRadii[selectionRng.uniform(0, 4)]);
    return detector;
}

//! Hashes positions and deviations of refined and grown matches: keypoints a little off in a part of the image, half of
//! them without a match.
std::string hashOfGrown(const Mat& image, const std::vector<KeyPoint>& keypoints)
{
    const Mat part = image(Rect(1, 1, image.cols - 1, image.rows - 1));
    std::vector<KeyPoint> moved = keypoints, grown;
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
    aqorb::growMatches(image, keypoints, part, moved, matches, grown, moved, points1, points2, deviations,
                       -1);
    Hash hash;
    for (size_t i = 0; i < points2.size(); i++)
        hash.add(&points1[i], sizeof(Point2f))
            .add(&points2[i], sizeof(Point2f))
            .add(&deviations[i], sizeof(float));
    return hash.text() + " keypoints " + Hash().add(grown).text() + " " + Hash().add(moved).text();
}

void printLine(const std::string& name, const Mat& image, const Mat& mask,
               AdaptiveQuadtreeORB::SelectionType selection, AdaptiveQuadtreeORB& detector)
{
    std::vector<Mat> levels;
    detector.setSelectionType(selection);
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
    std::cout << name << " image " << Hash().add(image).text() << " pyramid " << pyramid.text()
              << " measures " << Hash().add(measures, sizeof(measures)).text() << " keypoints "
              << keypoints.size() << " " << Hash().add(keypoints).text() << " descriptors "
              << Hash().add(descriptors).text() << " grown " << hashOfGrown(image, keypoints) << std::endl;
}

//! 60 drawn scenes, one of four with a mask.
void printScenes(RNG& rng, AdaptiveQuadtreeORB::SelectionType selection)
{
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
        printLine(format("scene %d", i), scene, mask, selection,
                  *(i == 0 ? AdaptiveQuadtreeORB::create(500) : makeDetector(rng)));
    }
}

}  // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> files(argv + 1, argv + argc);
    AdaptiveQuadtreeORB::SelectionType selection = AdaptiveQuadtreeORB::RANKED_SELECTION;
    for (; !files.empty() && files[0].compare(0, 2, "--") == 0; files.erase(files.begin()))
    {
        if (files[0] == "--plain")
            setUseOptimized(false);
        else if (files[0] == "--quadtree")
            selection = AdaptiveQuadtreeORB::QUADTREE_SELECTION;
        else
            CV_Error(Error::StsBadArg, files[0] + ": --plain or --quadtree is accepted");
    }
    std::cerr << CV_VERSION << ", " << getCPUFeaturesLine()
              << (useOptimized() ? "" : ", setUseOptimized(false)") << std::endl;

    RNG rng(20191);
    printScenes(rng, selection);
    for (const std::string& file : files)
    {
        const Mat image = imread(file, IMREAD_COLOR);
        if (image.empty())
            CV_Error(Error::StsObjectNotFound, "cannot read " + file);
        printLine(file + " by default", image, Mat(), selection, *AdaptiveQuadtreeORB::create(1000));
        printLine(file + " with drawn parameters", image, Mat(), selection, *makeDetector(rng));
    }
    return 0;
}
