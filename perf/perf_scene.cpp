// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "perf_scene.hpp"

#include <opencv2/imgproc.hpp>

namespace opencv_test
{
using namespace cv;

namespace
{

//! Noise of several spatial frequencies, mean 0; the finest has the given grain in pixels.
Mat fractalNoise(const Size& size, double grain, float amplitude, RNG& rng)
{
    Mat sum = Mat::zeros(size, CV_32F);
    for (int octave = 0; octave < 5; octave++, grain *= 2)
    {
        Mat noise(Size(cvCeil(size.width / grain) + 1, cvCeil(size.height / grain) + 1), CV_32F);
        rng.fill(noise, RNG::NORMAL, 0, amplitude);
        resize(noise, noise, size, 0, 0, INTER_CUBIC);
        sum += noise;
    }
    return sum;
}

void drawHouse(Mat& scene, const Rect& house, RNG& rng)
{
    Mat wall = scene(house & Rect(Point(), scene.size()));
    wall.setTo(Scalar::all(rng.uniform(40, 200)));
    if (rng.uniform(0, 3) == 0)  // plaster; the other walls are plain
        wall += fractalNoise(wall.size(), 1.5, 7.f, rng);

    const int pitch = std::max(house.width / rng.uniform(3, 9), 8);
    const double pane = rng.uniform(20, 220);
    for (int y = pitch / 2; y + pitch < house.height; y += pitch * 3 / 2)
        for (int x = pitch / 3; x + pitch * 2 / 3 < house.width; x += pitch)
        {
            const Rect window(house.x + x, house.y + y, pitch * 2 / 3, pitch);
            rectangle(scene, window, Scalar::all(pane + rng.uniform(-20, 20)), FILLED);
            line(scene, Point(window.x, window.y + pitch / 2), Point(window.br().x, window.y + pitch / 2),
                 Scalar::all(230), 1 + pitch / 24);
        }
}

}  // namespace

Mat makeStreetScene(const Size& size)
{
    RNG rng(20191);
    const int horizon = size.height / 2;

    Mat scene(size, CV_32F);
    for (int y = 0; y < size.height; y++)  // sky
        scene.row(y).setTo(Scalar::all(210. - 60. * y / size.height));

    Mat ground = scene.rowRange(horizon, size.height);
    ground = fractalNoise(ground.size(), 2, 11.f, rng) + 95;

    for (int i = 0; i < 14; i++)
    {
        const int width = size.width * rng.uniform(8, 20) / 100;
        const int height = size.height * rng.uniform(15, 50) / 100;
        const Point corner(rng.uniform(-width / 4, size.width - width / 2),
                           horizon + size.height * rng.uniform(-2, 15) / 100 - height);
        drawHouse(scene, Rect(corner, Size(width, height)), rng);
    }

    for (int i = 0; i < 12; i++)  // signs, cars: slanted shapes in front
    {
        const Point2f centre(rng.uniform(0.f, (float)size.width),
                             rng.uniform((float)horizon, (float)size.height));
        const Size2f extent(size.width * rng.uniform(0.02f, 0.12f), size.height * rng.uniform(0.02f, 0.1f));
        Point2f corners[4];
        RotatedRect(centre, extent, rng.uniform(0.f, 90.f)).points(corners);
        const std::vector<Point> shape(corners, corners + 4);
        fillConvexPoly(scene, shape, Scalar::all(rng.uniform(10, 240)), LINE_8);
    }

    GaussianBlur(scene, scene, Size(), 0.7);
    Mat noise(size, CV_32F);
    rng.fill(noise, RNG::NORMAL, 0, 2);
    scene += noise;
    scene.convertTo(scene, CV_8U);
    return scene;
}

}  // namespace opencv_test
