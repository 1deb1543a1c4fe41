// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Makes any call with any arguments. The call must give a valid result, or an exception that states the accepted values
// and leaves the outputs unchanged.

#include "generate.hpp"

#include "detector/parameters.hpp"

#include <opencv2/core/utility.hpp>

#include <cmath>

using namespace cv;
using namespace cv::aqorb;

namespace
{
using namespace fuzz;

typedef std::vector<KeyPoint> KeyPoints;

// Limits for calls that are slow or large by design: larger pyramids and larger patches are left out.
const double MAX_PYRAMID_PIXELS = 4e5;
const double MAX_PATCH_PIXELS = 2e7;

//! Whether a call accepts its arguments. A rejection must name the argument.
template <typename Call> bool accepts(const Call& call)
{
    try
    {
        call();
    }
    catch (const cv::Exception& e)
    {
        require(e.err.find(" must ") != std::string::npos, e.what());
        return false;
    }
    return true;
}

class Caller
{
public:
    Caller(const uint8_t* bytes, size_t size) : data(bytes, size), detector(AdaptiveQuadtreeORB::create()) {}

    void run()
    {
        picture = image(data, 64, true);
        for (int calls = 0; calls < 20 && data.remaining_bytes() > 0; calls++)
            callOne();
    }

private:
    void callOne()
    {
        const int which = data.ConsumeIntegralInRange(0, 15);
        if (which < 4)
            setParameter();
        else if (which == 4)
            readStorage();
        else if (which == 5)
            buildPyramid();
        else if (which == 6)
            callFunctions();
        else if (which < 9)
            picture = image(data, data.ConsumeBool() ? 64 : 300, true);
        else if (which == 9)
            area = mask(data, pictureSize(), true);
        else if (which < 12)
            compute();
        else
            detect();
    }

    Size pictureSize() const { return picture.dims > 2 ? Size() : picture.size(); }

    //! Whether the first levels have at most MAX_PYRAMID_PIXELS pixels.
    bool isAffordable(int levels, size_t keypoints) const
    {
        const double patchSize = detector->getPatchSize();
        double pixels = 0;
        for (int i = 0; i < levels && pixels <= MAX_PYRAMID_PIXELS; i++)
        {
            const double scale = std::pow(detector->getScaleFactor(), double(i - detector->getFirstLevel()));
            const double levelArea = pictureSize().area() / scale / scale;
            if (levelArea < 0.25)
                break;
            pixels += levelArea;
        }
        return pixels <= MAX_PYRAMID_PIXELS &&
               std::min(double(keypoints), MAX_PYRAMID_PIXELS) * patchSize * patchSize <= MAX_PATCH_PIXELS;
    }

    void setParameter()
    {
        int which = data.ConsumeIntegralInRange(0, 15);
#define AQORB_SET(property, type, name, key, byDefault, range, text)                                        \
    if (which-- == 0)                                                                                       \
    {                                                                                                       \
        const double value =                                                                                \
            std::is_same<type, double>::value ? real(data, -1, 20) : double(number(data, -1, 100));         \
        const auto before = toStored(detector->get##property());                                            \
        const auto wanted = static_cast<Stored<type>>(value);                                               \
        const bool isSet = accepts([&] { detector->set##property(static_cast<type>(wanted)); });            \
        require(isSet == range.has(wanted), "set" #property " has another range");                          \
        require(toStored(detector->get##property()) == (isSet ? wanted : before), "set" #property " sets"); \
    }
        AQORB_PARAMETERS(AQORB_SET)
#undef AQORB_SET
    }

    //! Reads parameters from a storage with values of any kind.
    void readStorage()
    {
        const char* const values[] = {"text", "[ 1, 2. ]", "{ a: 1 }", "-1", "1.5", ".Nan", "-.Inf", "1e300"};
        std::string text = "%YAML:1.0\n---\n";
        const auto add = [&](const char* key)
        {
            const int kind = data.ConsumeIntegralInRange(0, 3);
            if (kind == 1)
                text += format("%s: %d\n", key, number(data, 0, 30));
            else if (kind == 2)
                text += format("%s: %s\n", key, data.PickValueInArray(values));
        };
#define AQORB_ADD(property, type, name, key, ...) add(#key);
        AQORB_PARAMETERS(AQORB_ADD)
#undef AQORB_ADD
        FileStorage in(text, FileStorage::READ | FileStorage::MEMORY);
        accepts([&] { detector->read(in.root()); });
#define AQORB_CHECK(property, type, name, key, byDefault, range, text) \
    require(range.has(double(toStored(detector->get##property()))), "read left a bad " #name);
        AQORB_PARAMETERS(AQORB_CHECK)
#undef AQORB_CHECK
    }

    void buildPyramid()
    {
        std::vector<Mat> levels(3);
        if (!isAffordable(detector->getNLevels(), 0) ||
            !accepts([&] { detector->buildPyramid(picture, levels); }))
            return;
        require(int(levels.size()) <= detector->getNLevels() && levels.empty() == picture.empty(),
                "buildPyramid gave a wrong number of levels");
        for (const Mat& level : levels)
            require(level.type() == CV_8UC1 && !level.empty(), "buildPyramid gave a bad level");
    }

    void callFunctions()
    {
        const Size size(number(data, 1, 400), number(data, 1, 400));
        const Size grid(number(data, 1, 40), number(data, 1, 40));
        const int npoints = number(data, 0, 20);
        KeyPoints kept = keypoints(data, Size(100, 100));
        double u = 0, share = 0, threshold = 0;
        accepts([&] { u = distributionUniformity(kept, size); });
        require(std::isfinite(u) && u >= 0, "distributionUniformity gave no number");
        accepts([&] { share = distributionOccupancy(kept, size, grid); });
        require(share >= 0 && share <= 1, "distributionOccupancy gave no share");
        accepts([&] { threshold = adaptiveFastThreshold(picture, area); });
        require(std::isfinite(threshold) && threshold >= 0, "adaptiveFastThreshold gave no number");
        if (!accepts([&] { retainUniform(kept, size, npoints); }))
            return;
        require(int(kept.size()) <= npoints, "retainUniform kept too many");
        for (size_t i = 0; i < kept.size(); i++)  // keypoints() numbers them in descending order by class_id
            require((i == 0 || kept[i].class_id < kept[i - 1].class_id) &&
                        Rect2f(Point2f(), Size2f(size)).contains(kept[i].pt),
                    "retainUniform kept a wrong point, or in another order");
    }

    void detect()
    {
        const size_t corners = std::min(detector->getMaxFeatures(), pictureSize().area() / 4);
        if (!isAffordable(detector->getNLevels(), corners))
            return;
        // The call must replace these outputs or leave them unchanged.
        KeyPoints found(3, KeyPoint(Point2f(-7, -7), 1.f, -1.f, 0.f, -1));
        Mat descriptors(2, 5, CV_16SC1, Scalar(3));
        const bool isOfUMat = data.ConsumeBool();
        const auto call = [&]
        {
            UMat output;
            if (isOfUMat)
                detector->detectAndCompute(picture.getUMat(ACCESS_READ), area, found, output);
            else
                detector->detectAndCompute(picture, area, found, descriptors);
            if (isOfUMat)
                output.copyTo(descriptors);
        };
        if (!accepts(call))
        {
            require(found.size() == 3 && found[0].pt.x == -7 && descriptors.cols == 5, "outputs changed");
            return;
        }
        require(int(found.size()) <= (picture.empty() ? 0 : detector->getMaxFeatures()),
                "too many keypoints");
        for (const KeyPoint& k : found)
        {
            require(std::isfinite(k.size) && std::isfinite(k.angle) && std::isfinite(k.response),
                    "detect gave a keypoint of which a field is not finite");
            require(k.octave >= 0 && k.octave < detector->getNLevels(), "an octave that is no level");
            require(area.empty() || area.at<uchar>(cvRound(k.pt.y), cvRound(k.pt.x)) != 0, "a masked pixel");
        }
        requireOutputs(found, descriptors);
    }

    void compute()
    {
        const KeyPoints given = keypoints(data, pictureSize());
        int maxOctave = 0;
        for (const KeyPoint& k : given)
            maxOctave = std::max(maxOctave, k.octave);
        if (!isAffordable(std::min(maxOctave, 65536) + 1, given.size()))
            return;
        KeyPoints found = given;
        Mat descriptors(2, 5, CV_16SC1, Scalar(3));
        if (!accepts([&] { detector->compute(picture, found, descriptors); }))
        {
            require(found.size() == given.size() && descriptors.cols == 5, "outputs changed");
            return;
        }
        require(found.size() <= given.size(), "compute gave more keypoints than there were");
        requireOutputs(found, descriptors);
    }

    void requireOutputs(const KeyPoints& found, const Mat& descriptors) const
    {
        if (picture.empty())
            return;
        // The pixel at a position counts, as in cv::ORB::compute.
        for (const KeyPoint& k : found)
            require(k.pt.x >= -0.5f && k.pt.y >= -0.5f && k.pt.x <= float(picture.cols) - 0.5f &&
                        k.pt.y <= float(picture.rows) - 0.5f,
                    "a keypoint lies off the image");
        require(descriptors.rows == int(found.size()) &&
                    (found.empty() || (descriptors.cols == 32 && descriptors.type() == CV_8UC1)),
                "descriptors and keypoints do not match");
    }

    FuzzedDataProvider data;
    Ptr<AdaptiveQuadtreeORB> detector;
    Mat picture, area;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
    Caller(bytes, size).run();
    return 0;
}
