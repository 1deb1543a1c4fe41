// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks images, masks, keypoints and output arguments, and converts images to grey.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "detector/index_sort.hpp"
#include "detector/types.hpp"
#include "detector/arguments.hpp"
#include "detector/pyramid.hpp"

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

// Limit on the octaves of given keypoints. Another detector may have more levels than this one.
static const int MAX_GIVEN_LEVELS = 64;

// Highest octave of the keypoints, or 0 without keypoints. Throws if an octave is negative or an angle is not finite.
static int highestOctave(const std::vector<KeyPoint>& keypoints)
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
        // A NaN or infinite angle would make the descriptor read outside the image.
        if (!std::isfinite(keypoints[i].angle))
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints must have a finite angle, got %g", keypoints[i].angle));
        highest = std::max(highest, octave);
    }
    return highest;
}

std::vector<FeatureList> groupGivenKeypoints(const std::vector<KeyPoint>& keypoints,
                                             const Parameters& parameters, Size imageSize)
{
    const int highest = highestOctave(keypoints);
    parameters.checkTogether(std::max(parameters.nlevels, highest > 0 ? 2 : 1));
    const auto scaleOf = [&](int octave)
    { return levelScale(octave, parameters.firstLevel, parameters.scaleFactor); };
    const Size smallest = levelSize(imageSize, scaleOf(highest));
    const int most = std::max(parameters.nlevels, MAX_GIVEN_LEVELS);
    if (highest >= most || smallest.width < 1 || smallest.height < 1)
        CV_Error_(
            Error::StsOutOfRange,
            ("keypoints must have octaves below %d whose levels have pixels, got octave %d (SIFT packs more "
             "than the octave into the field: unpack it first)",
             most, highest));

    std::vector<float> inverseScales;
    for (int octave = 0; octave <= highest; octave++)
        inverseScales.push_back(1.f / scaleOf(octave));
    const auto pointOf = [&](const KeyPoint& keypoint)
    {
        const Point2f p = keypoint.pt * inverseScales[keypoint.octave];
        return FeaturePoint{cvRound(p.x), cvRound(p.y), keypoint.angle};
    };
    // The area begins half a pixel before the centre of the first pixel and ends a whole pixel after the centre of the
    // last pixel. cv::ORB also describes points of the last half pixel, although they round to a pixel beside the
    // image. On an enlarged level half a pixel of the image is many pixels wide, and cv::ORB reads foreign memory
    // there. Keypoints more than one pixel outside the level are therefore dropped.
    const Rect2f area(-0.5f, -0.5f, float(imageSize.width) + 0.5f, float(imageSize.height) + 0.5f);
    const auto isReadable = [&](const KeyPoint& keypoint)
    { return area.contains(keypoint.pt) && pointOf(keypoint).x >= -1 && pointOf(keypoint).y >= -1; };
    std::vector<KeyPoint> inside;
    std::copy_if(keypoints.begin(), keypoints.end(), std::back_inserter(inside), isReadable);
    // OpenCV's own filter drops keypoints near the border, because its versions differ in rounding positions.
    const int border = std::min(parameters.edgeThreshold, std::max(imageSize.width, imageSize.height));
    KeyPointsFilter::runByImageBorder(inside, imageSize, border);
    std::vector<FeatureList> features(inside.empty() ? 0 : size_t(highestOctave(inside)) + 1);
    std::vector<uint64> rasterKeys;
    for (const KeyPoint& keypoint : inside)
        rasterKeys.push_back(uint64(pointOf(keypoint).y + 1) << 32 | uint64(pointOf(keypoint).x + 1));
    for (unsigned index : sortIndices(rasterKeys))
    {
        FeatureList& list = features[size_t(inside[index].octave)];
        list.points.push_back(pointOf(inside[index]));
        list.keypoints.push_back(inside[index]);
        list.outputKeys.push_back(index);
    }
    return features;
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
