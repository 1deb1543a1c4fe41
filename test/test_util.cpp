// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include <cfloat>

#include <cstring>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace opencv_test
{

Features detectAndCompute(Feature2D& detector, InputArray image, InputArray mask)
{
    Features features;
    detector.detectAndCompute(image, mask, features.keypoints, features.descriptors);
    return features;
}

std::string messageOf(const std::function<void()>& call)
{
    try
    {
        call();
    }
    catch (const cv::Exception& e)
    {
        return e.err;
    }
    return std::string();
}

::testing::AssertionResult names(const std::string& message, const std::string& name,
                                 const std::string& value)
{
    // As in "nfeatures must be at least 0, got -1".
    const size_t must = message.find(" must "), got = message.find(", got ");
    if (must != std::string::npos && got != std::string::npos && message.find(name) < got &&
        message.find(value, got) != std::string::npos)
        return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure()
           << "'" << message << "' does not say what " << name << " must be, and that it is " << value;
}

long long heapInUse()
{
#if defined(__GLIBC__)
#if __GLIBC_PREREQ(2, 33)
    const struct mallinfo2 heap = mallinfo2();
    return (long long)(heap.uordblks + heap.hblkhd);
#endif
#endif
    return 0;
}

bool isHeapKnown()
{
    const long long before = heapInUse();
    const Mat matrix(1000, 1000, CV_8UC1);
    return heapInUse() > before;
}

std::string dataFile(const std::string& name)
{
    const char* const folder = std::getenv("OPENCV_TEST_DATA_PATH");
    return folder && *folder ? std::string(folder) + "/" + name : std::string();
}

std::string oxfordImage(const std::string& set, int index)
{
    return dataFile(
        format("cv/detectors_descriptors_evaluation/images_datasets/%s/img%d.png", set.c_str(), index));
}

std::vector<Mat> photographs()
{
    const std::string names[] = {oxfordImage("bikes", 1),      oxfordImage("leuven", 4),
                                 oxfordImage("bark", 1),       oxfordImage("trees", 2),
                                 oxfordImage("ubc", 6),        oxfordImage("graf", 3),
                                 dataFile("cv/shared/box.png")};
    std::vector<Mat> images;
    for (const std::string& name : names)
    {
        const Mat image = imread(name, IMREAD_GRAYSCALE);
        EXPECT_FALSE(image.empty()) << name;
        if (!image.empty())
            images.push_back(image);
    }
    return images;
}

Mat randomImage(RNG& rng, Size size)
{
    const int seed = rng.uniform(1, 1 << 20), kind = rng.uniform(0, 6);
    Mat image = kind < 2 ? makeNoise(size, seed) : kind == 2 ? makeDots(size, seed) : makeScene(size, seed);
    if (kind == 1)
        cv::GaussianBlur(image, image, Size(), 1 + seed % 3);
    if (kind == 3)
        image *= 0.1;
    if (kind == 4)  // corners on coarse levels
        cv::resize(makeNoise(Size(12 + seed % 20, 12), seed), image, size, 0, 0, INTER_CUBIC);
    return image;
}

Mat randomMask(RNG& rng, Size size)
{
    const int kind = rng.uniform(0, 8);
    Mat mask(size, CV_8UC1, Scalar(kind % 2 ? 0 : 255));
    const Scalar value(kind % 2 ? 255 : 0);
    const int counts[] = {size.area() / 80, 40, 12, 8};
    for (int i = rng.uniform(1, counts[kind / 2] + 1); i > 0; i--)
    {
        const Point p(rng.uniform(0, size.width), rng.uniform(0, size.height));
        const Point q(rng.uniform(0, size.width), rng.uniform(0, size.height));
        if (kind / 2 == 0)
            mask.at<uchar>(p) = uchar(value[0]);
        else if (kind / 2 == 1)
            circle(mask, p, rng.uniform(0, 9), value, -1);
        else if (kind / 2 == 2)
            line(mask, p, q, value, rng.uniform(1, 9));
        else
            rectangle(mask, p, q, value, -1);
    }
    return mask;
}

float randomResponse(RNG& rng, int kind)
{
    const float odd[] = {NOT_A_NUMBER, -NOT_A_NUMBER, -ENDLESS, -FLT_MAX, -1.f,    -1e-42f, -0.f,
                         0.f,          1e-45f,        1e-38f,   1.f,      FLT_MAX, ENDLESS, ENDLESS};
    if (kind == 0 || (kind == 1 && rng.uniform(0, 3) == 0))
        return odd[rng.uniform(0, 14)];
    if (kind == 2)
        return float(rng.uniform(0, 3));  // many are equal
    return kind == 3 ? 7 : std::ldexp(rng.uniform(1.f, 2.f), rng.uniform(-149, 128));
}

static std::string textOf(const KeyPoint& k)
{
    return format("(%.9g, %.9g) octave %d angle %.9g response %.9g size %.9g class %d", k.pt.x, k.pt.y,
                  k.octave, k.angle, k.response, k.size, k.class_id);
}

::testing::AssertionResult sameKeypoints(const KeyPoints& a, const KeyPoints& b)
{
    if (a.size() != b.size())
        return ::testing::AssertionFailure() << a.size() << " keypoints against " << b.size();
    for (size_t i = 0; i < a.size(); i++)
    {
        if (std::memcmp(&a[i], &b[i], sizeof(KeyPoint)) != 0)
            return ::testing::AssertionFailure()
                   << "keypoint " << i << ": " << textOf(a[i]) << " against " << textOf(b[i]);
    }
    return ::testing::AssertionSuccess();
}

::testing::AssertionResult sameMat(const Mat& a, const Mat& b)
{
    if (a.empty() && b.empty())
        return ::testing::AssertionSuccess();
    if (a.size() != b.size() || a.type() != b.type())
        return ::testing::AssertionFailure()
               << a.rows << " x " << a.cols << " against " << b.rows << " x " << b.cols;
    for (int y = 0; y < a.rows; y++)
    {
        if (std::memcmp(a.ptr(y), b.ptr(y), a.cols * a.elemSize()) != 0)
            return ::testing::AssertionFailure() << "row " << y << " differs";
    }
    return ::testing::AssertionSuccess();
}

::testing::AssertionResult sameFeatures(const Features& a, const Features& b)
{
    const ::testing::AssertionResult keypoints = sameKeypoints(a.keypoints, b.keypoints);
    return keypoints ? sameMat(a.descriptors, b.descriptors) : keypoints;
}

::testing::AssertionResult finds(Feature2D& detector, const Mat& image, const Mat& mask,
                                 const Features& expected)
{
    const ::testing::AssertionResult isFound =
        sameFeatures(expected, detectAndCompute(detector, image, mask));
    Features computed = {expected.keypoints, Mat()};
    detector.compute(image, computed.keypoints, computed.descriptors);
    return isFound ? sameFeatures(expected, computed) : isFound;
}

Mat atOffset(const Mat& image, int offset)
{
    const int ALIGNMENT = 64, ROWS = 8, element = int(image.elemSize());
    const size_t rowBytes = alignSize(size_t(image.cols) * element + 3 * ALIGNMENT, ALIGNMENT);
    Mat whole(image.rows + 2 * ROWS, int(rowBytes / element), image.type());
    const int before = int(size_t(whole.data) % ALIGNMENT);
    const int left = (ALIGNMENT + (offset - before + ALIGNMENT) % ALIGNMENT) / element;
    cv::copyMakeBorder(~image, whole, ROWS, ROWS, left, whole.cols - left - image.cols, BORDER_REFLECT_101);
    Mat part = whole(Rect(left, ROWS, image.cols, image.rows));
    image.copyTo(part);
    CV_Assert(size_t(part.ptr(part.rows - 1)) % ALIGNMENT == size_t(offset));
    return part;
}

bool isAround(const Mat& part, int value)
{
    Size size;
    Point origin;
    part.locateROI(size, origin);
    Mat whole = part;
    whole.adjustROI(size.height, size.height, size.width, size.width);
    return countNonZero(whole != value) == countNonZero(part != value);
}

}  // namespace opencv_test
