// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks descriptors, packs them for the kernels, and searches nearest descriptors in tiles that stay in the cache.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "matching/hamming.hpp"
#include "common/memory.hpp"

#include "matching/hamming.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_ICL, AVX512_SKX, AVX2, SSE4_1, BASELINE on x86-64.
#include "matching/hamming.simd_declarations.hpp"

#include <opencv2/core/hal/hal.hpp>

// If AVX512-SKX is disabled by OPENCV_CPU_DISABLE, so are the instructions that build on it.
#if CV_TRY_AVX512_ICL && !CV_CPU_FORCE_AVX512_ICL
#undef CV_CPU_HAS_SUPPORT_AVX512_ICL
#define CV_CPU_HAS_SUPPORT_AVX512_ICL \
    (cv::checkHardwareSupport(CV_CPU_AVX512_ICL) && cv::checkHardwareSupport(CV_CPU_AVX512_SKX))
#endif

namespace cv
{
namespace aqorb
{

void checkHammingNorm(int normType)
{
    if (normType != NORM_HAMMING && normType != NORM_HAMMING2)
        CV_Error_(Error::StsBadArg, ("normType must be NORM_HAMMING (%d) or NORM_HAMMING2 (%d), got %d; "
                                     "cv::BFMatcher has other norms",
                                     int(NORM_HAMMING), int(NORM_HAMMING2), normType));
}

Mat descriptorsOf(const char* name, InputArray descriptors, int width, int image)
{
    const auto fail = [&](Error::Code code, const std::string& fault)
    { CV_Error(code, name + (image < 0 ? "" : format(" of image %d", image)) + " must " + fault); };
    if (descriptors.isMatVector() || descriptors.isUMatVector())
        fail(Error::StsBadArg, format("be a single matrix, got a sequence of %d", int(descriptors.total())));
    if (descriptors.dims() > 2 || (descriptors.type() != CV_8UC1 && !descriptors.empty()))
        fail(Error::StsBadArg, format("be rows of type CV_8UC1, got %d dimensions of type %s",
                                      descriptors.dims(), typeToString(descriptors.type()).c_str()));
    if (descriptors.empty())
        return Mat();
    if (width != 0 && descriptors.cols() != width)
        fail(Error::StsUnmatchedSizes,
             format("have %d bytes a row, as queryDescriptors, got %d", width, descriptors.cols()));
    return descriptors.getMat();
}

void throwNoMemory(InputArray queryDescriptors)
{
    CV_Error_(Error::StsNoMem, ("The memory does not suffice to match %d queryDescriptors of %d bytes",
                                queryDescriptors.rows(), queryDescriptors.cols()));
}

const HammingKernels* hammingKernels(int words)
{
    CV_CPU_DISPATCH(kernelsFor, (words), CV_CPU_DISPATCH_MODES_ALL);
}

namespace
{

//! Limit on the bytes of packed descriptors: 16 bits count their bits, and a tile stays in the cache.
const int MAX_PACKED_BYTES = 1024;
//! Limit on the bytes of descriptors whose distances fit into a 16-bit key.
const int MAX_KEY_BYTES = 127;
//! Size of a tile of distances.
const int QUERIES = 8, TRAINS = 1024;

/** Adds a third bit to each pair of bits for NORM_HAMMING2: 000, 101, 011 or 110. The Hamming distance of two such
 descriptors is twice their number of different pairs. */
Mat withThirdBits(const Mat& descriptors, bool countPairs)
{
    if (!countPairs)
        return descriptors;
    const int bytes = descriptors.cols;
    Mat result(descriptors.rows, bytes + (bytes + 1) / 2, CV_8UC1, Scalar(0));
    for (int i = 0; i < descriptors.rows; i++)
    {
        const uchar* const from = descriptors.ptr(i);
        uchar* const to = result.ptr(i);
        std::memcpy(to, from, size_t(bytes));
        for (int j = 0; j < bytes; j++)  // third bits of two bytes fill one byte
            to[bytes + j / 2] |= uchar(((from[j] ^ from[j] >> 1) & 0x55) << j % 2);
    }
    return result;
}

//! Whether kernels exist for these descriptors.
bool isPacked(const Mat& descriptors)
{
    return hammingKernels(0) && descriptors.cols <= MAX_PACKED_BYTES;
}

//! Tile with its packed descriptors. Each thread has its own: packing trains is faster than fetching them from the
//! cache of another core.
class PackedTile
{
public:
    //! @param mask empty, or with a row for each query
    PackedTile(const HammingKernels& kernels_, const Mat& query_, const Mat& train_, const Mat& mask_)
        : tile(), kernels(kernels_), query(query_), train(train_), mask(mask_)
    {
        tile.words = wordsOf(query);
    }
    static int wordsOf(const Mat& descriptors) { return (descriptors.cols + 7) / 8; }

    //! Packs tiles, and calls the function for each tile with the indices of its first query and its first train.
    template <typename Function>
    void forTiles(const Range& rows, int tileQueries, int tileTrains, int firstIndex,
                  const Function& function)
    {
        for (int first = 0; first < train.rows; first = nextRows(first, tileTrains, train.rows).end)
        {
            packTrains(nextRows(first, tileTrains, train.rows), firstIndex);
            for (int i = rows.start; i < rows.end; i = nextRows(i, tileQueries, rows.end).end)
            {
                packQueries(nextRows(i, tileQueries, rows.end));
                if (!mask.empty())
                    packMask(i, first);
                function(i, first);
            }
        }
    }

    HammingTile tile;

private:
    //! The next rows from i on, at most `count`.
    static Range nextRows(int i, int count, int end) { return Range(i, i + std::min(count, end - i)); }

    void packTrains(const Range& rows, int firstTrain)
    {
        const int block = kernels.block, words = tile.words * kernels.halves;
        trains.resize(alignSize(size_t(rows.size()), block) * words);
        for (int i = 0; i < rows.size(); i++)
            pack(train, rows.start + i,
                 &trains[size_t(i / block) * block * words + kernels.laneOf(i % block)], block);
        tile.trains = trains.data();
        tile.trainCount = rows.size();
        tile.firstTrain = firstTrain + rows.start;
    }
    void packQueries(const Range& rows)
    {
        const int words = tile.words * kernels.halves;
        queries.resize(size_t(rows.size()) * words);
        for (int i = 0; i < rows.size(); i++)
            pack(query, rows.start + i, &queries[size_t(i) * words], 1);
        tile.queries = queries.data();
        tile.queryCount = rows.size();
        tile.firstQuery = rows.start;
    }
    void packMask(int firstQuery, int firstTrain)
    {
        tile.allowedStride = alignSize(size_t(tile.trainCount), kernels.block);
        allowed.assign(tile.allowedStride * tile.queryCount, 0);
        for (int i = 0; i < tile.queryCount; i++)
            std::memcpy(&allowed[i * tile.allowedStride], mask.ptr(firstQuery + i) + firstTrain,
                        size_t(tile.trainCount));
        tile.allowed = allowed.data();
    }

    //! Packs a descriptor into words `stride` words apart.
    void pack(const Mat& descriptors, int row, uint64* packed, int stride) const
    {
        const uchar* const bytes = descriptors.ptr(row);
        for (int i = 0; i < descriptors.cols; i += 8)
        {
            uint64 word = 0;
            if (descriptors.cols - i >= 8)
                std::memcpy(&word, bytes + i, 8);
            else
                std::memcpy(&word, bytes + i, size_t(descriptors.cols - i));
            const uint64 low = kernels.halves == 1 ? ~uint64(0) : 0x0f0f0f0f0f0f0f0fu;
            for (int half = 0; half < kernels.halves; half++, packed += stride)
                *packed = word >> 4 * half & low;
        }
    }

    const HammingKernels& kernels;
    const Mat &query, &train, &mask;
    AlignedVector<uint64> trains, queries;
    AlignedVector<uchar> allowed;
};

//! Divides rows among threads, at least a tile each, and calls the function for the rows of each thread.
template <typename Function> void forRows(int rows, int tileRows, const Function& function)
{
    // One part for each thread, because each part packs all trains.
    const int parts = std::min((rows - 1) / tileRows + 1, threadsAllowed());
    forEach(size_t(parts), parts,
            [&](size_t i, int)
            { function(Range(int(int64(rows) * i / parts), int(int64(rows) * (i + 1) / parts))); });
}

//! Computes the allowed distances one by one. Packing the rare long descriptors would take more time and memory.
void distancesOneByOne(const Mat& query, const Mat& train, const Mat& mask, bool countPairs,
                       const DistanceSink& sink)
{
    forEach(size_t(query.rows), threadsAllowed(),
            [&](size_t row, int)
            {
                const int i = int(row);
                for (int j = 0; j < train.rows; j++)
                {
                    if (!mask.empty() && !mask.at<uchar>(i, j))
                        continue;
                    const int distance =
                        hal::normHamming(query.ptr(i), train.ptr(j), query.cols, countPairs ? 2 : 1);
                    sink(i, j, &distance, 1);
                }
            });
}

//! Adds keys to lists of KEPT keys, with half the distance if withThirdBits doubled it.
template <int KEPT> void addKeys(const std::vector<DistanceKey>& keys, bool isDoubled, DistanceKey* lists)
{
    for (size_t i = 0; i < keys.size(); i++)
    {
        const DistanceKey half = distanceKey(distanceOf(keys[i]) / 2, indexOf(keys[i]));
        keepKey<KEPT>(lists + i / KEPT * KEPT, isDoubled && keys[i] != NO_KEY ? half : keys[i]);
    }
}

//! Finds one or two nearest descriptors by their kernels.
void nearestInTiles(const HammingKernels& kernels, const Mat& query, const Mat& train, const Mat& mask,
                    bool isDoubled, int firstTrain, int kept, DistanceKey* queryLists,
                    DistanceKey* trainLists)
{
    const int tileQueries = 1 << kernels.indexBits, tileTrains = kernels.block << kernels.indexBits;
    const auto add = kept == 1 ? addKeys<1> : addKeys<2>;
    Mutex mutex;
    forRows(query.rows, tileQueries,
            [&](const Range& rows)
            {
                PackedTile packed(kernels, query, train, mask);
                AlignedVector<ushort> space(size_t(tileQueries) * kept * kernels.block);
                packed.tile.space = space.data();
                std::vector<DistanceKey> queryKeys(size_t(rows.size()) * kept, NO_KEY),
                    trainKeys(trainLists ? size_t(train.rows) * kept : 0, NO_KEY);
                const auto nearest = kernels.nearest[kept - 1][trainLists != 0][!mask.empty()];
                packed.forTiles(rows, tileQueries, tileTrains, firstTrain,
                                [&](int i, int first)
                                {
                                    nearest(packed.tile, &queryKeys[size_t(i - rows.start) * kept],
                                            trainLists ? &trainKeys[size_t(first) * kept] : 0);
                                });
                add(queryKeys, isDoubled, queryLists + size_t(rows.start) * kept);
                const AutoLock lock(mutex);
                add(trainKeys, isDoubled, trainLists);
            });
}

//! Work space of one thread.
struct DistanceSpace
{
    std::vector<int> numbers;  //!< one for each element of a row
    std::vector<int> counts;
    std::vector<DistanceKey> keys;
};

//! Adds the least distances of a row to a list.
//! @param row trainCount distances; the padding of the last block is overwritten
//! @param isDoubled whether the row has twice the distances of the list
void addLeast(const HammingKernels& kernels, ushort* row, const HammingTile& tile, bool isDoubled,
              DistanceSpace& space, DistanceKey* list, int kept)
{
    const int count = int(alignSize(size_t(tile.trainCount), kernels.block));
    std::fill(row + tile.trainCount, row + count, ushort(0x7fff));
    const DistanceKey last = list[kept - 1];
    const int limit = last == NO_KEY ? 64 * tile.words + 1 : distanceOf(last) << isDoubled;
    const int found = kernels.leastDistances(row, count, limit, kept, space.numbers.data());
    if (found == 0)
        return;
    // Counting sort: distances are small numbers. Its time does not depend on the length of the list.
    space.counts.assign(size_t(limit) + 1, 0);
    for (int i = 0; i < found; i++)
        space.counts[row[space.numbers[i]] + 1]++;
    std::partial_sum(space.counts.begin(), space.counts.end(), space.counts.begin());
    const ptrdiff_t before = std::lower_bound(list, list + kept, NO_KEY) - list;
    space.keys.assign(list, list + before);
    space.keys.resize(size_t(before + found));
    for (int i = 0; i < found; i++)
    {
        const int distance = row[space.numbers[i]];
        space.keys[size_t(before + space.counts[distance]++)] =
            distanceKey(distance >> isDoubled, tile.firstTrain + space.numbers[i]);
    }
    std::inplace_merge(space.keys.begin(), space.keys.begin() + before, space.keys.end());
    std::copy_n(space.keys.begin(), std::min(space.keys.size(), size_t(kept)), list);
}

//! Calls the function for each query and tile, with the distances to the tile's trains and a work space.
template <typename Function>
void forDistances(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                  const Function& function)
{
    const Mat q = withThirdBits(query, countPairs), t = withThirdBits(train, countPairs);
    const HammingKernels& kernels = *hammingKernels(PackedTile::wordsOf(q));
    forRows(query.rows, QUERIES,
            [&](const Range& rows)
            {
                PackedTile packed(kernels, q, t, mask);
                AlignedVector<ushort> distances(size_t(QUERIES) * TRAINS);
                DistanceSpace space;
                space.numbers.resize(TRAINS);
                packed.forTiles(rows, QUERIES, TRAINS, firstTrain,
                                [&](int i, int first)
                                {
                                    kernels.distances(packed.tile, distances.data(), TRAINS);
                                    for (int j = 0; j < packed.tile.queryCount; j++)
                                        function(space, i + j, first, &distances[size_t(j) * TRAINS],
                                                 packed.tile);
                                });
            });
}

//! Finds the nearest trains of each query, for lists of any length.
void nearestTrains(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                   int kept, DistanceKey* nearest)
{
    if (!isPacked(query))
    {
        distancesOneByOne(
            query, train, mask, countPairs,
            [=](int i, int j, const int* distance, int)
            { insertKey(nearest + size_t(i) * kept, kept, distanceKey(*distance, firstTrain + j)); });
        return;
    }
    const HammingKernels& kernels = *hammingKernels(0);
    forDistances(query, train, mask, countPairs, firstTrain,
                 [&](DistanceSpace& space, int i, int, ushort* row, const HammingTile& tile)
                 { addLeast(kernels, row, tile, countPairs, space, nearest + size_t(i) * kept, kept); });
}

}  // namespace

void allDistances(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink)
{
    CV_TRACE_FUNCTION();
    if (!isPacked(query))
    {
        distancesOneByOne(query, train, Mat(), countPairs, sink);
        return;
    }
    forDistances(query, train, Mat(), countPairs, 0,
                 [&](DistanceSpace& space, int i, int first, const ushort* row, const HammingTile& tile)
                 {
                     std::transform(row, row + tile.trainCount, space.numbers.begin(),
                                    [=](ushort distance) { return distance >> int(countPairs); });
                     sink(i, first, space.numbers.data(), tile.trainCount);
                 });
}

void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* queryLists, DistanceKey* trainLists)
{
    CV_TRACE_FUNCTION();
    if (query.empty() || train.empty())
        return;
    if (kept <= 2 && query.cols <= MAX_KEY_BYTES && isPacked(query))
    {
        const Mat q = withThirdBits(query, countPairs), t = withThirdBits(train, countPairs);
        nearestInTiles(*hammingKernels(PackedTile::wordsOf(q)), q, t, mask, countPairs, firstTrain, kept,
                       queryLists, trainLists);
        return;
    }
    nearestTrains(query, train, mask, countPairs, firstTrain, kept, queryLists);
    if (trainLists)
        nearestTrains(train, query, mask.empty() ? mask : Mat(mask.t()), countPairs, 0, kept, trainLists);
}

}  // namespace aqorb
}  // namespace cv
