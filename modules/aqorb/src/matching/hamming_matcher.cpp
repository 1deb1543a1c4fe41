// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Class HammingMatcher: collections of images, masks and lists of matches, as in cv::BFMatcher.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "matching/hamming.hpp"

#include <opencv2/aqorb/matching.hpp>

namespace cv
{
namespace aqorb
{

namespace
{

typedef std::vector<std::vector<DMatch>> MatchLists;

//! Numbers the train descriptors of a collection consecutively.
class CollectionIndex
{
public:
    explicit CollectionIndex(const std::vector<Mat>& images) : firsts(1, 0)
    {
        for (size_t i = 0; i < images.size(); i++)
        {
            if (images[i].rows > INT_MAX - firsts.back())
                CV_Error_(Error::StsOutOfRange,
                          ("trainDescriptors must have at most %d rows in all, got %.17g", INT_MAX,
                           double(firsts.back()) + images[i].rows));
            firsts.push_back(firsts.back() + images[i].rows);
        }
    }
    int first(size_t image) const { return firsts[image]; }
    int total() const { return firsts.back(); }
    DMatch match(int query, DistanceKey key) const
    {
        const int index = indexOf(key);
        if (firsts.size() == 2)
            return DMatch(query, index, 0, float(distanceOf(key)));
        const int image = int(std::upper_bound(firsts.begin(), firsts.end(), index) - firsts.begin()) - 1;
        return DMatch(query, index - firsts[image], image, float(distanceOf(key)));
    }

private:
    std::vector<int> firsts;  // index of each image's first descriptor, and the total
};

//! Mask of each image, empty without masks.
std::vector<Mat> masksOf(InputArrayOfArrays input, int queries, const std::vector<Mat>& images)
{
    std::vector<Mat> masks;
    input.getMatVector(masks);
    if (!masks.empty() && masks.size() != images.size())
        CV_Error_(Error::StsUnmatchedSizes, ("masks must have %d elements, one for each image, got %d",
                                             int(images.size()), int(masks.size())));
    masks.resize(images.size());
    for (size_t i = 0; i < images.size(); i++)
    {
        const Mat& mask = masks[i];
        if (!mask.empty() && !images[i].empty() &&
            (mask.type() != CV_8UC1 || mask.size() != Size(images[i].rows, queries)))
            CV_Error_(Error::StsBadArg,
                      ("the mask of image %d must be %d x %d of type CV_8UC1, got %d x %d of type %s", int(i),
                       images[i].rows, queries, mask.cols, mask.rows, typeToString(mask.type()).c_str()));
    }
    return masks;
}

//! Throws unless k and the collection suit a cross check.
void checkCrossCheck(int k, int kept, const std::vector<Mat>& masks)
{
    const bool isMasked =
        std::any_of(masks.begin(), masks.end(), [](const Mat& mask) { return !mask.empty(); });
    if (kept > 1 || masks.size() > 1 || isMasked)
        CV_Error_(
            Error::StsBadArg,
            ("with crossCheck k must be 1, with one image of train descriptors and no mask, got k = %d, %d "
             "images and %s",
             k, int(masks.size()), isMasked ? "a mask" : "no mask"));
}

//! Calls the function with the train descriptors, the mask and the index of each image. It joins images of few
//! descriptors, because each search has a fixed cost.
template <typename Function>
void forImages(const Mat& query, const std::vector<Mat>& images, const std::vector<Mat>& masks,
               const Function& function)
{
    const int MAX_JOINED = 4096;
    for (size_t first = 0, next; !query.empty() && first < images.size(); first = next)
    {
        int rows = images[first].rows;
        for (next = first + 1; next < images.size() && rows + images[next].rows <= MAX_JOINED; next++)
            rows += images[next].rows;
        if (next == first + 1)
        {
            function(images[first], masks[first], first);
            continue;
        }
        Mat joined(rows, query.cols, CV_8UC1), mask;
        for (size_t i = first, row = 0; i < next; i++)
        {
            if (!masks[i].empty() && !images[i].empty())
            {
                if (mask.empty())
                    mask = Mat(query.rows, rows, CV_8UC1, Scalar(255));
                masks[i].copyTo(mask.colRange(int(row), int(row) + images[i].rows));
            }
            for (int j = 0; j < images[i].rows; j++, row++)
                std::memcpy(joined.ptr(int(row)), images[i].ptr(j), size_t(query.cols));
        }
        function(joined, mask, first);
    }
}

}  // namespace

HammingMatcher::HammingMatcher(int normType_, bool crossCheck_) : BFMatcher(normType_, crossCheck_)
{
    checkHammingNorm(normType_);
}

Ptr<HammingMatcher> HammingMatcher::create(int normType, bool crossCheck)
{
    return makePtr<HammingMatcher>(normType, crossCheck);
}

Ptr<DescriptorMatcher> HammingMatcher::clone(bool emptyTrainData) const
{
    const Ptr<HammingMatcher> copy = create(normType, crossCheck);
    if (!emptyTrainData)
    {
        for (size_t i = 0; i < trainDescCollection.size(); i++)
            copy->trainDescCollection.push_back(trainDescCollection[i].clone());
        for (size_t i = 0; i < utrainDescCollection.size(); i++)
            copy->utrainDescCollection.push_back(utrainDescCollection[i].clone());
    }
    return copy;
}

// UMat descriptors come after Mat descriptors, as in cv::BFMatcher.
std::vector<Mat> HammingMatcher::gatherTrainDescriptors(const Mat& query)
{
    // Threads may share an object whose members do not change. No descriptor counts twice if memory does not suffice.
    if (!utrainDescCollection.empty())
    {
        std::vector<Mat> copies(utrainDescCollection.size());
        for (size_t i = 0; i < copies.size(); i++)
            utrainDescCollection[i].copyTo(copies[i]);
        trainDescCollection.insert(trainDescCollection.end(), copies.begin(), copies.end());
        utrainDescCollection.clear();
    }

    std::vector<Mat> images;
    images.reserve(trainDescCollection.size());
    for (size_t i = 0; i < trainDescCollection.size(); i++)
        images.push_back(descriptorsOf("trainDescriptors", trainDescCollection[i], query.cols, int(i)));
    return images;
}

void HammingMatcher::knnMatchImpl(InputArray queryDescriptors, MatchLists& matches, int k,
                                  InputArrayOfArrays masks_, bool compactResult)
try
{
    CV_TRACE_FUNCTION();
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors);
    const std::vector<Mat> images = gatherTrainDescriptors(query);
    const std::vector<Mat> masks = masksOf(masks_, query.rows, images);
    const CollectionIndex index(images);
    const int kept = std::min(k, index.total());
    if (crossCheck)
        checkCrossCheck(k, kept, masks);

    std::vector<DistanceKey> nearest(size_t(query.rows) * kept, NO_KEY),
        nearestQueries(crossCheck ? index.total() : 0, NO_KEY);
    forImages(query, images, masks,
              [&](const Mat& train, const Mat& mask, size_t first)
              {
                  nearestDescriptors(query, train, mask, normType == NORM_HAMMING2, index.first(first), kept,
                                     nearest.data(), crossCheck ? nearestQueries.data() : 0);
              });

    const size_t before = matches.size();
    matches.resize(before + query.rows);
    const auto writeMatches = [&](int i)
    {
        const DistanceKey* const list = nearest.data() + size_t(i) * kept;
        const int found = int(std::find(list, list + kept, NO_KEY) - list);
        if (found == 0 || (crossCheck && indexOf(nearestQueries[indexOf(list[0])]) != i))
            return;
        std::vector<DMatch>& queryMatches = matches[before + i];
        queryMatches.resize(found);
        for (int j = 0; j < found; j++)
            queryMatches[j] = index.match(i, list[j]);
    };
    const size_t TASK = 1000;  // fewer queries take less time than waking a thread
    forEach((query.rows + TASK - 1) / TASK, threadsAllowed(),
            [&](size_t task, int)
            {
                for (int i = int(task * TASK), last = std::min(i + int(TASK), query.rows); i < last; i++)
                    writeMatches(i);
            });
    if (compactResult)
        matches.erase(std::remove_if(matches.begin() + before, matches.end(),
                                     [](const std::vector<DMatch>& list) { return list.empty(); }),
                      matches.end());
}
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

void HammingMatcher::radiusMatchImpl(InputArray queryDescriptors, MatchLists& matches, float maxDistance,
                                     InputArrayOfArrays masks_, bool compactResult)
try
{
    CV_TRACE_FUNCTION();
    const Mat query = descriptorsOf("queryDescriptors", queryDescriptors);
    const std::vector<Mat> images = gatherTrainDescriptors(query);
    const std::vector<Mat> masks = masksOf(masks_, query.rows, images);
    matches.assign(query.rows, std::vector<DMatch>());
    const CollectionIndex index(images);
    forImages(query, images, masks,
              [&](const Mat& train, const Mat& mask, size_t first)
              {
                  allDistances(query, train, normType == NORM_HAMMING2,
                               [&](int row, int firstTrain, const int* distances, int count)
                               {
                                   for (int j = firstTrain; j < firstTrain + count; j++, distances++)
                                   {
                                       // As in cv::BFMatcher, excluded pairs have distance INT_MAX, within a
                                       // limit of 2^31.
                                       const int distance =
                                           mask.empty() || mask.at<uchar>(row, j) ? *distances : INT_MAX;
                                       if (float(distance) <= maxDistance)
                                           matches[row].push_back(index.match(
                                               row, distanceKey(distance, index.first(first) + j)));
                                   }
                               });
              });
    for (size_t i = 0; i < matches.size(); i++)
        std::stable_sort(matches[i].begin(), matches[i].end());
    // As in cv::BFMatcher, empty lists stay and come last.
    if (compactResult)
        std::stable_partition(matches.begin(), matches.end(),
                              [](const std::vector<DMatch>& list) { return !list.empty(); });
}
catch (const std::bad_alloc&)
{
    throwNoMemory(queryDescriptors);
}

}  // namespace aqorb
}  // namespace cv
