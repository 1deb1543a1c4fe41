// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Masks the black corners of a fisheye lens's image, whose rim would otherwise take keypoints.

#include <opencv2/aqorb.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <cstdio>

using namespace cv;

static const char* const KEYS =
    "{help h usage ? |                  | print this text }"
    "{@image         | graf1.png        | image of a fisheye lens }"
    "{x              | -1               | centre of the lens's circle, in pixels; -1: of the image }"
    "{y              | -1               | }"
    "{radius         | -1               | radius of the circle; -1: up to the nearest side }"
    "{margin         | 8                | pixels to keep away from the circle's rim }"
    "{nfeatures      | 1000             | number of keypoints to ask for }"
    "{out            | fisheye_mask.jpg | picture to write }";

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about("Finds keypoints inside the circle of a fisheye lens.");
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }
    const Mat image = imread(samples::findFile(parser.get<String>("@image"), false), IMREAD_GRAYSCALE);
    Point centre(parser.get<int>("x"), parser.get<int>("y"));
    int radius = parser.get<int>("radius");
    const int margin = parser.get<int>("margin"), nfeatures = parser.get<int>("nfeatures");
    const String out = parser.get<String>("out");
    if (!parser.check() || image.empty())
    {
        parser.printErrors();
        std::fprintf(stderr, "%s", image.empty() ? "The image cannot be read\n" : "");
        return 1;
    }
    if (centre.x < 0)
        centre.x = image.cols / 2;
    if (centre.y < 0)
        centre.y = image.rows / 2;
    if (radius < 0)
        radius =
            std::min(std::min(centre.x, image.cols - centre.x), std::min(centre.y, image.rows - centre.y));

    // Not zero where keypoints may lie; the detector scales the mask for its pyramid.
    Mat mask = Mat::zeros(image.size(), CV_8UC1);
    circle(mask, centre, std::max(radius - margin, 0), Scalar(255), FILLED);

    const Ptr<ORB> detector = aqorb::AdaptiveQuadtreeORB::create(nfeatures);
    Mat pictures[2];
    for (int masked = 0; masked < 2; masked++)
    {
        std::vector<KeyPoint> keypoints;
        detector->detect(image, keypoints, masked ? mask : Mat());
        int outside = 0;
        for (const KeyPoint& keypoint : keypoints)
            outside += norm(keypoint.pt - Point2f(centre)) > radius - margin + 1;
        const String text = format("%s mask: %d keypoints, %d not inside the circle",
                                   masked ? "With" : "Without", int(keypoints.size()), outside);
        std::printf("%s\n", text.c_str());
        drawKeypoints(image, keypoints, pictures[masked], Scalar(0, 255, 255));
        circle(pictures[masked], centre, radius - margin, Scalar(0, 255, 0), 1, LINE_AA);
        putText(pictures[masked], text, Point(10, 25), FONT_HERSHEY_SIMPLEX, 0.6, Scalar(0, 255, 0), 2,
                LINE_AA);
    }
    Mat picture;
    hconcat(pictures[0], pictures[1], picture);
    if (!imwrite(out, picture))
    {
        std::fprintf(stderr, "%s: cannot be written\n", out.c_str());
        return 1;
    }
    std::printf("Picture: %s\n", out.c_str());
    return 0;
}
