// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "match_filter.hpp"
#include "match_input.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

namespace
{

bool isFinite(const Point2f& p)
{
    return std::abs(p.x) <= FLT_MAX && std::abs(p.y) <= FLT_MAX;
}

//! Finds the keypoints in windows of an image, which is divided into cells. These have about one keypoint each.
class KeypointWindows
{
public:
    explicit KeypointWindows(const std::vector<KeyPoint>& keypoints)
        : x(FLT_MAX, -FLT_MAX), y(x), columns(1), rows(1)
    {
        size_t count = 0;
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            const Point2f& p = keypoints[i].pt;
            if (!isFinite(p))
                continue;
            x.include(p.x);
            y.include(p.y);
            count++;
        }
        // Of a line of keypoints, too, and of keypoints of which one is far away.
        const double side = std::sqrt(x.length() * y.length() / std::max(count, size_t(1)));
        const int limit = int(std::min(count + 1, size_t(1) << 12));
        columns = x.cells(side, limit);
        rows = y.cells(side, limit);

        std::vector<int> cells(keypoints.size(), -1);
        begins.resize(size_t(columns) * rows + 1, 0);
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            if (!isFinite(keypoints[i].pt))
                continue;
            cells[i] = y.cellOf(keypoints[i].pt.y, rows) * columns + x.cellOf(keypoints[i].pt.x, columns);
            begins[cells[i] + 1]++;
        }
        std::partial_sum(begins.begin(), begins.end(), begins.begin());
        members.resize(count);
        std::vector<int> next(begins.begin(), begins.end() - 1);
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            if (cells[i] >= 0)
                members[next[cells[i]]++] = {keypoints[i].pt, int(i)};
        }
    }

    //! @param found the indices of the keypoints, in any order
    void findAround(const Point2f& center, const Size2f& reach, std::vector<int>& found) const
    {
        found.clear();
        if (members.empty())
            return;
        const int left = x.cellOf(double(center.x) - reach.width, columns),
                  right = x.cellOf(double(center.x) + reach.width, columns),
                  top = y.cellOf(double(center.y) - reach.height, rows),
                  bottom = y.cellOf(double(center.y) + reach.height, rows);
        size_t count = 0;
        for (int row = top; row <= bottom; row++)
        {
            const int begin = begins[row * columns + left], end = begins[row * columns + right + 1];
            found.resize(count + size_t(end - begin));
            for (int i = begin; i < end; i++)
            {
                // Without a branch, which the CPU would often predict wrongly.
                const Point2f& p = members[i].pt;
                found[count] = members[i].index;
                count += int(std::abs(double(p.x) - center.x) <= reach.width) &
                         (std::abs(double(p.y) - center.y) <= reach.height);
            }
        }
        found.resize(count);
    }

private:
    //! The coordinates of the keypoints along an axis.
    struct Axis
    {
        Axis(float first_, float last_) : first(first_), last(last_) {}
        void include(float value)
        {
            first = std::min(first, value);
            last = std::max(last, value);
        }
        double length() const { return std::max(double(last) - first, 0.); }
        int cells(double side, int limit) const
        {
            return side > 0 ? int(std::min(length() / side + 1, double(limit))) : length() > 0 ? limit : 1;
        }
        //! Of a coordinate outside the nearest cell. A greater coordinate never has a lower cell.
        int cellOf(double value, int count) const
        {
            if (!(length() > 0))
                return 0;
            return int(std::min(std::max((value - first) / length() * count, 0.), double(count - 1)));
        }
        float first, last;
    };

    struct Member
    {
        Point2f pt;
        int index;
    };
    Axis x, y;
    int columns, rows;
    std::vector<int> begins;      // of the cells, row by row, in members; and its end
    std::vector<Member> members;  // the keypoints by cell
};

void checkCount(const char* name, size_t count, const char* descriptors, int rows)
{
    if (count != size_t(rows))
        CV_Error_(Error::StsUnmatchedSizes, ("%s must have %d elements, one for each row of %s, got %d", name,
                                             rows, descriptors, int(count)));
}

}  // namespace

void matchByPosition(InputArray queryDescriptors, const std::vector<Point2f>& predicted,
                     InputArray trainDescriptors, const std::vector<KeyPoint>& trainKeypoints, Size2f reach,
                     OutputArray pairs, OutputArray distances, double ratio, bool crossCheck, int maxDistance,
                     int normType)
{
    CV_TRACE_FUNCTION();
    checkMatchInput(queryDescriptors, trainDescriptors, normType);
    const Mat query = queryDescriptors.getMat(), train = trainDescriptors.getMat();
    checkCount("predicted", predicted.size(), "queryDescriptors", query.rows);
    checkCount("trainKeypoints", trainKeypoints.size(), "trainDescriptors", train.rows);
    if (!(reach.width >= 0 && reach.height >= 0))
        CV_Error_(Error::StsOutOfRange,
                  ("reach must be at least 0 in both directions, got %g x %g", reach.width, reach.height));
    const MatchFilter filter(ratio, crossCheck, maxDistance);

    const int kept = filter.kept();
    std::vector<DistanceKey> nearest(size_t(query.rows) * kept, NO_KEY),
        nearestQueries(size_t(train.rows) * kept, NO_KEY);
    const KeypointWindows windows(trainKeypoints);
    const HammingKernels& kernels = hammingKernels(normType == NORM_HAMMING2, query.cols);
    std::vector<int> found, lengths;
    for (int i = 0; i < query.rows; i++)
    {
        if (!isFinite(predicted[i]))
            continue;
        windows.findAround(predicted[i], reach, found);
        lengths.resize(found.size());
        kernels.listedDistances(query.ptr(i), query.cols, train.ptr(), train.step, found.data(),
                                int(found.size()), lengths.data());
        for (size_t j = 0; j < found.size(); j++)
        {
            insertKey(&nearest[size_t(i) * kept], kept, distanceKey(lengths[j], found[j]));
            insertKey(&nearestQueries[size_t(found[j]) * kept], kept, distanceKey(lengths[j], i));
        }
    }
    writeMatches(nearest, nearestQueries, filter, pairs, distances);
}

}  // namespace aqorb
}  // namespace cv
