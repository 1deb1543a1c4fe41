// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "hamming_search.hpp"
#include "match_input.hpp"
#include "match_tests.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

using namespace stages;

MatchTests::MatchTests(double ratio_, bool crossCheck_, int maxDistance_)
    : ratio(ratio_), crossCheck(crossCheck_), maxDistance(maxDistance_)
{
    if (!(ratio >= 0 && ratio <= DBL_MAX))
        CV_Error_(Error::StsOutOfRange, ("ratio must be finite and at least 0, got %.17g", ratio));
    if (maxDistance < -1)
        CV_Error_(Error::StsOutOfRange, ("maxDistance must be at least -1, got %d", maxDistance));
}

// Whether the nearest descriptor of a list is so by far.
static bool passesRatio(const DistanceKey* list, double ratio)
{
    return list[1] == NO_KEY || distanceOf(list[0]) < ratio * distanceOf(list[1]);
}

void writeMatches(const std::vector<DistanceKey>& nearest, const std::vector<DistanceKey>& nearestQueries,
                  const MatchTests& tests, OutputArray pairs, OutputArray distances)
{
    const int kept = tests.kept();
    std::vector<Vec2i> found;
    std::vector<int> lengths;
    for (size_t i = 0; i < nearest.size() / kept; i++)
    {
        const DistanceKey* const trains = &nearest[i * kept];
        if (trains[0] == NO_KEY || (tests.maxDistance >= 0 && distanceOf(trains[0]) > tests.maxDistance) ||
            (tests.ratio > 0 && !passesRatio(trains, tests.ratio)))
            continue;
        if (tests.crossCheck)
        {
            const DistanceKey* const queries = &nearestQueries[size_t(indexOf(trains[0])) * kept];
            if (indexOf(queries[0]) != int(i) || (tests.ratio > 0 && !passesRatio(queries, tests.ratio)))
                continue;
        }
        found.push_back(Vec2i(int(i), indexOf(trains[0])));
        lengths.push_back(distanceOf(trains[0]));
    }
    if (found.empty())
    {
        pairs.release();
        distances.release();
        return;
    }
    Mat(int(found.size()), 2, CV_32SC1, found.data()).copyTo(pairs);
    Mat(int(lengths.size()), 1, CV_32SC1, lengths.data()).copyTo(distances);
}

void matchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray pairs,
                 OutputArray distances, double ratio, bool crossCheck, int maxDistance, int normType)
{
    CV_TRACE_FUNCTION();
    checkMatchInput(queryDescriptors, trainDescriptors, normType);
    const MatchTests tests(ratio, crossCheck, maxDistance);
    const Mat query = queryDescriptors.getMat(), train = trainDescriptors.getMat();
    std::vector<DistanceKey> nearest, nearestQueries;
    if (!query.empty() && !train.empty())
    {
        nearest.resize(size_t(query.rows) * tests.kept(), NO_KEY);
        nearestQueries.resize(crossCheck ? size_t(train.rows) * tests.kept() : 0, NO_KEY);
        nearestDescriptors(query, train, Mat(), normType == NORM_HAMMING2, 0, tests.kept(), nearest.data(),
                           crossCheck ? nearestQueries.data() : 0);
    }
    writeMatches(nearest, nearestQueries, tests, pairs, distances);
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
