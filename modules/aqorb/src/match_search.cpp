// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks descriptors, and searches the nearest ones in tiles that stay in the cache.

#include "precomp.hpp"

#include "aligned.hpp"
#include "match.hpp"

#include <opencv2/core/hal/hal.hpp>

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

Mat descriptorsOf(const char* name, InputArray descriptors, int width)
{
    if (descriptors.isMatVector() || descriptors.isUMatVector())
        CV_Error_(Error::StsBadArg,
                  ("%s must be a single matrix, got a sequence of %d", name, int(descriptors.total())));
    if (descriptors.dims() > 2 || (descriptors.type() != CV_8UC1 && !descriptors.empty()))
        CV_Error_(Error::StsBadArg, ("%s must be rows of type CV_8UC1, got %d dimensions of type %s", name,
                                     descriptors.dims(), typeToString(descriptors.type()).c_str()));
    if (descriptors.empty())
        return Mat();
    if (width != 0 && descriptors.cols() != width)
        CV_Error_(Error::StsUnmatchedSizes, ("%s must have %d bytes a row, as queryDescriptors, got %d", name,
                                             width, descriptors.cols()));
    return descriptors.getMat();
}

void throwNoMemory(InputArray queryDescriptors)
{
    CV_Error_(Error::StsNoMem, ("The memory does not suffice to match %d queryDescriptors of %d bytes",
                                queryDescriptors.rows(), queryDescriptors.cols()));
}

namespace
{

//! A tile, and the packed descriptors that it points to. Each thread has its own: it packs the trains in less time than
//! it takes to get them from the cache of another core.
class PackedTile
{
public:
    PackedTile(const HammingKernels& kernels_, const Mat& query_, const Mat& train_)
        : tile(), kernels(kernels_), query(query_), train(train_)
    {
        tile.words = (query.cols + 7) / 8;
    }
    void packTrains(const Range& rows, int firstTrain)
    {
        const size_t blockWords = size_t(tile.words) * kernels.trainPlanes * kernels.block;
        trains.resize((rows.size() + kernels.block - 1) / kernels.block * blockWords);
        for (int i = 0; i < rows.size(); i += kernels.block)
            kernels.packTrains(train.ptr(rows.start + i), train.step,
                               std::min(kernels.block, rows.size() - i), train.cols,
                               &trains[i / kernels.block * blockWords]);
        tile.trains = trains.data();
        tile.trainCount = rows.size();
        tile.firstTrain = firstTrain + rows.start;
    }
    void packQueries(const Range& rows)
    {
        queries.resize(size_t(rows.size()) * tile.words * kernels.queryPlanes);
        kernels.packQueries(query.ptr(rows.start), query.step, rows.size(), query.cols, queries.data());
        tile.queries = queries.data();
        tile.queryCount = rows.size();
        tile.firstQuery = rows.start;
    }

    HammingTile tile;

private:
    const HammingKernels& kernels;
    const Mat &query, &train;
    AlignedVector<uint64> trains, queries;
};

//! Calls a function for ranges of rows that are divided into tiles of at most a number of rows, in parallel.
template <typename Function> void forRows(int rows, int rowsOfTile, const Function& function)
{
    const int tiles = (rows + rowsOfTile - 1) / rowsOfTile;
    // One part a thread, as each has work space and packs the trains for itself.
    parallel_for_(
        Range(0, tiles),
        [&](const Range& some)
        { function(Range(int(int64(rows) * some.start / tiles), int(int64(rows) * some.end / tiles))); },
        getNumThreads());
}

//! The next at most count rows from i on.
Range nextRows(int i, int count, const Range& rows)
{
    return Range(i, std::min(i + count, rows.end));
}

int bitsFor(int number)
{
    int bits = 0;
    for (; number; number >>= 1)
        bits++;
    return bits;
}

template <int KEPT> void mergeLists(const std::vector<DistanceKey>& lists, DistanceKey* merged)
{
    for (size_t i = 0; i < lists.size(); i += KEPT)
        for (int k = 0; k < KEPT; k++)
            keepKey<KEPT>(merged + i, lists[i + k]);
}

//! Keeps the nearest trains of each query that the mask allows.
DistanceSink nearestSink(const Mat& mask, int firstIndex, int kept, DistanceKey* nearest)
{
    return [=](int query, int firstTrain, const int* distances, int count)
    {
        const uchar* const allowed = mask.empty() ? 0 : mask.ptr(query) + firstTrain;
        DistanceKey* const list = nearest + size_t(query) * kept;
        for (int i = 0; i < count; i++)
            if (!allowed || allowed[i])
                insertKey(list, kept, distanceKey(distances[i], firstIndex + firstTrain + i));
    };
}

}  // namespace

//! The distances of long descriptors, of which there are few: packed, they would take more time and memory.
static void distancesOfLong(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink)
{
    parallel_for_(Range(0, query.rows),
                  [&](const Range& rows)
                  {
                      for (int i = rows.start; i < rows.end; i++)
                      {
                          for (int j = 0; j < train.rows; j++)
                          {
                              const int distance = hal::normHamming(query.ptr(i), train.ptr(j), query.cols,
                                                                    countPairs ? 2 : 1);
                              sink(i, j, &distance, 1);
                          }
                      }
                  });
}

void allDistances(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink)
{
    CV_TRACE_FUNCTION();
    if (query.cols > MAX_PACKED_BYTES)
    {
        distancesOfLong(query, train, countPairs, sink);
        return;
    }
    const int QUERIES = 8, TRAINS = 1024;
    const HammingKernels& kernels = hammingKernels(countPairs, query.cols);
    forRows(query.rows, QUERIES,
            [&](const Range& rows)
            {
                PackedTile packed(kernels, query, train);
                AlignedVector<int> distances(size_t(QUERIES) * TRAINS);
                for (int first = 0; first < train.rows; first += TRAINS)
                {
                    packed.packTrains(nextRows(first, TRAINS, Range(0, train.rows)), 0);
                    for (int i = rows.start; i < rows.end; i += QUERIES)
                    {
                        packed.packQueries(nextRows(i, QUERIES, rows));
                        kernels.distances(packed.tile, distances.data(), TRAINS);
                        for (int j = 0; j < packed.tile.queryCount; j++)
                            sink(i + j, first, &distances[size_t(j) * TRAINS], packed.tile.trainCount);
                    }
                }
            });
}

//! Few neighbours, of descriptors that are not too long, by the kernels for them.
static void nearestInTiles(const Mat& query, const Mat& train, bool countPairs, int firstTrain, int kept,
                           DistanceKey* ofQueries, DistanceKey* ofTrains)
{
    const HammingKernels& kernels = hammingKernels(countPairs, query.cols);
    // The bits of a key of 16 bits that the distance leaves. More queries at once would need more of the cache.
    const int indexBits = std::min(16 - bitsFor(8 * query.cols), 7);
    const int queriesOfTile = 1 << indexBits, step = kernels.block << indexBits;
    Mutex mutex;
    forRows(query.rows, queriesOfTile,
            [&](const Range& rows)
            {
                PackedTile packed(kernels, query, train);
                AlignedVector<ushort> scratch(size_t(queriesOfTile) * kept * kernels.block);
                packed.tile.indexBits = indexBits;
                packed.tile.scratch = scratch.data();
                std::vector<DistanceKey> own(ofTrains ? size_t(train.rows) * kept : 0, NO_KEY);
                for (int first = 0; first < train.rows; first += step)
                {
                    packed.packTrains(nextRows(first, step, Range(0, train.rows)), firstTrain);
                    for (int i = rows.start; i < rows.end; i += queriesOfTile)
                    {
                        packed.packQueries(nextRows(i, queriesOfTile, rows));
                        kernels.nearest[kept - 1][ofTrains != 0](packed.tile, ofQueries + size_t(i) * kept,
                                                                 own.data() + size_t(first) * kept);
                    }
                }
                if (ofTrains)
                {
                    const AutoLock lock(mutex);
                    (kept == 1 ? mergeLists<1> : mergeLists<2>)(own, ofTrains);
                }
            });
}

void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* ofQueries, DistanceKey* ofTrains)
{
    CV_TRACE_FUNCTION();
    if (query.empty() || train.empty())
        return;
    if (mask.empty() && kept <= MAX_KEPT && query.cols <= MAX_KEY_BITS / 8)
    {
        nearestInTiles(query, train, countPairs, firstTrain, kept, ofQueries, ofTrains);
        return;
    }
    allDistances(query, train, countPairs, nearestSink(mask, firstTrain, kept, ofQueries));
    if (ofTrains)  // never with a mask
        allDistances(train, query, countPairs, nearestSink(mask, 0, kept, ofTrains));
}

}  // namespace aqorb
}  // namespace cv
