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
        CV_Error_(Error::StsBadArg, ("image must be a single one, got a sequence of %d", int(input.total())));
    const int depth = input.depth(), channels = input.channels();
    if (input.dims() > 2 || depth != CV_8U || (channels != 1 && channels != 3 && channels != 4))
        CV_Error_(
            Error::StsBadArg,
            ("image must be CV_8U with 1 (grey), 3 (BGR) or 4 (BGRA) channels, got %d dimensions of type %s",
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
        CV_Error_(Error::StsOutOfRange, ("image must have at most %d pixels a side, got %d x %d",
                                         MAX_LEVEL_SIDE, imageSize.width, imageSize.height));
}

UMat heldUMat(InputArray input)
{
    return input.isUMat() ? input.getUMat() : UMat();
}

void checkImageSize(Size imageSize)
{
    if (imageSize.width <= 0 || imageSize.height <= 0)
        CV_Error_(Error::StsOutOfRange,
                  ("imageSize must be positive, got %d x %d", imageSize.width, imageSize.height));
}

Mat checkedMask(InputArray input, Size imageSize)
{
    if (input.empty())
        return Mat();
    if (isSequence(input))
        CV_Error_(Error::StsBadArg, ("mask must be a single one, got a sequence of %d", int(input.total())));
    if (input.dims() > 2 || input.type() != CV_8UC1 || input.size() != imageSize)
        CV_Error_(Error::StsBadArg,
                  ("mask must be CV_8UC1 of the image's size, %d x %d, got %d x %d of type %s",
                   imageSize.width, imageSize.height, input.cols(), input.rows(),
                   typeToString(input.type()).c_str()));
    return input.getMat();
}

static void checkIsOfMats(const _InputArray& array, const char* name)
{
    const int kind = array.kind();
    if (kind != _InputArray::STD_VECTOR_MAT && kind != _InputArray::STD_ARRAY_MAT &&
        kind != _InputArray::STD_VECTOR_UMAT)
        CV_Error_(Error::StsBadArg, ("%s must be a vector of Mat or UMat", name));
}

// The matrices of the input, which may be none. UMats are held for as long as their Mats are used.
static std::vector<Mat> inputMats(const _InputArray& array, const char* name, std::vector<UMat>& held)
{
    std::vector<Mat> mats;
    if (array.kind() == _InputArray::NONE)
        return mats;
    checkIsOfMats(array, name);
    for (int i = 0, count = int(array.total()); i < count; i++)
    {
        if (array.isUMatVector())
            held.push_back(array.getUMat(i));
        mats.push_back(array.getMat(i));
    }
    return mats;
}

Collection::Collection(InputArrayOfArrays images_, InputArrayOfArrays masks_)
    : images(inputMats(images_, "images", held)), masks(inputMats(masks_, "masks", held))
{
    if (!masks.empty() && masks.size() != images.size())
        CV_Error_(Error::StsBadArg, ("masks must be one for each image or none, got %d for %d images",
                                     int(masks.size()), int(images.size())));
}

void checkMatsOutput(OutputArrayOfArrays output, const char* name)
{
    checkIsOfMats(output, name);
    // OpenCV leaves the type of matrices that are put into a vector of them unchecked.
    if (output.fixedType() && output.type() != CV_8UC1)
        CV_Error_(Error::StsBadArg,
                  ("%s must be of type CV_8UC1, got %s", name, typeToString(output.type()).c_str()));
}

void giveMats(const std::vector<Mat>& mats, OutputArrayOfArrays output, const char* name)
{
    const int count = int(mats.size());
    const bool isFixed = output.fixedSize() || output.kind() == _InputArray::STD_ARRAY_MAT;
    if (isFixed && output.total() != mats.size())
        CV_Error_(Error::StsBadSize, ("%s must have a variable size or that of %d images, got %d images",
                                      name, count, int(output.total())));
    output.create(count, 1, CV_8UC1);
    for (int i = 0; i < count; i++)
    {
        if (output.isUMatVector())
        {
            // A new UMat, because the caller may share the old one.
            UMat copy;
            mats[i].copyTo(copy);
            output.getUMatRef(i) = copy;
        }
        else
        {
            output.getMatRef(i) = mats[i];
        }
    }
}

void checkDescriptorsOutput(OutputArray descriptors)
{
    if (isSequence(descriptors))
        CV_Error(Error::StsBadArg, "descriptors must be a single output, got a sequence");
    if (descriptors.fixedType() && descriptors.type() != CV_8UC1)
        CV_Error_(Error::StsBadArg,
                  ("descriptors must be of type CV_8UC1, got %s", typeToString(descriptors.type()).c_str()));
}

// Throws if the size of the output is fixed to another one, or it cannot have so many rows.
static void checkDescriptorsSize(OutputArray descriptors, Size size)
{
    if (descriptors.kind() == _InputArray::STD_VECTOR && size.height > 1)
        CV_Error_(Error::StsBadSize,
                  ("descriptors must be a matrix, got a std::vector for %d keypoints", size.height));
    if (descriptors.fixedSize() && descriptors.size() != size)
        CV_Error_(Error::StsBadSize,
                  ("descriptors must have a variable size or that of the keypoints, %d x %d, got %d x %d",
                   size.width, size.height, descriptors.cols(), descriptors.rows()));
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
            CV_Error_(
                Error::StsOutOfRange,
                ("keypoints must have an octave of at least 0, got %d (SIFT packs more than the octave into "
                 "the field: unpack it first)",
                 octave));
        // With such an angle the descriptor would read outside of the image.
        if (!std::isfinite(keypoints[i].angle))
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints must have a finite angle, got %g", keypoints[i].angle));
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
