// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Makes the files of the samples' tests from a photograph or a drawn scene: two views, three overlapping parts, a video
// of images, a stereo sequence; and unsuitable files.

#include "../../test/scenes.hpp"

#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <cstdlib>
#include <fstream>

using namespace cv;

static void save(const String& path, const Mat& image)
{
    CV_Assert(imwrite(path, image));
}

static Mat photographOrScene()
{
    const char* const data = std::getenv("OPENCV_TEST_DATA_PATH");
    const String leuven = "/cv/detectors_descriptors_evaluation/images_datasets/leuven/img1.png";
    const Mat photograph = data ? imread(data + leuven, IMREAD_GRAYSCALE) : Mat();
    return photograph.empty() ? opencv_test::makeScene(Size(900, 600)) : photograph;
}

int main(int argc, char** argv)
{
    CV_Assert(argc == 2);
    const String folder = argv[1] + String("/");
    const Mat scene = photographOrScene();

    save(folder + "view1.png", scene);
    const Matx33d homography(0.9, -0.15, 90, 0.1, 0.95, -20, 1e-4, 5e-5, 1);
    Mat view;
    warpPerspective(scene, view, homography, scene.size());
    save(folder + "view2.png", view);
    Mat depth = scene.clone();  // the right half is nearer to a camera that moved to the right
    scene.colRange(scene.cols / 2 + 40, scene.cols).copyTo(depth.colRange(scene.cols / 2, scene.cols - 40));
    save(folder + "depth.png", depth);

    // Without noise OpenCV's matcher takes both parts for the same image, and drops the pair.
    RNG rng(2);
    for (int i = 0; i < 3; i++)
    {
        Mat part, noise(Size(450, 600), CV_16S);
        scene(Rect(225 * i, 0, 450, 600)).convertTo(part, CV_16S);
        rng.fill(noise, RNG::NORMAL, 0, 10);
        part += noise;
        part.convertTo(part, CV_8U);
        save(folder + format("part%d.png", i + 1), part);
    }

    // Stereo pairs of a plane at a disparity of ten pixels, with a camera that moves ahead.
    utils::fs::createDirectories(folder + "stereo/image_0");
    utils::fs::createDirectories(folder + "stereo/image_1");
    std::ofstream(folder + "stereo/calib.txt") << "P0: 500 0 320 0 0 500 240 0 0 0 1 0\n"
                                                  "P1: 500 0 320 -250 0 500 240 0 0 0 1 0\n";
    for (int i = 0; i < 3; i++)
    {
        save(folder + format("stereo/image_0/%06d.png", i), scene(Rect(60 + 4 * i, 50, 640, 480)));
        save(folder + format("stereo/image_1/%06d.png", i), scene(Rect(70 + 4 * i, 50, 640, 480)));
    }

    Mat noise(480, 640, CV_8U);
    rng.fill(noise, RNG::UNIFORM, 0, 256);
    save(folder + "noise.png", noise);

    std::ofstream(folder + "text.png") << "no image";
    save(folder + "32x32.png", scene(Rect(0, 0, 32, 32)));
    save(folder + "1x1.png", scene(Rect(0, 0, 1, 1)));
    return 0;
}
