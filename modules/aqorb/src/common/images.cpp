// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks images, and converts them to grey.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "common/images.hpp"
#include "common/memory.hpp"

namespace cv
{
namespace aqorb
{

bool isSequence(const _InputArray& array)
{
    switch (array.kind())
    {
    case _InputArray::STD_VECTOR_MAT:
    case _InputArray::STD_ARRAY_MAT:
    case _InputArray::STD_VECTOR_UMAT:
    case _InputArray::STD_VECTOR_VECTOR:
        return true;
    default:
        return false;
    }
}

void checkImage(InputArray input, const char* name)
{
    if (isSequence(input))
        CV_Error_(Error::StsBadArg, ("%s must be one image, got a sequence of %d", name, int(input.total())));
    const int depth = input.depth(), channels = input.channels();
    if (input.dims() > 2 || depth != CV_8U || (channels != 1 && channels != 3 && channels != 4))
        CV_Error_(
            Error::StsBadArg,
            ("%s must be CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) channels, got %d dimensions of type %s",
             name, input.dims(), typeToString(input.type()).c_str()));
}

Mat grayImage(InputArray input, std::vector<uchar>* memory)
{
    checkImage(input);
    Mat image = input.getMat();
    if (image.channels() == 1)
        return image;
    Mat gray;
    if (memory)
    {
        growTo(*memory, image.total());
        gray = Mat(image.size(), CV_8UC1, memory->data());
    }
    // cv::cvtColor stays on the calling thread for at most PIXELS pixels, or for a single row.
    const int PIXELS = 1 << 16;
    const int rows = std::max(PIXELS / image.cols, 1), parts = (image.rows + rows - 1) / rows;
    gray.create(image.size(), CV_8UC1);
    forEach(size_t(parts), stageThreads(),
            [&](size_t i, int)
            {
                const Range part(int(i) * rows, std::min((int(i) + 1) * rows, image.rows));
                Mat grayPart = gray.rowRange(part);
                cvtColor(image.rowRange(part), grayPart, COLOR_BGR2GRAY);
            });
    return gray;
}

void checkPyramidInput(Size imageSize, const char* name)
{
    if (std::max(imageSize.width, imageSize.height) > MAX_LEVEL_SIDE)
        CV_Error_(Error::StsOutOfRange, ("%s must have at most %d pixels a side, got %d x %d", name,
                                         MAX_LEVEL_SIDE, imageSize.width, imageSize.height));
}

UMat retainUMat(InputArray input)
{
    return input.isUMat() ? input.getUMat() : UMat();
}

}  // namespace aqorb
}  // namespace cv
