// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Puts features in the order of the output, and writes them.

#include "precomp.hpp"

#include "descriptor.hpp"
#include "index_sort.hpp"
#include "input.hpp"
#include "output.hpp"

#include <opencv2/aqorb/features.hpp>

namespace cv
{
namespace aqorb
{

void outputFeatures(const std::vector<FeatureList>& features, std::vector<KeyPoint>& keypoints,
                    Mat& descriptors)
{
    CV_TRACE_FUNCTION();
    keypoints.clear();
    for (const FeatureList& level : features)
    {
        for (unsigned i : sortIndices(level.outputKeys))
        {
            if (!descriptors.empty())
                std::memcpy(descriptors.ptr(int(keypoints.size())),
                            &level.descriptors[size_t(i) * ORB::kBytes], ORB::kBytes);
            keypoints.push_back(level.keypoints[i]);
        }
    }
}

void checkMatsOutput(OutputArrayOfArrays output, const char* name)
{
    checkIsOfMats(output, name);
    // OpenCV leaves the type of matrices that are put into a vector of them unchecked.
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
