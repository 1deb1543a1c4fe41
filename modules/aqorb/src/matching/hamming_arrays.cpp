// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Functions that match two sets of descriptors and return arrays.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "matching/match_filter.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

namespace
{

//! Indices of the finite positions, from the top of the image to the bottom.
std::vector<int> sortedByRow(const std::vector<Point2f>& positions)
{
    std::vector<int> order;
    for (size_t i = 0; i < positions.size(); i++)
        if (std::isfinite(positions[i].x) && std::isfinite(positions[i].y))
            order.push_back(int(i));
    std::sort(order.begin(), order.end(),
              [&](int a, int b)
              { return positions[a].y != positions[b].y ? positions[a].y < positions[b].y : a < b; });
    return order;
}

//! Least float that is not below center - reach. The difference of two floats may need more bits than a double has.
float roundedUp(double center, double reach)
{
    const double difference = center - reach, subtracted = center - difference;
    const double error = center - (difference + subtracted) + (subtracted - reach);  // Knuth's TwoSum; exact
    const float nearest = float(difference);
    return nearest < difference || (nearest == difference && error > 0)
               ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
               : nearest;
}

//! Window around a centre: positions at most `reach` away, in x and in y.
struct Window
{
    Window(const Point2f& center, const Size2f& reach)
        : left(roundedUp(center.x, reach.width)),
          right(-roundedUp(-center.x, reach.width)),
          top(roundedUp(center.y, reach.height)),
          bottom(-roundedUp(-center.y, reach.height))
    {
    }
    Window& operator&=(const Window& other)
    {
        left = std::max(left, other.left);
        right = std::min(right, other.right);
        top = std::max(top, other.top);
        bottom = std::min(bottom, other.bottom);
        return *this;
    }

    float left, right, top, bottom;
};

//! Descriptors and positions of some indices, in ascending order, so that ties go to the lower index.
struct Subset
{
    Subset(std::vector<int>::const_iterator begin, std::vector<int>::const_iterator end, const Mat& all,
           const std::vector<Point2f>& positions)
        : indices(begin, end), descriptors(int(end - begin), all.cols, CV_8UC1)
    {
        std::sort(indices.begin(), indices.end());
        for (size_t i = 0; i < indices.size(); i++)
        {
            std::memcpy(descriptors.ptr(int(i)), all.ptr(indices[i]), size_t(all.cols));
            x.push_back(positions[indices[i]].x);
            y.push_back(positions[indices[i]].y);
        }
    }

    std::vector<int> indices;
    Mat descriptors;
    std::vector<float> x, y;
};

//! Tests which positions lie in a window, in a loop that compilers vectorize. Returns whether all do.
bool testWindow(const float* x, const float* y, int count, const Window window, uchar* isWithin)
{
    uchar all = 1;
    const float left = window.left, right = window.right, top = window.top, bottom = window.bottom;
    for (int i = 0; i < count; i++)
    {
        isWithin[i] = uchar((x[i] >= left) & (x[i] <= right) & (y[i] >= top) & (y[i] <= bottom));
        all &= isWithin[i];
    }
    return all != 0;
}

//! Mask for nearestDescriptors: trains within the windows of the queries. Empty if all pairs are allowed.
Mat maskOf(const Subset& queries, const Subset& trains, const Size2f& reach)
{
    std::vector<Window> windows;
    for (size_t i = 0; i < queries.indices.size(); i++)
        windows.push_back(Window(Point2f(queries.x[i], queries.y[i]), reach));
    Mat mask(int(windows.size()), trains.descriptors.rows, CV_8UC1);
    Window common = windows[0];
    for (const Window& window : windows)
        common &= window;
    if (testWindow(trains.x.data(), trains.y.data(), mask.cols, common, mask.ptr()))
        return Mat();
    for (int i = 0; i < mask.rows; i++)
        testWindow(trains.x.data(), trains.y.data(), mask.cols, windows[i], mask.ptr(i));
    return mask;
}

//! Inserts the keys of a subset into the lists of all descriptors. The keys have indices into `neighbours`.
void addKeys(const Keys& keys, int kept, const Subset& subset, const Subset& neighbours, Keys& lists)
{
    for (size_t i = 0; i < keys.size(); i++)
        if (keys[i] != NO_KEY)
            insertKey(&lists[size_t(subset.indices[i / kept]) * kept], kept,
                      distanceKey(distanceOf(keys[i]), neighbours.indices[indexOf(keys[i])]));
}

//! Fundamental matrix, scaled by a power of two so that products with positions stay finite.
Matx33d checkedFundamental(InputArray F)
{
    const bool isMatrix = !F.isMatVector() && !F.isUMatVector() && F.dims() <= 2 && F.size() == Size(3, 3) &&
                          (F.type() == CV_32FC1 || F.type() == CV_64FC1);
    if (!isMatrix)
        CV_Error_(Error::StsBadArg,
                  ("F must be a 3 x 3 matrix of type CV_32FC1 or CV_64FC1, got %d elements of type %s",
                   int(F.total()), typeToString(F.type()).c_str()));
    Matx33d matrix;
    F.getMat().convertTo(matrix, CV_64F);
    double largest = 0;
    for (const double element : matrix.val)
        largest = std::isfinite(element) ? std::max(largest, std::abs(element)) : std::abs(element);
    if (!(largest > 0 && largest <= DBL_MAX))
        CV_Error_(Error::StsBadArg, ("F must be finite and not zero, got elements up to %g", largest));
    int exponent;
    std::frexp(largest, &exponent);
    for (double& element : matrix.val)
        element = std::ldexp(element, -exponent);
    return matrix;
}

//! Positions of train keypoints, and how far each may lie from an epipolar line.
struct GuidedTrains
{
    GuidedTrains(const std::vector<KeyPoint>& keypoints, double reach)
    {
        const double ORB_SIZE = 31;
        for (const KeyPoint& keypoint : keypoints)
        {
            const bool isFinite =
                std::isfinite(keypoint.pt.x) && std::isfinite(keypoint.pt.y) && std::isfinite(keypoint.size);
            x.push_back(keypoint.pt.x);
            y.push_back(keypoint.pt.y);
            reaches.push_back(isFinite ? reach * std::max(1., keypoint.size / ORB_SIZE) : -1);
        }
    }

    //! Tests which trains lie near a line, in a loop that compilers vectorize. None does without a line.
    void testBand(const Vec3d& line, uchar* isWithin) const
    {
        const double a = line[0], b = line[1], c = line[2], length = std::hypot(a, b);
        const size_t count = length > 0 && length <= DBL_MAX ? x.size() : 0;
        for (size_t i = 0; i < count; i++)
            isWithin[i] = uchar(std::abs(a * x[i] + b * y[i] + c) <= reaches[i] * length);
        std::fill(isWithin + count, isWithin + x.size(), uchar(0));
    }

    //! Clears the flags of trains beside a train, which may show the same spot.
    void leaveOutBeside(int train, uchar* isWithin) const
    {
        const double MIN_DISTANCE = 8;
        const double centerX = x[size_t(train)], centerY = y[size_t(train)];
        for (size_t i = 0; i < x.size(); i++)
        {
            const double dx = x[i] - centerX, dy = y[i] - centerY;
            isWithin[i] &= uchar(dx * dx + dy * dy >= MIN_DISTANCE * MIN_DISTANCE);
        }
    }

    std::vector<double> x, y, reaches;
};

}  // namespace

void matchArrays(InputArray queryDescriptors, InputArray trainDescriptors, OutputArray pairs,
                 OutputArray distances, double ratio, bool crossCheck, int maxDistance, int normType)
try
{
    CV_TRACE_FUNCTION();
    checkHammingNorm(normType);
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors),
              train = descriptorsOf("trainDescriptors", trainDescriptors, query.cols);
    const MatchFilter filter(ratio, crossCheck, maxDistance);
    Keys queryLists(size_t(query.rows) * filter.kept(), NO_KEY),
        trainLists(crossCheck ? size_t(train.rows) * filter.kept() : 0, NO_KEY);
    nearestDescriptors(query, train, Mat(), normType == NORM_HAMMING2, 0, filter.kept(), queryLists.data(),
                       crossCheck ? trainLists.data() : 0);
    writeMatches(queryLists, trainLists, filter, "pairs", pairs, distances);
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
    const int MAX_K = INT_MAX / int(sizeof(int));  // cv::Mat counts the bytes of a row as an int
    if (k <= 0 || k > MAX_K)
        CV_Error_(Error::StsOutOfRange, ("k must be from 1 to %d, got %d", MAX_K, k));
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors),
              train = descriptorsOf("trainDescriptors", trainDescriptors, query.cols);
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
    writeBoth(found, "indices", indices, lengths, distances);
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
              train = descriptorsOf("trainDescriptors", trainDescriptors, query.cols);
    checkCount("predicted", predicted.size(), "queryDescriptors", queryDescriptors.rows());
    checkCount("trainKeypoints", trainKeypoints.size(), "trainDescriptors", trainDescriptors.rows());
    if (!(reach.width >= 0 && reach.height >= 0))
        CV_Error_(Error::StsOutOfRange,
                  ("reach must be at least 0 in both directions, got %g x %g", reach.width, reach.height));
    const MatchFilter filter(ratio, crossCheck, maxDistance);

    const int kept = filter.kept();
    Keys queryLists(size_t(query.rows) * kept, NO_KEY),
        trainLists(crossCheck ? size_t(train.rows) * kept : 0, NO_KEY);
    std::vector<Point2f> positions;
    for (int i = 0; i < train.rows; i++)
        positions.push_back(trainKeypoints[i].pt);
    const std::vector<int> queryOrder = sortedByRow(predicted), trainOrder = sortedByRow(positions);
    // Compares queries of about the same row at once with all trains that any of these queries may match.
    const int MIN_ROWS = 64, MAX_ROWS = 512;
    for (auto first = queryOrder.begin(); !query.empty() && !train.empty() && first != queryOrder.end();)
    {
        auto last = first;
        while (last != queryOrder.end() && last - first < MAX_ROWS &&
               (last - first < MIN_ROWS || predicted[*last].y - predicted[*first].y <= reach.height))
            ++last;
        const float top = Window(predicted[*first], reach).top,
                    bottom = Window(predicted[*(last - 1)], reach).bottom;
        const auto begin = std::partition_point(trainOrder.begin(), trainOrder.end(),
                                                [&](int i) { return positions[i].y < top; });
        const auto end =
            std::partition_point(begin, trainOrder.end(), [&](int i) { return positions[i].y <= bottom; });
        const Subset queries(first, last, query, predicted), trains(begin, end, train, positions);
        first = last;
        Keys nearest(queries.indices.size() * kept, NO_KEY),
            nearestQueries(crossCheck ? trains.indices.size() * kept : 0, NO_KEY);
        nearestDescriptors(queries.descriptors, trains.descriptors, maskOf(queries, trains, reach),
                           normType == NORM_HAMMING2, 0, kept, nearest.data(),
                           crossCheck ? nearestQueries.data() : 0);
        addKeys(nearest, kept, queries, trains, queryLists);
        addKeys(nearestQueries, kept, trains, queries, trainLists);
    }
    writeMatches(queryLists, trainLists, filter, "pairs", pairs, distances);
}
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

void matchGuided(InputArray queryDescriptors, const std::vector<KeyPoint>& queryKeypoints,
                 InputArray trainDescriptors, const std::vector<KeyPoint>& trainKeypoints, InputArray F,
                 float reach, OutputArray matches, OutputArray distances, double ratio, int maxDistance,
                 int normType)
try
{
    CV_TRACE_FUNCTION();
    checkHammingNorm(normType);
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors),
              train = descriptorsOf("trainDescriptors", trainDescriptors, query.cols);
    checkCount("queryKeypoints", queryKeypoints.size(), "queryDescriptors", queryDescriptors.rows());
    checkCount("trainKeypoints", trainKeypoints.size(), "trainDescriptors", trainDescriptors.rows());
    const Matx33d fundamental = checkedFundamental(F);
    if (!(reach >= 0))
        CV_Error_(Error::StsOutOfRange, ("reach must be at least 0, got %g", reach));
    // Of 256 bits, and of the 128 pairs of the same bits: of different descriptors 128 and 96 differ.
    const int MAX_BITS = 90, MAX_PAIRS = 67, BITS_EACH = 256;
    const int64 bits = int64(query.cols) * 8;
    const bool countPairs = normType == NORM_HAMMING2;
    const MatchFilter filter(ratio, false,
                             maxDistance != -1 ? maxDistance
                                               : int(bits * (countPairs ? MAX_PAIRS : MAX_BITS) / BITS_EACH));

    const int kept = filter.kept(), MAX_ROWS = 512;  // of a mask
    Keys lists(size_t(query.rows) * kept, NO_KEY);
    const GuidedTrains trains(trainKeypoints, reach);
    for (int first = 0; !train.empty() && first < query.rows; first += MAX_ROWS)
    {
        const Mat queries = query.rowRange(first, std::min(first + MAX_ROWS, query.rows));
        Mat mask(queries.rows, train.rows, CV_8UC1);
        forEach(size_t(queries.rows), stageThreads(),
                [&](size_t i, int)
                {
                    const Point2f& position = queryKeypoints[size_t(first) + i].pt;
                    trains.testBand(fundamental * Vec3d(position.x, position.y, 1), mask.ptr(int(i)));
                });
        // The second nearest is searched for those alone that the ratio test decides.
        for (int k = 0; k < kept; k++)
        {
            Keys nearest(size_t(queries.rows), NO_KEY);
            nearestDescriptors(queries, train, mask, countPairs, 0, 1, nearest.data(), 0);
            for (int i = 0; i < queries.rows; i++)
            {
                lists[size_t(first + i) * kept + k] = nearest[i];
                if (nearest[i] != NO_KEY && distanceOf(nearest[i]) <= filter.maxDistance)
                    trains.leaveOutBeside(indexOf(nearest[i]), mask.ptr(i));
                else
                    mask.row(i).setTo(0);
            }
        }
    }
    writeMatches(lists, Keys(), filter, "matches", matches, distances);
}
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

}  // namespace aqorb
}  // namespace cv
