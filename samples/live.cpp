// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Shows the keypoints in the images of a camera or a video, with a slider for the threshold. If there is no display,
// the same numbers are printed.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/highgui.hpp>
#include <opencv2/videoio.hpp>

using namespace cv;

static const char* const ABOUT =
    "Shows the keypoints of AdaptiveQuadtreeORB in the images of a camera or of a video, with a slider for\n"
    "its threshold. The space bar changes to cv::ORB and back, Esc ends.";

static const char* const KEYS =
    "{help      |      | print this text }"
    "{nfeatures | 1000 | number of keypoints to ask for }"
    "{threshold | 20   | FastThreshold to begin with: 20 is the adaptive threshold as it is }"
    "{headless  |      | print instead of opening a window, as where there is no display }"
    "{@source   | 0    | number of a camera, a video, or a pattern of images such as frame_%02d.png }";

static const char* const WINDOW = "aqorb (space: cv::ORB and back; Esc: end)";

static bool hasDisplay()
{
#if defined __unix__ && !defined __APPLE__
    // Some of OpenCV's window systems end the program if there is no display.
    return std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
#else
    return true;
#endif
}

// Opens a camera or a file.
static void openSource(const String& source, VideoCapture& capture)
{
    if (source.find_first_not_of("0123456789") == String::npos && source.size() < 6)
    {
        if (!capture.open(std::atoi(source.c_str())))
            CV_Error(Error::StsObjectNotFound,
                     source + ": there is no such camera; the name of a video is accepted, too");
        return;
    }
    const String sample = samples::findFile(source, false, true);  // a file, or one of OpenCV's samples
    if (sample.empty() && source.find('%') == String::npos)
        CV_Error(Error::StsObjectNotFound, source + ": there is no such file");
    if (!capture.open(sample.empty() ? source : sample))
        CV_Error(Error::StsParseError,
                 source + ": not a video, nor a pattern of images, that OpenCV can read");
}

static int live(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String source = option<String>(parser, "@source");
    const int nfeatures = option<int>(parser, "nfeatures");
    int threshold = option<int>(parser, "threshold");
    const bool window = !parser.has("headless") && hasDisplay();
    VideoCapture capture;
    openSource(source, capture);
    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures), orb = ORB::create(nfeatures);
    if (window)
    {
        namedWindow(WINDOW);
        createTrackbar("FastThreshold", WINDOW, nullptr, 100);
        setTrackbarPos("FastThreshold", WINDOW, threshold);
    }
    bool usesOrb = false;
    Mat frame, picture;
    while (capture.read(frame))
    {
        if (window)
            threshold = getTrackbarPos("FastThreshold", WINDOW);
        const Ptr<ORB>& detector = usesOrb ? orb : ours;
        detector->setFastThreshold(threshold);
        std::vector<KeyPoint> keypoints;
        Mat descriptors;
        TickMeter time;
        time.start();
        detector->detectAndCompute(frame, noArray(), keypoints, descriptors);
        time.stop();
        const String text =
            format("%s, threshold %d: %d keypoints in %.0f %% of the cells, %.1f ms",
                   usesOrb ? "ORB" : "AdaptiveQuadtreeORB", threshold, int(keypoints.size()),
                   100 * aqorb::distributionOccupancy(keypoints, frame.size()), time.getTimeMilli());
        drawKeypoints(frame, keypoints, picture, Scalar(0, 255, 255));
        putText(picture, text, Point(8, 20), FONT_HERSHEY_SIMPLEX, 0.5, Scalar(0, 255, 0), 1, LINE_AA);
        if (!window)
        {
            std::cout << text << std::endl;
            continue;
        }
        imshow(WINDOW, picture);
        const int key = waitKey(30), ESC = 27;
        if (key == ESC || getWindowProperty(WINDOW, WND_PROP_VISIBLE) < 1)
            break;
        usesOrb ^= key == ' ';
    }
    if (picture.empty())
        CV_Error(Error::StsParseError, source + ": not one image can be read from it");
    return 0;
}

int main(int argc, char** argv)
{
    return runSample(live, argc, argv);
}
