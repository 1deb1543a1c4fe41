// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Makes any call with any arguments. Whatever happens that is not documented is a find.

#include "detector.hpp"
#include "generate.hpp"

#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace cv;

namespace
{
using namespace fuzz;

typedef std::vector<KeyPoint> KeyPoints;

// Calls that are slow or take much memory by design are left out: larger pyramids and larger patches.
const double MAX_PYRAMID_PIXELS = 4e5;
const double MAX_PATCH_PIXELS = 2e7;

class Caller
{
public:
    Caller(const uint8_t* bytes, size_t size) : data(bytes, size) {}

    void run()
    {
        detector.create(data);
        picture = image(data, 64, true);
        for (int calls = 0; calls < 20 && data.remaining_bytes() > 0; calls++)
            callOne();
    }

private:
    void callOne()
    {
        const int which = data.ConsumeIntegralInRange(0, 15);
        if (which < 2)
            detector.setOrbParameter(data);
        else if (which < 4)
            detector.setOurParameter(data);
        else if (which == 4)
            detector.readStorage(data);
        else if (which == 5)
            buildPyramid();
        else if (which == 6)
            callFunctions();
        else if (which < 9)
            picture = image(data, data.ConsumeBool() ? 64 : 300, true);
        else if (which == 9)
            area = mask(data, picture.dims > 2 ? Size() : picture.size(), true);
        else if (which < 12)
            compute();
        else
            detect();
    }

    bool isPicture() const
    {
        return picture.dims <= 2 && picture.depth() == CV_8U &&
               (picture.channels() == 1 || picture.channels() == 3 || picture.channels() == 4);
    }
    Size pictureSize() const { return picture.dims > 2 ? Size() : picture.size(); }

    //! Whether the levels 0 .. count - 1 have few enough pixels, or so many that this is an error.
    bool isAffordable(int count, size_t keypoints) const
    {
        const OrbParameters& p = detector.parameters;
        if (p.isBad())
            return false;
        if (std::min(double(keypoints), MAX_PYRAMID_PIXELS) * p.patchSize * p.patchSize > MAX_PATCH_PIXELS)
            return false;
        if (p.clash() || (count > 0 && p.hasTooLargeLevel(pictureSize(), 0)))
            return true;
        double pixels = 0;
        for (int i = 0; i < count && pixels <= MAX_PYRAMID_PIXELS; i++)
        {
            const double levelPixels = pictureSize().area() / p.scale(i) / p.scale(i);
            if (levelPixels < 0.25)
                break;
            pixels += levelPixels;
        }
        return pixels <= MAX_PYRAMID_PIXELS;
    }

    void buildPyramid()
    {
        if (!isAffordable(detector.parameters.nlevels, 0))
            return;
        const bool bad = !isPicture() || detector.parameters.clash() ||
                         detector.parameters.hasTooLargeLevel(picture.size(), 0);
        std::vector<Mat> levels(3);
        if (!detector.attempt("buildPyramid", expect(!picture.empty() && bad),
                              [&] { detector.orb->buildPyramid(picture, levels); }))
            return;
        require(int(levels.size()) <= detector.parameters.nlevels && levels.empty() == picture.empty(),
                "buildPyramid gave a wrong number of levels");
        for (const Mat& level : levels)
            require(level.type() == CV_8UC1 && !level.empty(), "buildPyramid gave a bad level");
    }

    void callFunctions()
    {
        const Size size(number(data, 1, 400), number(data, 1, 400));
        const Size grid(number(data, 1, 40), number(data, 1, 40));
        const int npoints = number(data, 0, 20);
        KeyPoints given = keypoints(data, Size(100, 100));
        const bool badSize = size.width <= 0 || size.height <= 0;
        const bool badGrid =
            grid.width <= 0 || grid.height <= 0 || int64(grid.width) * grid.height > (1 << 24);
        double u = 0, share = 0, threshold = 0;
        detector.attempt("distributionUniformity", expect(badSize),
                         [&] { u = aqorb::distributionUniformity(given, size); });
        require(std::isfinite(u) && u >= 0, "distributionUniformity gave no number");
        detector.attempt("distributionOccupancy", expect(badSize || badGrid),
                         [&] { share = aqorb::distributionOccupancy(given, size, grid); });
        require(share >= 0 && share <= 1, "distributionOccupancy gave no share");

        KeyPoints kept = given;
        if (detector.attempt("retainUniform", expect(badSize || npoints < 0),
                             [&] { aqorb::retainUniform(kept, size, npoints); }))
        {
            require(int(kept.size()) <= npoints, "retainUniform kept too many");
            int before = INT_MAX;  // keypoints() numbers them in descending order by class_id
            for (const KeyPoint& k : kept)
            {
                require(k.class_id < before && k.pt.x >= 0 && k.pt.y >= 0 && k.pt.x < float(size.width) &&
                            k.pt.y < float(size.height),
                        "retainUniform kept a wrong point, or in another order");
                before = k.class_id;
            }
        }
        const bool bad =
            !isPicture() ||
            (!area.empty() && (area.dims > 2 || area.type() != CV_8UC1 || area.size() != picture.size()));
        detector.attempt("adaptiveFastThreshold", picture.empty() ? UNKNOWN : expect(bad),
                         [&] { threshold = aqorb::adaptiveFastThreshold(picture, area); });
        require(std::isfinite(threshold) && threshold >= 0, "adaptiveFastThreshold gave no number");
    }

    void detect()
    {
        const int kind = data.ConsumeIntegralInRange(0, 3);
        const OrbParameters& p = detector.parameters;
        const size_t corners = std::min<size_t>(std::max(p.nfeatures, 0), pictureSize().area() / 4);
        if (!isAffordable(p.nlevels, corners))
            return;
        const bool badMask =
            !area.empty() && (area.dims > 2 || area.type() != CV_8UC1 || area.size() != pictureSize());
        const bool bad =
            p.isBad() || p.clash() || !isPicture() || badMask || p.hasTooLargeLevel(pictureSize(), 0);
        // The call must replace these outputs.
        KeyPoints found(3, KeyPoint(Point2f(-7, -7), 1.f, -1.f, 0.f, -1));
        Mat descriptors(2, 5, CV_16SC1, Scalar(3));
        const bool withDescriptors = kind < 2;
        const auto call = [&]
        {
            if (kind == 0)
            {
                detector.orb->detectAndCompute(picture, area, found, descriptors);
            }
            else if (kind == 1)
            {
                UMat output;
                detector.orb->detectAndCompute(picture.getUMat(ACCESS_READ), area, found, output);
                output.copyTo(descriptors);
            }
            else
            {
                detector.orb->detect(picture, found, area);
            }
        };
        if (!detector.attempt("detect", picture.empty() ? UNKNOWN : expect(bad), call))
        {
            require(found.size() == 3 && found[0].pt.x == -7, "a failed call changed its output");
            return;
        }
        if (picture.empty())
        {
            require(found.empty() && (!withDescriptors || descriptors.empty()),
                    "stale outputs for an empty image");
            return;
        }
        require(int64(found.size()) <= p.nfeatures, "detect gave more keypoints than nfeatures");
        for (const KeyPoint& k : found)
        {
            requireInside(k);
            require(std::isfinite(k.size) && std::isfinite(k.angle) && std::isfinite(k.response),
                    "detect gave a keypoint of which a field is not finite");
            require(k.octave >= 0 && k.octave < p.nlevels, "detect gave an octave that is no level");
            require(area.empty() || area.at<uchar>(cvRound(k.pt.y), cvRound(k.pt.x)) != 0,
                    "detect gave a keypoint on a masked pixel");
        }
        if (withDescriptors)
            requireDescriptors(found, descriptors);
    }

    void compute()
    {
        const OrbParameters& p = detector.parameters;
        const KeyPoints given = keypoints(data, pictureSize());
        int maxOctave = 0, minOctave = 0;
        bool badAngle = false;
        for (const KeyPoint& k : given)
        {
            maxOctave = std::max(maxOctave, k.octave);
            minOctave = std::min(minOctave, k.octave);
            badAngle |= !std::isfinite(k.angle);
        }
        if (!isAffordable(std::min(maxOctave, 65536) + 1, given.size()))
            return;
        const double scale = p.scale(maxOctave);
        const Size size = pictureSize();
        const bool isTooSmall = !(cvRound(size.width / scale) >= 1 && cvRound(size.height / scale) >= 1);
        bool bad = p.isBad() || p.clash() || !isPicture() || minOctave < 0 ||
                   (maxOctave > 0 && p.scaleFactor <= 1) || isTooSmall || badAngle;
        // Whether a level is too large need not be noticed if no keypoint is left on it.
        const bool mayBeBad = p.hasTooLargeLevel(size, 0);
        KeyPoints found = given;
        Mat descriptors(2, 5, CV_16SC1, Scalar(3));
        const Expectation expected = picture.empty() || (mayBeBad && !bad) ? UNKNOWN : expect(bad);
        if (!detector.attempt("compute", expected,
                              [&] { detector.orb->compute(picture, found, descriptors); }) ||
            picture.empty())
            return;
        require(found.size() <= given.size(), "compute gave more keypoints than there were");
        for (const KeyPoint& k : found)
            requireInside(k);
        requireDescriptors(found, descriptors);
    }

    void requireInside(const KeyPoint& k) const
    {
        // A position counts by the pixel it lies on, as in cv::ORB's compute.
        require(std::isfinite(k.pt.x) && std::isfinite(k.pt.y) && k.pt.x >= -0.5f && k.pt.y >= -0.5f &&
                    k.pt.x <= float(picture.cols) - 0.5f && k.pt.y <= float(picture.rows) - 0.5f,
                "a keypoint lies off the image");
    }
    static void requireDescriptors(const KeyPoints& found, const Mat& descriptors)
    {
        require(descriptors.rows == int(found.size()) &&
                    (found.empty() || (descriptors.cols == 32 && descriptors.type() == CV_8UC1)),
                "descriptors and keypoints do not match");
    }

    FuzzedDataProvider data;
    Detector detector;
    Mat picture, area;
};

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***);
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
    setNumThreads(1);
    ocl::setUseOpenCL(false);
    // Exceptions are expected here, and their messages would flood the log.
    utils::logging::setLogLevel(utils::logging::LOG_LEVEL_SILENT);
    redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    try
    {
        Caller(bytes, size).run();
    }
    catch (const Problem& problem)
    {
        std::fprintf(stderr, "find: %s\n", problem.text.c_str());
        std::abort();
    }
    return 0;
}
