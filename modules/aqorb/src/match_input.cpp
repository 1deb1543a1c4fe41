// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "match_input.hpp"

namespace cv
{
namespace aqorb
{

void checkHammingNorm(int normType)
{
    if (normType != NORM_HAMMING && normType != NORM_HAMMING2)
        CV_Error_(Error::StsBadArg, ("normType must be NORM_HAMMING (%d) or NORM_HAMMING2 (%d), got %d; "
                                     "cv::BFMatcher has other norms",
                                     int(NORM_HAMMING), int(NORM_HAMMING2), normType));
}

void checkDescriptors(const char* name, InputArray descriptors)
{
    if (descriptors.isMatVector() || descriptors.isUMatVector())
        CV_Error_(Error::StsBadArg,
                  ("%s must be a single matrix, got a sequence of %d", name, int(descriptors.total())));
    if (descriptors.dims() > 2 || (descriptors.type() != CV_8UC1 && !descriptors.empty()))
        CV_Error_(Error::StsBadArg, ("%s must be rows of type CV_8UC1, got %d dimensions of type %s", name,
                                     descriptors.dims(), typeToString(descriptors.type()).c_str()));
}

void checkTrainDescriptors(const char* name, InputArray descriptors, const char* queryName,
                           InputArray queryDescriptors)
{
    checkDescriptors(name, descriptors);
    if (descriptors.cols() != queryDescriptors.cols())
        CV_Error_(Error::StsUnmatchedSizes, ("%s must have %d bytes a row, as %s, got %d", name,
                                             queryDescriptors.cols(), queryName, descriptors.cols()));
}

void checkMatchInput(InputArray queryDescriptors, InputArray trainDescriptors, int normType)
{
    checkHammingNorm(normType);
    checkDescriptors("queryDescriptors", queryDescriptors);
    checkDescriptors("trainDescriptors", trainDescriptors);
    if (!queryDescriptors.empty() && !trainDescriptors.empty())
        checkTrainDescriptors("trainDescriptors", trainDescriptors, "queryDescriptors", queryDescriptors);
}

}  // namespace aqorb
}  // namespace cv
