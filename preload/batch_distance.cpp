// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// cv::batchDistance for unchanged programs: cv::BFMatcher does all its work by this function.

#include "preload.hpp"

#include "matching/hamming.hpp"

#include <cstdio>
#include <mutex>

namespace
{

using namespace cv;
using namespace cv::aqorb;
using aqorb_preload::isVariableOn;

// Whether the arguments form a valid call with a Hamming norm. OpenCV handles all other calls, with its own messages.
bool isHammingCall(const cv::Mat& src1, const cv::Mat& src2, int dtype, bool hasIndices, int normType, int K,
                   const cv::Mat& mask, int update, bool crosscheck)
{
    return (normType == cv::NORM_HAMMING || normType == cv::NORM_HAMMING2) &&
           (dtype == -1 || dtype == CV_32S) && src1.dims == 2 && src2.dims == 2 && !src1.empty() &&
           !src2.empty() && src1.type() == CV_8UC1 && src2.type() == CV_8UC1 && src1.cols == src2.cols &&
           K >= 0 && hasIndices == (K > 0) &&
           (mask.empty() || (mask.type() == CV_8UC1 && mask.size() == cv::Size(src2.rows, src1.rows))) &&
           (!crosscheck || (std::min(K, src2.rows) == 1 && update == 0 && mask.empty()));
}

//! Inserts distances into lists of any content, as cv::batchDistance does.
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

// Writes the result of a cross check, as cv::batchDistance does. The distance of a row of src1 is its least distance to
// the rows of src2 whose nearest row it is, even if the index is -1 because the two are not mutually nearest.
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

// cv::batchDistance for a valid call with a Hamming norm.
void batchHammingDistance(const Mat& query, const Mat& train, OutputArray dist_, OutputArray nidx_,
                          bool countPairs, int K, const Mat& mask, int update, bool crosscheck)
{
    K = std::min(K, train.rows);
    const Size size(K > 0 ? K : train.rows, query.rows);
    // The lists of an earlier call count only if their matrices are still there.
    const bool isAdded = update != 0 && dist_.sameSize(nidx_) && dist_.size() == size &&
                         dist_.type() == CV_32SC1 && nidx_.type() == CV_32SC1;
    dist_.create(size, CV_32SC1);
    Mat dist = dist_.getMat(), nidx;
    if (K > 0)
    {
        nidx_.create(size, CV_32SC1);
        nidx = nidx_.getMat();
    }
    if (update != 0 && !isAdded)
    {
        dist.setTo(INT_MAX);
        nidx.setTo(-1);
    }
    const auto addDistances = [&](int i, int first, const int* distances, int count)
    {
        const uchar* const allowed = mask.empty() ? 0 : mask.ptr(i) + first;
        if (K > 0)
            insertDistances(distances, allowed, count, first + update, K, dist.ptr<int>(i), nidx.ptr<int>(i));
        for (int j = 0; K == 0 && j < count; j++)
            dist.at<int>(i, first + j) = !allowed || allowed[j] ? distances[j] : INT_MAX;
    };
    if (K == 0 || update != 0)
        return allDistances(query, train, countPairs, addDistances);
    std::vector<DistanceKey> nearest(size_t(query.rows) * K, NO_KEY),
        nearestQueries(crosscheck ? size_t(train.rows) : 0, NO_KEY);
    nearestDescriptors(query, train, mask, countPairs, 0, K, nearest.data(),
                       crosscheck ? nearestQueries.data() : 0);
    if (crosscheck)
        return writeCrossChecked(nearest, nearestQueries, dist, nidx);
    for (int i = 0; i < query.rows; i++)
        for (int k = 0; k < K; k++)
        {
            const DistanceKey key = nearest[size_t(i) * K + k];
            dist.at<int>(i, k) = key == NO_KEY ? INT_MAX : distanceOf(key);
            nidx.at<int>(i, k) = indexOf(key);
        }
}

}  // namespace

namespace cv
{

void batchDistance(InputArray src1, InputArray src2, OutputArray dist, int dtype, OutputArray nidx,
                   int normType, int K, InputArray mask, int update, bool crosscheck)
{
    if (isVariableOn("AQORB_DISABLE") || isVariableOn("AQORB_DISABLE_MATCHER") ||
        !isHammingCall(src1.getMat(), src2.getMat(), dtype, nidx.needed(), normType, K, mask.getMat(), update,
                       crosscheck))
    {
        static const auto original = aqorb_preload::originalOf(&cv::batchDistance, "cv::batchDistance");
        return original(src1, src2, dist, dtype, nidx, normType, K, mask, update, crosscheck);
    }
    static std::once_flag once;
    if (isVariableOn("AQORB_VERBOSE"))
        std::call_once(
            once, [] { std::fprintf(stderr, "aqorb: cv::batchDistance gives aqorb's Hamming distances\n"); });
    batchHammingDistance(src1.getMat(), src2.getMat(), dist, nidx, normType == NORM_HAMMING2, K,
                         mask.getMat(), update, crosscheck);
}

}  // namespace cv
