// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "hamming_search.hpp"
#include "match_input.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

namespace
{

//! Inserts distances into lists that may hold anything, in the way of cv::batchDistance.
void insertDistances(const int* distances, const uchar* allowed, int count, int firstIndex, int kept,
                     int* least, int* indices)
{
    for (int i = 0; i < count; i++)
    {
        const int distance = distances[i];
        if (distance >= least[kept - 1] || (allowed && !allowed[i]))
            continue;
        int k = kept - 1;
        for (; k > 0 && least[k - 1] > distance; k--)
        {
            least[k] = least[k - 1];
            indices[k] = indices[k - 1];
        }
        least[k] = distance;
        indices[k] = firstIndex + i;
    }
}

void writeLists(const std::vector<DistanceKey>& nearest, Mat& dist, Mat& nidx)
{
    for (int i = 0; i < dist.rows; i++)
    {
        const DistanceKey* const list = &nearest[size_t(i) * dist.cols];
        for (int k = 0; k < dist.cols; k++)
        {
            dist.at<int>(i, k) = list[k] == NO_KEY ? INT_MAX : distanceOf(list[k]);
            nidx.at<int>(i, k) = indexOf(list[k]);
        }
    }
}

// As cv::batchDistance does it: the distance is that of the nearest row of src2 of which the row of src1 is the nearest,
// also where the index says that the two do not match.
void writeCrossChecked(const std::vector<DistanceKey>& nearest,
                       const std::vector<DistanceKey>& nearestQueries, Mat& dist, Mat& nidx)
{
    dist.setTo(INT_MAX);
    nidx.setTo(-1);
    for (size_t i = 0; i < nearestQueries.size(); i++)
    {
        int& least = dist.at<int>(indexOf(nearestQueries[i]), 0);
        least = std::min(least, distanceOf(nearestQueries[i]));
    }
    for (int i = 0; i < dist.rows; i++)
        if (indexOf(nearestQueries[indexOf(nearest[i])]) == i)
            nidx.at<int>(i, 0) = indexOf(nearest[i]);
}

}  // namespace

void batchHammingDistance(InputArray src1, InputArray src2, OutputArray dist_, OutputArray nidx_,
                          int normType, int K, InputArray mask_, int update, bool crosscheck)
{
    CV_TRACE_FUNCTION();
    checkHammingNorm(normType);
    checkDescriptors("src1", src1);
    checkTrainDescriptors("src2", src2, "src1", src1);
    const Mat query = src1.getMat(), train = src2.getMat(), mask = mask_.getMat();
    if (query.empty() || train.empty())
        CV_Error_(Error::StsBadArg, ("src1 and src2 must not be empty, got %d and %d rows of %d bytes",
                                     query.rows, train.rows, query.cols));
    if (K < 0 || nidx_.needed() != (K > 0))
        CV_Error_(Error::StsBadArg, ("K must be 0 without nidx and above 0 with it, got %d %s it", K,
                                     nidx_.needed() ? "with" : "without"));
    if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != Size(train.rows, query.rows)))
        CV_Error_(Error::StsBadArg,
                  ("mask must be %d x %d of type CV_8UC1, got %d x %d of type %s", train.rows, query.rows,
                   mask.cols, mask.rows, typeToString(mask.type()).c_str()));
    K = std::min(K, train.rows);
    if (crosscheck && (K != 1 || update != 0 || !mask.empty()))
        CV_Error_(Error::StsBadArg,
                  ("with crosscheck K must be 1, update 0 and the mask empty, got K = %d, update = %d and %s",
                   K, update, mask.empty() ? "no mask" : "a mask"));

    const bool countPairs = normType == NORM_HAMMING2;
    dist_.create(query.rows, K > 0 ? K : train.rows, CV_32SC1);
    Mat dist = dist_.getMat(), nidx;
    if (K > 0)
    {
        nidx_.create(dist.size(), CV_32SC1);
        nidx = nidx_.getMat();
    }
    if (K == 0 || update != 0)
    {
        allDistances(query, train, countPairs,
                     [&](int i, int first, const int* distances, int count)
                     {
                         const uchar* const allowed = mask.empty() ? 0 : mask.ptr(i) + first;
                         if (K > 0)
                             insertDistances(distances, allowed, count, first + update, K, dist.ptr<int>(i),
                                             nidx.ptr<int>(i));
                         for (int j = 0; K == 0 && j < count; j++)
                             dist.at<int>(i, first + j) = !allowed || allowed[j] ? distances[j] : INT_MAX;
                     });
        return;
    }
    std::vector<DistanceKey> nearest(size_t(query.rows) * K, NO_KEY),
        nearestQueries(crosscheck ? size_t(train.rows) : 0, NO_KEY);
    nearestDescriptors(query, train, mask, countPairs, 0, K, nearest.data(),
                       crosscheck ? nearestQueries.data() : 0);
    if (crosscheck)
        writeCrossChecked(nearest, nearestQueries, dist, nidx);
    else
        writeLists(nearest, dist, nidx);
}

}  // namespace aqorb
}  // namespace cv
