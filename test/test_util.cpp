// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "test_precomp.hpp"

#include <cstring>

namespace opencv_test
{

Features detectAndCompute(Feature2D& detector, InputArray image, InputArray mask)
{
    Features features;
    detector.detectAndCompute(image, mask, features.keypoints, features.descriptors);
    return features;
}

::testing::AssertionResult sameKeypoints(const KeyPoints& a, const KeyPoints& b)
{
    if (a.size() != b.size())
        return ::testing::AssertionFailure() << a.size() << " keypoints against " << b.size();
    for (size_t i = 0; i < a.size(); i++)
    {
        if (std::memcmp(&a[i], &b[i], sizeof(KeyPoint)) != 0)
        {
            return ::testing::AssertionFailure()
                   << "keypoint " << i << ": (" << a[i].pt.x << ", " << a[i].pt.y << ") octave "
                   << a[i].octave << " angle " << a[i].angle << " response " << a[i].response << " size "
                   << a[i].size << " against (" << b[i].pt.x << ", " << b[i].pt.y << ") octave "
                   << b[i].octave << " angle " << b[i].angle << " response " << b[i].response << " size "
                   << b[i].size;
        }
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

Mat makeScene(Size size, int seed)
{
    RNG rng(seed);
    Mat scene(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
            scene.at<uchar>(y, x) = uchar(90 + 60 * x / size.width + 30 * y / size.height);
    }
    const int area = size.area(), longest = std::max(size.width, size.height);
    for (int i = 0; i < 12 + area / 1500; i++)
    {
        const Point center(rng.uniform(0, size.width), rng.uniform(0, size.height));
        const Scalar grey(rng.uniform(0, 256));
        const int radius = rng.uniform(2, std::max(4, longest / 12));
        const int shape = rng.uniform(0, 3);
        if (shape == 0)
        {
            circle(scene, center, radius / 2 + 1, grey, -1);
        }
        else if (shape == 1)
        {
            const Point2f corner =
                RotatedRect(center, Size2f(float(radius), float(radius * 2)), float(rng.uniform(0, 180)))
                    .boundingRect2f()
                    .tl();
            line(scene, corner, center, grey, rng.uniform(1, 4));
        }
        else
        {
            Point points[4];
            for (int j = 0; j < 4; j++)
                points[j] =
                    center + Point(rng.uniform(-radius, radius + 1), rng.uniform(-radius, radius + 1));
            fillConvexPoly(scene, points, 4, grey);
        }
    }
    // Texture on the left, nothing but slopes in the upper right.
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
        {
            uchar& pixel = scene.at<uchar>(y, x);
            if (x < size.width / 3)
                pixel = saturate_cast<uchar>(pixel + rng.uniform(-25, 26));
            else if (x > size.width * 3 / 4 && y < size.height / 4)
                pixel = uchar(200 - 40 * y / size.height);
            else
                pixel = saturate_cast<uchar>(pixel + rng.uniform(-3, 4));
        }
    }
    return scene;
}

Mat makeNoise(Size size, int seed)
{
    Mat noise(size, CV_8UC1);
    RNG(seed).fill(noise, RNG::UNIFORM, 0, 256);
    return noise;
}

Mat makeDots(Size size, int seed)
{
    Mat dots = makeNoise(size, seed);
    dots.setTo(0, makeNoise(size, seed + 1) < 224);
    return dots;
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

std::string dataFile(const std::string& name)
{
    const char* folder = std::getenv("OPENCV_TEST_DATA_PATH");
    return folder && *folder ? std::string(folder) + "/" + name : std::string();
}

static std::string oxfordFile(const std::string& set, const std::string& name)
{
    return dataFile("cv/detectors_descriptors_evaluation/images_datasets/" + set + "/" + name);
}

std::string oxfordImage(const std::string& set, int index)
{
    return oxfordFile(set, format("img%d.png", index));
}

Mat oxfordHomography(const std::string& set, int index)
{
    FileStorage file(oxfordFile(set, format("H1to%dp.xml", index)), FileStorage::READ);
    Mat homography;
    if (file.isOpened())
        file.getFirstTopLevelNode() >> homography;
    return homography;
}

}  // namespace opencv_test
