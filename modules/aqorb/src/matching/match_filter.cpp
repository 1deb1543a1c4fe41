// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "matching/match_filter.hpp"

namespace cv
{
namespace aqorb
{

// Ratio test: whether the nearest descriptor of a list is clearly nearer than the second.
static bool passesRatio(const DistanceKey* list, double ratio)
{
    return list[1] == NO_KEY || distanceOf(list[0]) < ratio * distanceOf(list[1]);
}

MatchFilter::MatchFilter(double ratio_, bool crossCheck_, int maxDistance_)
    : ratio(ratio_), crossCheck(crossCheck_), maxDistance(maxDistance_)
{
    if (!(ratio >= 0 && ratio <= DBL_MAX))
        CV_Error_(Error::StsOutOfRange, ("ratio must be finite and at least 0, got %.17g", ratio));
    if (maxDistance < -1)
        CV_Error_(Error::StsOutOfRange, ("maxDistance must be at least -1, got %d", maxDistance));
}

bool MatchFilter::passes(int query, const DistanceKey* queryList, const Keys& trainLists) const
{
    if (queryList[0] == NO_KEY || (maxDistance >= 0 && distanceOf(queryList[0]) > maxDistance) ||
        (ratio > 0 && !passesRatio(queryList, ratio)))
        return false;
    if (!crossCheck)
        return true;
    const DistanceKey* const trainList = &trainLists[size_t(indexOf(queryList[0])) * kept()];
    return indexOf(trainList[0]) == query && (ratio == 0 || passesRatio(trainList, ratio));
}

void checkCount(const char* name, size_t count, const char* descriptors, int rows)
{
    if (count != size_t(rows))
        CV_Error_(Error::StsUnmatchedSizes, ("%s must have %d elements, one for each row of %s, got %d", name,
                                             rows, descriptors, int(count)));
}

// Throws unless an output can hold a CV_32SC1 matrix of this size. An empty size stands for an empty matrix.
static void checkOutput(const char* name, OutputArray output, const Size& size)
{
    const _InputArray::KindFlag kind = output.kind();
    const bool isMatrix = kind == _InputArray::MAT || kind == _InputArray::UMAT || kind == _InputArray::MATX,
               isVector = kind == _InputArray::STD_VECTOR && (size.width == 1 || size.height == 1);
    const bool isOneChannel = !(output.fixedType() && CV_MAT_CN(output.type()) != 1);
    const bool fits = size.empty() ? isOneChannel && !output.fixedSize()
                                   : isOneChannel && (isMatrix || isVector) &&
                                         !(output.fixedSize() && output.size() != size);
    if (!fits)
        CV_Error_(Error::StsBadArg,
                  ("%s must be an output for %d x %d numbers in one channel, got another kind, size or type",
                   name, size.height, size.width));
}

void writeBoth(const Mat& first, const char* firstName, OutputArray firstOutput, const Mat& distances,
               OutputArray distancesOutput)
{
    checkOutput(firstName, firstOutput, first.size());
    checkOutput("distances", distancesOutput, distances.size());
    first.copyTo(firstOutput);
    distances.copyTo(distancesOutput);
}

void writeMatches(const Keys& queryLists, const Keys& trainLists, const MatchFilter& filter, const char* name,
                  OutputArray pairs, OutputArray distances)
{
    std::vector<Vec2i> found;
    std::vector<int> lengths;
    const int queries = int(queryLists.size() / filter.kept());
    for (int i = 0; i < queries; i++)
    {
        const DistanceKey* const queryList = &queryLists[size_t(i) * filter.kept()];
        if (!filter.passes(i, queryList, trainLists))
            continue;
        found.push_back(Vec2i(i, indexOf(queryList[0])));
        lengths.push_back(distanceOf(queryList[0]));
    }
    const int count = int(found.size());
    if (count == 0)
        writeBoth(Mat(), name, pairs, Mat(), distances);
    else  // no Mat(vector): with OpenCV 5 it has one row
        writeBoth(Mat(count, 2, CV_32SC1, found.data()), name, pairs, Mat(count, 1, CV_32SC1, lengths.data()),
                  distances);
}

}  // namespace aqorb
}  // namespace cv
