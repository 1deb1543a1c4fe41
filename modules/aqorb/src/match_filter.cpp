// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "match_filter.hpp"

namespace cv
{
namespace aqorb
{

MatchFilter::MatchFilter(double ratio_, bool crossCheck_, int maxDistance_)
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
                  const MatchFilter& filter, OutputArray pairs, OutputArray distances)
{
    const int kept = filter.kept();
    std::vector<Vec2i> found;
    std::vector<int> lengths;
    for (size_t i = 0; i < nearest.size() / kept; i++)
    {
        const DistanceKey* const trains = &nearest[i * kept];
        if (trains[0] == NO_KEY || (filter.maxDistance >= 0 && distanceOf(trains[0]) > filter.maxDistance) ||
            (filter.ratio > 0 && !passesRatio(trains, filter.ratio)))
            continue;
        if (filter.crossCheck)
        {
            const DistanceKey* const queries = &nearestQueries[size_t(indexOf(trains[0])) * kept];
            if (indexOf(queries[0]) != int(i) || (filter.ratio > 0 && !passesRatio(queries, filter.ratio)))
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

}  // namespace aqorb
}  // namespace cv
