// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows the keypoints in the images of a camera or a video, with a slider for the threshold. If there is no display,
// the same numbers are printed.

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/highgui.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include <cstdlib>
#include <iostream>

using namespace cv;

static const char* const KEYS =
    "{help      |      | print this text }"
    "{nfeatures | 1000 | number of keypoints to ask for }"
    "{threshold | 20   | FastThreshold to begin with: 20 is the adaptive threshold as it is }"
    "{frames    | 0    | number of images to stop after; 0: at the end }"
    "{headless  |      | print instead of opening a window, as where there is no display }"
    "{out       |      | picture to write the last image to }"
    "{@source   | 0    | number of a camera, a video, or a pattern of images such as frame_%02d.png }";

static const char* const WINDOW = "aqorb (space: cv::ORB and back; Esc: end)";

static bool hasDisplay()
{
#if defined __unix__ && !defined __APPLE__
    // Some of OpenCV's window systems end the program if there is no display.
    for (const char* variable : {"DISPLAY", "WAYLAND_DISPLAY"})
    {
        const char* value = std::getenv(variable);
        if (value && *value)
            return true;
    }
    return false;
#else
    return true;
#endif
}

// Opens a camera or a file. Returns the milliseconds from one image to the next, 0 for a camera.
static double openSource(const String& source, VideoCapture& capture)
{
    const bool isCamera = source.find_first_not_of("0123456789") == String::npos && source.size() < 6;
    if (isCamera)
        capture.open(std::atoi(source.c_str()));
    else
    {
        const String sample = samples::findFile(source, false, true);  // a file, or one of OpenCV's samples
        capture.open(sample.empty() ? source : sample);
    }
    if (!capture.isOpened() && isCamera)
        std::cerr << source << ": there is no such camera; the name of a video is accepted, too\n";
    else if (!capture.isOpened())
        std::cerr << source << ": not a video, nor a pattern of images, that OpenCV can read\n";
    const double fps = capture.get(CAP_PROP_FPS);
    return isCamera ? 0 : 1000 / (fps > 1 && fps < 1000 ? fps : 25);  // images have no rate
}

// Waits for a key, for at most this many milliseconds or, if they are 0, without end. Returns Esc if the window is
// closed.
static int waitForKey(double milliseconds)
{
    const int ESC = 27;
    const int PART = 50;  // ms; closing the window reports no key, so it is looked at this often
    const int64 start = getTickCount();
    for (;;)
    {
        const double passed = 1000 * (getTickCount() - start) / getTickFrequency();
        const double rest = milliseconds > 0 ? milliseconds - passed : PART;
        const int key = waitKey(std::max(1, std::min(cvRound(rest), PART)));
        if (getWindowProperty(WINDOW, WND_PROP_VISIBLE) < 1)
            return ESC;
        if (key >= 0 || (milliseconds > 0 && rest <= PART))
            return key;
    }
}

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(
        "Shows the keypoints of AdaptiveQuadtreeORB in the images of a camera or of a video, with a\n"
        "slider for its threshold. The space bar changes to cv::ORB and back, Esc ends; the last image\n"
        "of a video stays until a key is pressed.");
    const String source = parser.get<String>("@source"), out = parser.get<String>("out");
    const int nfeatures = parser.get<int>("nfeatures"), frames = parser.get<int>("frames");
    int threshold = parser.get<int>("threshold");
    const bool window = !parser.has("headless") && hasDisplay();
    if (parser.has("help") || !parser.check())
    {
        parser.printErrors();
        parser.printMessage();
        return !parser.check();
    }
    VideoCapture capture;
    const double interval = openSource(source, capture);
    if (!capture.isOpened())
        return 1;

    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures), orb = ORB::create(nfeatures);
    bool usesOrb = false, ended = false;
    if (window)
    {
        namedWindow(WINDOW);
        createTrackbar("FastThreshold", WINDOW, nullptr, 100);
        setTrackbarPos("FastThreshold", WINDOW, threshold);
    }
    Mat frame, picture;
    int count = 0;
    for (; !ended && (frames == 0 || count < frames); count++)
    {
        const int64 begin = getTickCount();
        if (!capture.read(frame))
            break;
        if (window)
            threshold = getTrackbarPos("FastThreshold", WINDOW);
        const Ptr<ORB>& detector = usesOrb ? orb : ours;
        detector->setFastThreshold(threshold);
        std::vector<KeyPoint> keypoints;
        Mat descriptors;
        const int64 start = getTickCount();
        detector->detectAndCompute(frame, noArray(), keypoints, descriptors);
        const double milliseconds = 1000 * double(getTickCount() - start) / getTickFrequency();
        const String text = format("%s, threshold %d: %d keypoints in %.0f %% of the cells, %.1f ms",
                                   usesOrb ? "ORB" : "AdaptiveQuadtreeORB", threshold, int(keypoints.size()),
                                   100 * aqorb::distributionOccupancy(keypoints, frame.size()), milliseconds);
        if (!window)
            std::cout << text << std::endl;
        if (!window && out.empty())
            continue;
        drawKeypoints(frame, keypoints, picture, Scalar(0, 255, 255));
        putText(picture, text, Point(8, 20), FONT_HERSHEY_SIMPLEX, 0.5, Scalar(0, 255, 0), 1, LINE_AA);
        if (!window)
            continue;
        imshow(WINDOW, picture);
        const double passed = 1000 * (getTickCount() - begin) / getTickFrequency();
        const int key = waitForKey(std::max(1., interval - passed));
        ended = key == 27;
        usesOrb ^= key == ' ';
    }
    if (count == 0)
    {
        std::cerr << source << ": not one image can be read from it\n";
        return 1;
    }
    if (!out.empty() && !imwrite(out, picture))
        return 1;
    if (window && !ended && interval > 0)
    {
        const String text = "The end of " + source + ": any key closes the window";
        std::cout << text << std::endl;
        setWindowTitle(WINDOW, text);
        waitForKey(0);
    }
    return 0;
}
