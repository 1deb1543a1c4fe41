// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Keypoints of a camera's or a video's images, with a slider for the threshold. Where there is no display, the
// same numbers are printed.

#include <opencv2/aqorb.hpp>
#include <opencv2/highgui.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include <cstdlib>
#include <iostream>

using namespace cv;

static const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{@source        | 0    | number of a camera, a video or a pattern of images such as frame_%02d.png }"
    "{nfeatures      | 1000 | number of keypoints to ask for }"
    "{threshold      | 20   | FastThreshold to begin with: 20 is the adaptive threshold as it is }"
    "{frames         | 0    | number of images to stop after; 0: at the end }"
    "{headless       |      | print instead of opening a window, as where there is no display }"
    "{out            |      | picture to write the last image to }";

static const char* const WINDOW = "aqorb (space: cv::ORB and back; Esc: end)";

static bool hasDisplay()
{
#if defined __unix__ && !defined __APPLE__
    // Some of OpenCV's window systems end the program where there is none.
    const char* const variables[] = {"DISPLAY", "WAYLAND_DISPLAY"};
    for (const char* variable : variables)
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

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about("Shows the keypoints of AdaptiveQuadtreeORB in a video.");
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }
    const String source = parser.get<String>("@source"), out = parser.get<String>("out");
    const int nfeatures = parser.get<int>("nfeatures"), frames = parser.get<int>("frames");
    int threshold = parser.get<int>("threshold");
    const bool window = !parser.has("headless") && hasDisplay();
    if (!parser.check())
    {
        parser.printErrors();
        return 1;
    }
    VideoCapture capture;
    if (source.find_first_not_of("0123456789") == String::npos)
        capture.open(std::atoi(source.c_str()));
    else
        capture.open(source);
    if (!capture.isOpened())
    {
        std::cerr << source << ": cannot be opened" << std::endl;
        return 1;
    }

    const Ptr<ORB> ours = aqorb::AdaptiveQuadtreeORB::create(nfeatures), orb = ORB::create(nfeatures);
    bool usesOrb = false;
    if (window)
    {
        namedWindow(WINDOW);
        createTrackbar("FastThreshold", WINDOW, nullptr, 100);
        setTrackbarPos("FastThreshold", WINDOW, threshold);
    }
    Mat frame, picture;
    int count = 0;
    for (; (frames == 0 || count < frames) && capture.read(frame); count++)
    {
        if (window)
            threshold = getTrackbarPos("FastThreshold", WINDOW);
        const Ptr<ORB>& detector = usesOrb ? orb : ours;
        detector->setFastThreshold(threshold);
        std::vector<KeyPoint> keypoints;
        Mat descriptors;
        TickMeter timer;
        timer.start();
        detector->detectAndCompute(frame, noArray(), keypoints, descriptors);
        timer.stop();
        const String text =
            format("%s, threshold %d: %d keypoints in %.0f %% of the cells, %.1f ms",
                   usesOrb ? "ORB" : "AdaptiveQuadtreeORB", threshold, int(keypoints.size()),
                   100 * aqorb::distributionOccupancy(keypoints, frame.size()), timer.getTimeMilli());
        drawKeypoints(frame, keypoints, picture, Scalar(0, 255, 255));
        putText(picture, text, Point(10, 25), FONT_HERSHEY_SIMPLEX, 0.6, Scalar(0, 255, 0), 2, LINE_AA);
        if (!window)
        {
            std::cout << text << std::endl;
            continue;
        }
        imshow(WINDOW, picture);
        const int key = waitKey(1);
        if (key == 27)
            break;
        usesOrb ^= key == ' ';
    }
    if (picture.empty())
    {
        std::cerr << source << ": no image" << std::endl;
        return 1;
    }
    if (!out.empty() && !imwrite(out, picture))
    {
        std::cerr << out << ": cannot be written" << std::endl;
        return 1;
    }
    return 0;
}
