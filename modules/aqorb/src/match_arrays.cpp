// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "hamming_search.hpp"
#include "match_filter.hpp"
#include "match_input.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

void matchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray pairs,
                 OutputArray distances, double ratio, bool crossCheck, int maxDistance, int normType)
{
    CV_TRACE_FUNCTION();
    checkMatchInput(queryDescriptors, trainDescriptors, normType);
    const MatchFilter filter(ratio, crossCheck, maxDistance);
    const Mat query = queryDescriptors.getMat(), train = trainDescriptors.getMat();
    std::vector<DistanceKey> nearest, nearestQueries;
    if (!query.empty() && !train.empty())
    {
        nearest.resize(size_t(query.rows) * filter.kept(), NO_KEY);
        nearestQueries.resize(crossCheck ? size_t(train.rows) * filter.kept() : 0, NO_KEY);
        nearestDescriptors(query, train, Mat(), normType == NORM_HAMMING2, 0, filter.kept(), nearest.data(),
                           crossCheck ? nearestQueries.data() : 0);
    }
    writeMatches(nearest, nearestQueries, filter, pairs, distances);
}

void knnMatchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray indices,
                    OutputArray distances, int k, int normType)
{
    CV_TRACE_FUNCTION();
    checkMatchInput(queryDescriptors, trainDescriptors, normType);
    if (k <= 0)
        CV_Error_(Error::StsOutOfRange, ("k must be above 0, got %d", k));
    const Mat query = queryDescriptors.getMat(), train = trainDescriptors.getMat();
    const int rows = query.rows, kept = std::min(k, query.empty() ? 0 : train.rows);
    std::vector<DistanceKey> nearest(size_t(rows) * kept, NO_KEY);
    if (kept > 0)
        nearestDescriptors(query, train, Mat(), normType == NORM_HAMMING2, 0, kept, nearest.data(), 0);
    Mat found(rows, k, CV_32SC1, Scalar(-1)), lengths(rows, k, CV_32SC1, Scalar(-1));
    for (int i = 0; i < rows; i++)
    {
        for (int j = 0; j < kept; j++)
        {
            found.at<int>(i, j) = indexOf(nearest[size_t(i) * kept + j]);
            lengths.at<int>(i, j) = distanceOf(nearest[size_t(i) * kept + j]);
        }
    }
    found.copyTo(indices);
    lengths.copyTo(distances);
}

}  // namespace aqorb
}  // namespace cv
