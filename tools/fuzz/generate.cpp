// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

#include "../../test/scenes.hpp"

#include <opencv2/core/ocl.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>

#include <climits>
#include <cstdio>
#include <cstdlib>
#include <limits>

using namespace cv;

extern "C" int LLVMFuzzerInitialize(int*, char***)
{
    setNumThreads(1);
    ocl::setUseOpenCL(false);
    // Messages of expected exceptions would flood the log.
    utils::logging::setLogLevel(utils::logging::LOG_LEVEL_SILENT);
    redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    return 0;
}

namespace fuzz
{

void require(bool condition, const std::string& what)
{
    if (!condition)
    {
        std::fprintf(stderr, "find: %s\n", what.c_str());
        std::abort();
    }
}

int number(FuzzedDataProvider& data, int low, int high)
{
    const int kind = data.ConsumeIntegralInRange(0, 15);
    if (kind == 0)
        return data.ConsumeIntegral<int>();
    if (kind == 1)
        return data.PickValueInArray({INT_MIN, -1, 0, 1, INT_MAX});
    return data.ConsumeIntegralInRange(low, high);
}

double real(FuzzedDataProvider& data, double low, double high)
{
    typedef std::numeric_limits<double> Limits;
    const int kind = data.ConsumeIntegralInRange(0, 15);
    if (kind == 0)
        return data.ConsumeFloatingPoint<double>();
    if (kind == 1)
        return data.PickValueInArray({-Limits::infinity(), -1., 0., Limits::denorm_min(), 1., Limits::max(),
                                      Limits::infinity(), Limits::quiet_NaN()});
    return data.ConsumeFloatingPointInRange(low, high);
}

//! Fills a matrix with bytes of the input, repeated as often as needed.
static void fillWithInput(FuzzedDataProvider& data, Mat& m)
{
    const std::vector<uchar> bytes =
        data.ConsumeBytes<uchar>(data.ConsumeIntegralInRange<size_t>(1, std::max<size_t>(m.total(), 1)));
    const size_t rowBytes = m.cols * m.elemSize();
    for (int y = 0; y < m.rows && !bytes.empty(); y++)
        for (size_t x = 0; x < rowBytes; x++)
            m.ptr(y)[x] = bytes[(y * rowBytes + x) % bytes.size()];
}

//! Fills all channels with one drawn picture.
static void draw(FuzzedDataProvider& data, Mat& m)
{
    const int seed = data.ConsumeIntegral<uchar>(), kind = data.ConsumeIntegralInRange(0, 5);
    Mat picture(m.size(), CV_8UC1, Scalar(seed));
    if (kind == 1)
        picture = opencv_test::makeNoise(m.size(), seed);
    else if (kind == 2)
        picture = opencv_test::makeScene(m.size(), seed);
    else if (kind == 3)
        picture = opencv_test::makeDots(m.size(), seed);
    else if (kind > 3)  // corners on coarse levels: a small picture enlarged
    {
        Mat small(data.ConsumeIntegralInRange(1, 24), data.ConsumeIntegralInRange(1, 24), CV_8UC1);
        fillWithInput(data, small);
        resize(small, picture, m.size(), 0, 0, data.ConsumeBool() ? INTER_CUBIC : INTER_NEAREST);
    }
    picture.convertTo(picture, m.depth());
    merge(std::vector<Mat>(size_t(m.channels()), picture), picture);
    picture.copyTo(m);
}

Mat matrix(FuzzedDataProvider& data, Size size, int type)
{
    const bool isPart = data.ConsumeBool();
    const int left = isPart ? data.ConsumeIntegralInRange(0, 5) : 0;
    const int top = isPart ? data.ConsumeIntegralInRange(0, 5) : 0;
    Mat whole = Mat::zeros(size + Size(2 * left, 2 * top), type);
    if (data.ConsumeBool())
        fillWithInput(data, whole);
    else if (!whole.empty())
        draw(data, whole);
    return whole(Rect(Point(left, top), size));
}

Mat image(FuzzedDataProvider& data, int maxSide, bool anyType)
{
    // A used-up input gives the lowest number of each range. Counting down from maxSide then gives a large image
    // instead of an empty one.
    const Size size(maxSide - data.ConsumeIntegralInRange(0, maxSide),
                    maxSide - data.ConsumeIntegralInRange(0, maxSide));
    const int kind = data.ConsumeIntegralInRange(0, 15);
    int type = kind == 1 ? CV_8UC3 : kind == 2 ? CV_8UC4 : CV_8UC1;
    if (anyType && kind == 3)
    {
        const int depth = data.ConsumeIntegralInRange(0, 6);
        type = CV_MAKETYPE(depth, data.ConsumeIntegralInRange(1, 5));
    }
    if (anyType && kind == 4)
    {
        const int sizes[] = {4, size.height, size.width};
        return Mat(3, sizes, CV_8UC1, Scalar(data.ConsumeIntegral<uchar>()));
    }
    return matrix(data, size, type);
}

Mat mask(FuzzedDataProvider& data, Size size, bool anyType)
{
    const int kind = data.ConsumeIntegralInRange(0, 7);
    if (kind < 4)
        return Mat();
    if (anyType && kind == 4)
        return image(data, 100, true);
    if (kind == 5 && !size.empty())  // few holes
        return opencv_test::makeDots(size, kind) == 0;
    return matrix(data, size, CV_8UC1);
}

std::vector<KeyPoint> keypoints(FuzzedDataProvider& data, Size size)
{
    std::vector<KeyPoint> result;
    for (int i = data.ConsumeIntegralInRange(0, 20); i > 0; i--)
    {
        const Point2f pt(float(real(data, -2, size.width + 2)), float(real(data, -2, size.height + 2)));
        const float angle = float(real(data, -1, 360)), response = float(real(data, -1, 1));
        const float diameter = float(real(data, 0, 100));
        result.push_back(KeyPoint(pt, diameter, angle, response, number(data, 0, 8), i));
    }
    return result;
}

}  // namespace fuzz
