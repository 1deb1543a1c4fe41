// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "generate.hpp"

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
    switch (data.ConsumeIntegralInRange(0, 15))
    {
    case 0:
        return data.ConsumeIntegral<int>();
    case 1:
        return data.PickValueInArray({INT_MIN, -1, 0, 1, INT_MAX});
    default:
        return data.ConsumeIntegralInRange(low, high);
    }
}

double real(FuzzedDataProvider& data, double low, double high)
{
    const double endless = std::numeric_limits<double>::infinity();
    switch (data.ConsumeIntegralInRange(0, 15))
    {
    case 0:
        return data.ConsumeFloatingPoint<double>();
    case 1:
        return data.PickValueInArray({-endless, -1., 0., std::numeric_limits<double>::denorm_min(), 1.,
                                      std::numeric_limits<double>::max(), endless,
                                      std::numeric_limits<double>::quiet_NaN()});
    default:
        return data.ConsumeFloatingPointInRange(low, high);
    }
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

static void fill(FuzzedDataProvider& data, Mat& m)
{
    if (m.empty() || m.channels() > 4)  // OpenCV draws on four channels at most
        return;
    switch (data.ConsumeIntegralInRange(0, 6))
    {
    case 0:
    {
        RNG rng(data.ConsumeIntegral<uchar>());
        rng.fill(m, RNG::UNIFORM, 0, 256 - data.ConsumeIntegral<uchar>());
        return;
    }
    case 1:
        m.setTo(Scalar::all(data.ConsumeIntegral<uchar>()));
        return;
    case 2:
        fillWithInput(data, m);
        return;
    case 3:  // a checkerboard
    {
        const int side = data.ConsumeIntegralInRange(1, 40);
        const Scalar grey = Scalar::all(data.ConsumeIntegral<uchar>());
        m.setTo(Scalar::all(data.ConsumeIntegral<uchar>()));
        for (int y = 0; y < m.rows; y += side)
            for (int x = y / side % 2 * side; x < m.cols; x += 2 * side)
                rectangle(m, Rect(x, y, side, side), grey, -1);
        return;
    }
    case 4:  // dots on flat ground
    {
        m.setTo(Scalar::all(data.ConsumeIntegral<uchar>()));
        RNG rng(data.ConsumeIntegral<uchar>());
        for (int i = data.ConsumeIntegralInRange(0, 100); i > 0; i--)
            rectangle(m, Rect(rng.uniform(0, m.cols), rng.uniform(0, m.rows), 1 + i % 3, 1 + i % 4),
                      Scalar::all(rng.uniform(0, 256)), -1);
        return;
    }
    default:  // corners on coarse levels: a small picture enlarged
    {
        Mat small(data.ConsumeIntegralInRange(1, 24), data.ConsumeIntegralInRange(1, 24), m.type());
        if (data.ConsumeBool())
            fillWithInput(data, small);
        else
            RNG(data.ConsumeIntegral<uchar>()).fill(small, RNG::UNIFORM, 0, 256);
        if (m.depth() == CV_8U)  // not every depth can be resized
            resize(small, m, m.size(), 0, 0, data.ConsumeBool() ? INTER_CUBIC : INTER_NEAREST);
        else
            m.setTo(Scalar::all(1));
    }
    }
}

Mat matrix(FuzzedDataProvider& data, Size size, int type)
{
    const bool isPart = data.ConsumeBool();
    const int left = isPart ? data.ConsumeIntegralInRange(0, 5) : 0;
    const int top = isPart ? data.ConsumeIntegralInRange(0, 5) : 0;
    Mat whole = Mat::zeros(size + Size(2 * left, 2 * top), type);
    fill(data, whole);
    return whole(Rect(Point(left, top), size));
}

Mat image(FuzzedDataProvider& data, int maxSide, bool anyType)
{
    // A used-up input gives the lowest number of each range. Counting down from maxSide then gives a large image
    // instead of an empty one.
    const Size size(maxSide - data.ConsumeIntegralInRange(0, maxSide),
                    maxSide - data.ConsumeIntegralInRange(0, maxSide));
    switch (data.ConsumeIntegralInRange(0, 15))
    {
    case 1:
        return matrix(data, size, CV_8UC3);
    case 2:
        return matrix(data, size, CV_8UC4);
    case 3:
        if (anyType)
            return matrix(data, size,
                          CV_MAKETYPE(data.ConsumeIntegralInRange(0, 6), data.ConsumeIntegralInRange(1, 5)));
        break;
    case 4:
        if (anyType)
        {
            const int sizes[] = {4, size.height, size.width};
            return Mat(3, sizes, CV_8UC1, Scalar(data.ConsumeIntegral<uchar>()));
        }
        break;
    }
    return matrix(data, size, CV_8UC1);
}

Mat mask(FuzzedDataProvider& data, Size size, bool anyType)
{
    const int kind = data.ConsumeIntegralInRange(0, 7);
    if (kind < 4)
        return Mat();
    if (anyType && kind == 4)
        return image(data, 100, true);
    if (kind == 5)  // few holes
    {
        Mat holes(size, CV_8UC1, Scalar(data.ConsumeIntegralInRange(1, 255)));
        RNG rng(data.ConsumeIntegral<uchar>());
        for (int i = data.ConsumeIntegralInRange(0, 60); i > 0 && !holes.empty(); i--)
            rectangle(holes,
                      Rect(rng.uniform(0, size.width), rng.uniform(0, size.height), 1 + i / 4, 1 + i / 8),
                      Scalar(0), -1);
        return holes;
    }
    return matrix(data, size, CV_8UC1);
}

std::vector<KeyPoint> keypoints(FuzzedDataProvider& data, Size size)
{
    std::vector<KeyPoint> result;
    for (int i = data.ConsumeIntegralInRange(0, 20); i > 0; i--)
    {
        KeyPoint keypoint;
        keypoint.pt = Point2f(float(real(data, -2, size.width + 2)), float(real(data, -2, size.height + 2)));
        keypoint.angle = float(real(data, -1, 360));
        keypoint.response = float(real(data, -1, 1));
        keypoint.size = float(real(data, 0, 100));
        keypoint.octave = number(data, 0, 8);
        keypoint.class_id = i;
        result.push_back(keypoint);
    }
    return result;
}

}  // namespace fuzz
