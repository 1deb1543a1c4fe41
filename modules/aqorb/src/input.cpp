// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "input.hpp"
#include "pyramid.hpp"

#include <opencv2/aqorb/features.hpp>

namespace cv
{
namespace aqorb
{
namespace stages
{

// Whether the argument is a vector of images, or of vectors, where one matrix is wanted.
static bool isSequence(const _InputArray& array)
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

void checkImage(InputArray input)
{
    if (isSequence(input))
        CV_Error_(Error::StsBadArg,
                  ("image: got a sequence of %d images; a single one is accepted", int(input.total())));
    const int depth = input.depth(), channels = input.channels();
    if (input.dims() > 2 || depth != CV_8U || (channels != 1 && channels != 3 && channels != 4))
        CV_Error_(Error::StsBadArg,
                  ("image: got %d dimensions of type %s; a CV_8U image with 1 (grey), 3 (BGR) or 4 "
                   "(BGRA) channels is accepted",
                   input.dims(), typeToString(input.type()).c_str()));
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
        if (memory->size() < image.total())
            memory->resize(image.total());
        gray = Mat(image.size(), CV_8UC1, memory->data());
    }
    cvtColor(image, gray, COLOR_BGR2GRAY);
    return gray;
}

void checkPyramidInput(Size imageSize)
{
    if (std::max(imageSize.width, imageSize.height) > MAX_LEVEL_SIDE)
        CV_Error_(Error::StsOutOfRange, ("image: got %d x %d pixels; at most %d a side are accepted",
                                         imageSize.width, imageSize.height, MAX_LEVEL_SIDE));
}

UMat heldUMat(InputArray input)
{
    return input.isUMat() ? input.getUMat() : UMat();
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
    if (isSequence(input))
        CV_Error_(Error::StsBadArg,
                  ("mask: got a sequence of %d masks; a single one is accepted", int(input.total())));
    if (input.dims() > 2 || input.type() != CV_8UC1 || input.size() != imageSize)
        CV_Error_(Error::StsBadArg,
                  ("mask: got %d x %d of type %s; CV_8UC1 of the image's size %d x %d is accepted",
                   input.cols(), input.rows(), typeToString(input.type()).c_str(), imageSize.width,
                   imageSize.height));
    return input.getMat();
}

bool shareMemory(const Mat& a, const Mat& b)
{
    if (a.empty() || b.empty())
        return false;
    const std::less<const uchar*> before = std::less<const uchar*>();
    const uchar *endOfA = a.ptr(a.rows - 1) + a.cols * a.elemSize(),
                *endOfB = b.ptr(b.rows - 1) + b.cols * b.elemSize();
    return before(a.data, endOfB) && before(b.data, endOfA);
}

void checkLevelsOutput(OutputArrayOfArrays levels)
{
    const int kind = levels.kind();
    if (kind != _InputArray::STD_VECTOR_MAT && kind != _InputArray::STD_ARRAY_MAT &&
        kind != _InputArray::STD_VECTOR_UMAT)
        CV_Error_(Error::StsBadArg, ("levels: got an output of kind %d; a vector of Mat or UMat is accepted",
                                     kind >> _InputArray::KIND_SHIFT));
    // OpenCV leaves the type of images that are put into a vector of them unchecked.
    if (levels.fixedType() && levels.type() != CV_8UC1)
        CV_Error_(Error::StsBadArg, ("levels: got an output of fixed type %s; CV_8UC1 is accepted",
                                     typeToString(levels.type()).c_str()));
}

void createLevels(OutputArrayOfArrays levels, int count)
{
    const bool isFixed = levels.fixedSize() || levels.kind() == _InputArray::STD_ARRAY_MAT;
    if (isFixed && levels.total() != size_t(count))
        CV_Error_(Error::StsBadSize, ("levels: got an output of %d images; the %d of the levels, or an "
                                      "output that can be resized, is accepted",
                                      int(levels.total()), count));
    levels.create(count, 1, CV_8UC1);
}

void checkDescriptorsOutput(OutputArray descriptors)
{
    if (isSequence(descriptors))
        CV_Error(Error::StsBadArg, "descriptors: got a sequence of outputs; a single one is accepted");
    if (descriptors.fixedType() && descriptors.type() != CV_8UC1)
        CV_Error_(Error::StsBadArg, ("descriptors: got an output of fixed type %s; CV_8UC1 is accepted",
                                     typeToString(descriptors.type()).c_str()));
}

// Throws if the size of the output is fixed to another one.
static void checkDescriptorsSize(OutputArray descriptors, Size size)
{
    if (descriptors.fixedSize() && descriptors.size() != size)
        CV_Error_(Error::StsBadSize,
                  ("descriptors: got an output of fixed size %d x %d; the %d x %d of the keypoints, or an "
                   "output that can be resized, is accepted",
                   descriptors.cols(), descriptors.rows(), size.width, size.height));
}

Mat createDescriptors(OutputArray descriptors, int count)
{
    checkDescriptorsSize(descriptors, Size(ORB::kBytes, count));
    descriptors.create(count, ORB::kBytes, CV_8UC1);
    return descriptors.getMat();
}

void releaseDescriptors(OutputArray descriptors)
{
    checkDescriptorsSize(descriptors, Size());
    if (!descriptors.fixedSize())
        descriptors.release();
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

// Whether a point is inside the image. The image begins half a pixel before the centre of its first pixel and ends a
// whole pixel behind the centre of its last one. In the last half pixel a point rounds to a pixel beside the image, but
// cv::ORB describes it there.
static bool isInside(const Point2f& pt, const Size& size)
{
    return pt.x >= -0.5f && pt.y >= -0.5f && pt.x < float(size.width) && pt.y < float(size.height);
}

void describableKeypoints(const std::vector<KeyPoint>& keypoints, Size imageSize, int edgeThreshold,
                          std::vector<KeyPoint>& describable)
{
    describable.clear();
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        if (isInside(keypoints[i].pt, imageSize))
            describable.push_back(keypoints[i]);
    }
    const int border = std::min(edgeThreshold, std::max(imageSize.width, imageSize.height));
    KeyPointsFilter::runByImageBorder(describable, imageSize, border);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
