// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The functions that match two sets of descriptors and return arrays.

#include "precomp.hpp"

#include "hamming.hpp"
#include "simd_compat.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

namespace
{

typedef std::vector<DistanceKey> Keys;

//! Whether the nearest descriptor of a list is clearly nearer than the second one.
bool passesRatio(const DistanceKey* list, double ratio)
{
    return list[1] == NO_KEY || distanceOf(list[0]) < ratio * distanceOf(list[1]);
}

//! The tests that a match must pass, as documented at matchArrays.
struct MatchFilter
{
    MatchFilter(double ratio_, bool crossCheck_, int maxDistance_)
        : ratio(ratio_), crossCheck(crossCheck_), maxDistance(maxDistance_)
    {
        if (!(ratio >= 0 && ratio <= DBL_MAX))
            CV_Error_(Error::StsOutOfRange, ("ratio must be finite and at least 0, got %.17g", ratio));
        if (maxDistance < -1)
            CV_Error_(Error::StsOutOfRange, ("maxDistance must be at least -1, got %d", maxDistance));
    }

    //! How many nearest descriptors the tests need.
    int kept() const { return ratio > 0 ? 2 : 1; }

    //! Tests the nearest train of a query.
    //! @param ofTrains the lists of all trains
    bool passes(int query, const DistanceKey* ofQuery, const Keys& ofTrains) const
    {
        if (ofQuery[0] == NO_KEY || (maxDistance >= 0 && distanceOf(ofQuery[0]) > maxDistance) ||
            (ratio > 0 && !passesRatio(ofQuery, ratio)))
            return false;
        if (!crossCheck)
            return true;
        const DistanceKey* const ofTrain = &ofTrains[size_t(indexOf(ofQuery[0])) * kept()];
        return indexOf(ofTrain[0]) == query && (ratio == 0 || passesRatio(ofTrain, ratio));
    }

    const double ratio;
    const bool crossCheck;
    const int maxDistance;
};

//! Writes the matches that pass the tests.
//! @param ofQueries, ofTrains lists of filter.kept() keys; those of the trains are used for crossCheck only
void writeMatches(const Keys& ofQueries, const Keys& ofTrains, const MatchFilter& filter, OutputArray pairs,
                  OutputArray distances)
{
    std::vector<Vec2i> found;
    std::vector<int> lengths;
    const int queries = int(ofQueries.size() / filter.kept());
    for (int i = 0; i < queries; i++)
    {
        const DistanceKey* const ofQuery = &ofQueries[size_t(i) * filter.kept()];
        if (!filter.passes(i, ofQuery, ofTrains))
            continue;
        found.push_back(Vec2i(i, indexOf(ofQuery[0])));
        lengths.push_back(distanceOf(ofQuery[0]));
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

bool isFinite(const Point2f& p)
{
    return std::isfinite(p.x) && std::isfinite(p.y);
}

//! A train keypoint with its index.
struct Train
{
    Point2f pt;
    int index;
};

//! The keypoints whose position is finite, from the top of the image to the bottom.
std::vector<Train> sortedByRow(const std::vector<KeyPoint>& keypoints)
{
    std::vector<Train> trains;
    for (size_t i = 0; i < keypoints.size(); i++)
        if (isFinite(keypoints[i].pt))
            trains.push_back({keypoints[i].pt, int(i)});
    std::sort(trains.begin(), trains.end(), [](const Train& a, const Train& b) { return a.pt.y < b.pt.y; });
    return trains;
}

//! Finds the trains of a window.
void findAround(const Point2f& center, const Size2f& reach, const std::vector<Train>& trains,
                std::vector<int>& found)
{
    const auto begin = std::partition_point(trains.begin(), trains.end(),
                                            [&](const Train& train)
                                            { return double(train.pt.y) - center.y < -reach.height; });
    const auto end = std::partition_point(begin, trains.end(),
                                          [&](const Train& train)
                                          { return double(train.pt.y) - center.y <= reach.height; });
    found.resize(size_t(end - begin));
    size_t count = 0;
    for (auto train = begin; train != end; ++train)
    {
        // Without a branch, which the CPU would often predict wrongly.
        found[count] = train->index;
        count += std::abs(double(train->pt.x) - center.x) <= reach.width;
    }
    found.resize(count);
}

//! The distance of two descriptors. To call cv::hal::normHamming takes longer than to count the bits of so few.
int distanceBetween(const uchar* a, const uchar* b, int bytes, bool countPairs)
{
    int distance = 0;
    for (int i = 0; i < bytes; i += 8)
    {
        uint64 words[2] = {0, 0};
        for (int j = 0; j < 2; j++)
            std::memcpy(&words[j], (j ? b : a) + i, bytes - i < 8 ? size_t(bytes - i) : 8);
        const uint64 bits = words[0] ^ words[1];
        distance += bitCount(countPairs ? (bits | bits >> 1) & 0x5555555555555555u : bits);
    }
    return distance;
}

void checkCount(const char* name, size_t count, const char* descriptors, int rows)
{
    if (count != size_t(rows))
        CV_Error_(Error::StsUnmatchedSizes, ("%s must have %d elements, one for each row of %s, got %d", name,
                                             rows, descriptors, int(count)));
}

//! The train descriptors, which must be as wide as the queries unless one of both has none.
Mat trainsFor(const Mat& query, InputArray trainDescriptors)
{
    return descriptorsOf("trainDescriptors", trainDescriptors, query.cols);
}

}  // namespace

void matchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray pairs,
                 OutputArray distances, double ratio, bool crossCheck, int maxDistance, int normType)
try
{
    CV_TRACE_FUNCTION();
    checkHammingNorm(normType);
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors),
              train = trainsFor(query, trainDescriptors);
    const MatchFilter filter(ratio, crossCheck, maxDistance);
    Keys ofQueries(size_t(query.rows) * filter.kept(), NO_KEY),
        ofTrains(crossCheck ? size_t(train.rows) * filter.kept() : 0, NO_KEY);
    nearestDescriptors(query, train, Mat(), normType == NORM_HAMMING2, 0, filter.kept(), ofQueries.data(),
                       crossCheck ? ofTrains.data() : 0);
    writeMatches(ofQueries, ofTrains, filter, pairs, distances);
}
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

void knnMatchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray indices,
                    OutputArray distances, int k, int normType)
try
{
    CV_TRACE_FUNCTION();
    checkHammingNorm(normType);
    if (k <= 0)
        CV_Error_(Error::StsOutOfRange, ("k must be above 0, got %d", k));
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors),
              train = trainsFor(query, trainDescriptors);
    const int kept = std::min(k, train.rows);
    Keys nearest(size_t(query.rows) * kept, NO_KEY);
    nearestDescriptors(query, train, Mat(), normType == NORM_HAMMING2, 0, kept, nearest.data(), 0);
    Mat found(query.rows, k, CV_32SC1, Scalar(-1)), lengths(query.rows, k, CV_32SC1, Scalar(-1));
    for (int i = 0; i < query.rows; i++)
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
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

void matchByPosition(InputArray queryDescriptors, const std::vector<Point2f>& predicted,
                     InputArray trainDescriptors, const std::vector<KeyPoint>& trainKeypoints, Size2f reach,
                     OutputArray pairs, OutputArray distances, double ratio, bool crossCheck, int maxDistance,
                     int normType)
try
{
    CV_TRACE_FUNCTION();
    checkHammingNorm(normType);
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors),
              train = trainsFor(query, trainDescriptors);
    checkCount("predicted", predicted.size(), "queryDescriptors", queryDescriptors.rows());
    checkCount("trainKeypoints", trainKeypoints.size(), "trainDescriptors", trainDescriptors.rows());
    if (!(reach.width >= 0 && reach.height >= 0))
        CV_Error_(Error::StsOutOfRange,
                  ("reach must be at least 0 in both directions, got %g x %g", reach.width, reach.height));
    const MatchFilter filter(ratio, crossCheck, maxDistance);

    const int kept = filter.kept();
    Keys ofQueries(size_t(query.rows) * kept, NO_KEY), ofTrains(size_t(train.rows) * kept, NO_KEY);
    const std::vector<Train> trains = train.empty() ? std::vector<Train>() : sortedByRow(trainKeypoints);
    std::vector<int> found;
    for (int i = 0; i < query.rows; i++)
    {
        if (!isFinite(predicted[i]))
            continue;
        findAround(predicted[i], reach, trains, found);
        for (const int j : found)
        {
            const int distance =
                distanceBetween(query.ptr(i), train.ptr(j), query.cols, normType == NORM_HAMMING2);
            insertKey(&ofQueries[size_t(i) * kept], kept, distanceKey(distance, j));
            insertKey(&ofTrains[size_t(j) * kept], kept, distanceKey(distance, i));
        }
    }
    writeMatches(ofQueries, ofTrains, filter, pairs, distances);
}
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

}  // namespace aqorb
}  // namespace cv
