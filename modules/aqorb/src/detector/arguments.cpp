// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks masks, collections and output arguments.

#include "precomp.hpp"

#include "detector/arguments.hpp"
#include "detector/parameters.hpp"

namespace cv
{
namespace aqorb
{

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
        CV_Error_(Error::StsBadArg, ("mask must be one image, got a sequence of %d", int(input.total())));
    if (input.dims() > 2 || input.type() != CV_8UC1 || input.size() != imageSize)
        CV_Error_(Error::StsBadArg,
                  ("mask must be CV_8UC1 of the image's size, %d x %d, got %d x %d of type %s",
                   imageSize.width, imageSize.height, input.cols(), input.rows(),
                   typeToString(input.type()).c_str()));
    Mat mask = input.getMat();
    for (int y = 0; y < mask.rows; y++)
        if (countNonZero(mask.row(y)) < mask.cols)
            return mask;
    return Mat();
}

static void checkMatVector(const _InputArray& array, const char* name)
{
    const int kind = array.kind();
    if (kind != _InputArray::STD_VECTOR_MAT && kind != _InputArray::STD_ARRAY_MAT &&
        kind != _InputArray::STD_VECTOR_UMAT)
        CV_Error_(Error::StsBadArg, ("%s must be a vector of Mat or UMat", name));
}

// Matrices of a vector argument; empty for noArray(). `retained` keeps UMats alive while their Mats are in use.
static std::vector<Mat> inputMats(const _InputArray& array, const char* name, std::vector<UMat>& retained)
{
    std::vector<Mat> mats;
    if (array.kind() == _InputArray::NONE)
        return mats;
    checkMatVector(array, name);
    for (int i = 0, count = int(array.total()); i < count; i++)
    {
        if (array.isUMatVector())
            retained.push_back(array.getUMat(i));
        mats.push_back(array.getMat(i));
    }
    return mats;
}

Collection::Collection(InputArrayOfArrays images_, InputArrayOfArrays masks_)
    : images(inputMats(images_, "images", retained)), masks(inputMats(masks_, "masks", retained))
{
    if (!masks.empty() && masks.size() != images.size())
        CV_Error_(Error::StsBadArg, ("masks must be one for each image or none, got %d for %d images",
                                     int(masks.size()), int(images.size())));
}

void checkMatsOutput(OutputArrayOfArrays output, const char* name)
{
    checkMatVector(output, name);
    // OpenCV does not check the type of the matrices in a vector.
    if (output.fixedType() && output.type() != CV_8UC1)
        CV_Error_(Error::StsBadArg,
                  ("%s must be of type CV_8UC1, got %s", name, typeToString(output.type()).c_str()));
}

void assignMats(const std::vector<Mat>& mats, OutputArrayOfArrays output, const char* name)
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
            // A new UMat: the old one may share its memory with others.
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

Mat createDescriptors(OutputArray descriptors, int count)
{
    const Size size = count > 0 ? Size(ORB::kBytes, count) : Size();
    if (descriptors.kind() == _InputArray::STD_VECTOR && size.height > 1)
        CV_Error_(Error::StsBadSize,
                  ("descriptors must be a matrix, got a std::vector for %d keypoints", size.height));
    if (descriptors.fixedSize() && descriptors.size() != size)
        CV_Error_(Error::StsBadSize,
                  ("descriptors must have a variable size or that of the keypoints, %d x %d, got %d x %d",
                   size.width, size.height, descriptors.cols(), descriptors.rows()));
    if (count > 0)
        descriptors.create(size, CV_8UC1);
    else if (!descriptors.fixedSize())
        descriptors.release();
    return descriptors.getMat();
}

}  // namespace aqorb
}  // namespace cv
