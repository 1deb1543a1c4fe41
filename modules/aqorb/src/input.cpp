// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "input.hpp"

#include <opencv2/aqorb/features.hpp>

namespace cv
{
namespace aqorb
{
namespace stages
{

Mat grayImage(InputArray input)
{
    const int depth = input.depth(), channels = input.channels();
    if (input.dims() > 2 || depth != CV_8U || (channels != 1 && channels != 3 && channels != 4))
        CV_Error_(Error::StsBadArg,
                  ("image: got %d dimensions of type %s; a CV_8U image with 1 (grey), 3 (BGR) or 4 "
                   "(BGRA) channels is accepted",
                   input.dims(), typeToString(input.type()).c_str()));
    Mat image = input.getMat();
    if (channels == 1)
        return image;
    Mat gray;
    cvtColor(image, gray, COLOR_BGR2GRAY);
    return gray;
}

void checkImageSize(Size imageSize)
{
    if (imageSize.width <= 0 || imageSize.height <= 0)
        CV_Error_(Error::StsOutOfRange,
                  ("imageSize: got %d x %d; both sides > 0 are accepted", imageSize.width, imageSize.height));
}

Mat checkedMask(InputArray input, Size imageSize)
{
    if (input.empty())
        return Mat();
    if (input.dims() > 2 || input.type() != CV_8UC1 || input.size() != imageSize)
        CV_Error_(Error::StsBadArg,
                  ("mask: got %d x %d of type %s; CV_8UC1 of the image's size %d x %d is accepted",
                   input.cols(), input.rows(), typeToString(input.type()).c_str(), imageSize.width,
                   imageSize.height));
    return input.getMat();
}

int highestOctave(const std::vector<KeyPoint>& keypoints)
{
    int highest = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const int octave = keypoints[i].octave;
        if (octave < 0)
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints: got octave %d; >= 0 is accepted (SIFT packs more than the "
                       "octave into the field: unpack it first)",
                       octave));
        // With such an angle the descriptor would read outside of the image.
        if (!std::isfinite(keypoints[i].angle))
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints: got angle %g; a finite angle is accepted", keypoints[i].angle));
        highest = std::max(highest, octave);
    }
    return highest;
}

// Whether a point, rounded, is a pixel. Points far away are not rounded, because the result would depend on the CPU.
static bool isOnPixel(const Point2f& pt, const Size& size)
{
    const float width = float(size.width), height = float(size.height);
    return pt.x > -1 && pt.y > -1 && pt.x < width && pt.y < height && Rect(Point(), size).contains(Point(pt));
}

static bool hasLowerOctave(const KeyPoint& a, const KeyPoint& b)
{
    return a.octave < b.octave;
}

std::vector<KeyPoint> describableKeypoints(const std::vector<KeyPoint>& keypoints, Size imageSize,
                                           int edgeThreshold)
{
    std::vector<KeyPoint> inside;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        if (isOnPixel(keypoints[i].pt, imageSize))
            inside.push_back(keypoints[i]);
    }
    const int border = std::min(edgeThreshold, std::max(imageSize.width, imageSize.height));
    KeyPointsFilter::runByImageBorder(inside, imageSize, border);
    std::stable_sort(inside.begin(), inside.end(), hasLowerOctave);
    return inside;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
