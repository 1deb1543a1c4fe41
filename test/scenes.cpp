// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "scenes.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace opencv_test
{
using namespace cv;

Mat makeScene(Size size, int seed)
{
    RNG rng(seed);
    Mat scene(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
            scene.at<uchar>(y, x) = uchar(90 + 60 * x / size.width + 30 * y / size.height);
    const int area = size.area(), longest = std::max(size.width, size.height);
    for (int i = 0; i < 12 + area / 1500; i++)
    {
        // Drawn one after another: in which order the arguments of a call are evaluated depends on compiler and CPU.
        const int centerY = rng.uniform(0, size.height), centerX = rng.uniform(0, size.width);
        const Point center(centerX, centerY);
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
            for (Point& point : points)
            {
                const int y = rng.uniform(-radius, radius + 1), x = rng.uniform(-radius, radius + 1);
                point = center + Point(x, y);
            }
            fillConvexPoly(scene, points, 4, grey);
        }
    }
    // Texture on the left, nothing but slopes in the upper right.
    for (int y = 0; y < size.height; y++)
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

Mat makeIntegerScene(Size size, uint64_t seed, int channels)
{
    RNG rng(seed);
    Mat scene(size, CV_8UC(channels));
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width * channels; x++)
            scene.ptr(y)[x] = uchar(60 + 80 * x / (size.width * channels) + 40 * y / size.height);
    for (int i = 0; i < size.area() / 900; i++)
    {
        // Braces: they have an order of evaluation.
        const Rect rect{rng.uniform(0, size.width), rng.uniform(0, size.height), rng.uniform(3, 30),
                        rng.uniform(3, 30)};
        const Scalar colour{double(rng.uniform(0, 256)), double(rng.uniform(0, 256)),
                            double(rng.uniform(0, 256)), 255};
        scene(rect & Rect(Point(), size)).setTo(colour);
    }
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width * channels; x++)
        {
            const int noise = x < size.width * channels / 3 ? 30 : 3;
            uchar& value = scene.ptr(y)[x];
            value = saturate_cast<uchar>(value + rng.uniform(-noise, noise + 1));
        }
    return scene;
}

}  // namespace opencv_test
