// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

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

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
