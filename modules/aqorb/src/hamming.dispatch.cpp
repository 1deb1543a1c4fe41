// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks descriptors, packs them for the kernels, and searches the nearest ones in tiles that stay in the cache.

#include "precomp.hpp"

#include "types.hpp"
#include "hamming.hpp"

#include "hamming.simd.hpp"
#include "hamming.simd_declarations.hpp"

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

const HammingKernels* hammingKernels(int words)
{
    CV_CPU_DISPATCH(kernelsFor, (words), CV_CPU_DISPATCH_MODES_ALL);
}

namespace
{

//! The longest descriptors that are packed: a sum of 16 bits counts their bits, and a tile stays in the cache.
const int MAX_PACKED_BYTES = 1024;
//! The longest ones whose distances fit into a key of 16 bits.
const int MAX_KEY_BYTES = 127;

/** Descriptors whose Hamming distances are twice the numbers of pairs of bits that differ: each pair becomes three
 bits, 000, 101, 011 or 110. */
Mat withThirdBits(const Mat& descriptors)
{
    const int bytes = descriptors.cols;
    Mat result(descriptors.rows, bytes + (bytes + 1) / 2, CV_8UC1, Scalar(0));
    for (int i = 0; i < descriptors.rows; i++)
    {
        const uchar* const from = descriptors.ptr(i);
        uchar* const to = result.ptr(i);
        std::memcpy(to, from, size_t(bytes));
        for (int j = 0; j < bytes; j++)  // a byte has four pairs, so two of them fill one
            to[bytes + j / 2] |= uchar(((from[j] ^ from[j] >> 1) & 0x55) << j % 2);
    }
    return result;
}

//! A tile, and the packed descriptors that it points to. Each thread has its own: it packs the trains in less time than
//! it takes to get them from the cache of another core.
class PackedTile
{
public:
    PackedTile(const HammingKernels& kernels_, const Mat& query_, const Mat& train_)
        : tile(), kernels(kernels_), query(query_), train(train_)
    {
        tile.words = wordsOf(query);
    }
    static int wordsOf(const Mat& descriptors) { return (descriptors.cols + 7) / 8; }

    void packTrains(const Range& rows, int firstTrain)
    {
        const int block = kernels.block, planes = tile.words * kernels.planes;
        trains.resize(alignSize(size_t(rows.size()), block) * planes);
        for (int i = 0; i < rows.size(); i++)
            pack(train, rows.start + i,
                 &trains[size_t(i / block) * block * planes + kernels.laneOf(i % block)], block);
        tile.trains = trains.data();
        tile.trainCount = rows.size();
        tile.firstTrain = firstTrain + rows.start;
    }
    void packQueries(const Range& rows)
    {
        const int planes = tile.words * kernels.planes;
        queries.resize(size_t(rows.size()) * planes);
        for (int i = 0; i < rows.size(); i++)
            pack(query, rows.start + i, &queries[size_t(i) * planes], 1);
        tile.queries = queries.data();
        tile.queryCount = rows.size();
        tile.firstQuery = rows.start;
    }

    HammingTile tile;

private:
    //! Writes the planes of a descriptor, which are stride words apart.
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
            const uint64 low = kernels.planes == 1 ? ~uint64(0) : 0x0f0f0f0f0f0f0f0fu;
            for (int plane = 0; plane < kernels.planes; plane++, packed += stride)
                *packed = word >> 4 * plane & low;
        }
    }

    const HammingKernels& kernels;
    const Mat &query, &train;
    AlignedVector<uint64> trains, queries;
};

//! Divides rows among the threads, in multiples of about a tile, and calls the function for the rows of each.
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
Range nextRows(int i, int count, int end)
{
    return Range(i, std::min(i + count, end));
}

//! The distances one by one. Long descriptors are rare, and would take more time and memory if packed.
void distancesOneByOne(const Mat& query, const Mat& train, bool countPairs, const DistanceSink& sink)
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

//! Adds keys to lists of KEPT, with half the distance where withThirdBits has doubled it.
template <int KEPT> void addKeys(const std::vector<DistanceKey>& keys, bool isDoubled, DistanceKey* lists)
{
    for (size_t i = 0; i < keys.size(); i++)
    {
        const DistanceKey half = distanceKey(distanceOf(keys[i]) / 2, indexOf(keys[i]));
        keepKey<KEPT>(lists + i / KEPT * KEPT, isDoubled && keys[i] != NO_KEY ? half : keys[i]);
    }
}

//! Few neighbours, of descriptors that are not too long, by the kernels for them.
void nearestInTiles(const HammingKernels& kernels, const Mat& query, const Mat& train, bool isDoubled,
                    int firstTrain, int kept, DistanceKey* ofQueries, DistanceKey* ofTrains)
{
    const int queriesOfTile = 1 << kernels.indexBits, trainsOfTile = kernels.block << kernels.indexBits;
    const auto add = kept == 1 ? addKeys<1> : addKeys<2>;
    Mutex mutex;
    forRows(query.rows, queriesOfTile,
            [&](const Range& rows)
            {
                PackedTile packed(kernels, query, train);
                AlignedVector<ushort> scratch(size_t(queriesOfTile) * kept * kernels.block);
                packed.tile.scratch = scratch.data();
                std::vector<DistanceKey> queryKeys(size_t(rows.size()) * kept, NO_KEY),
                    trainKeys(ofTrains ? size_t(train.rows) * kept : 0, NO_KEY);
                for (int first = 0; first < train.rows; first += trainsOfTile)
                {
                    packed.packTrains(nextRows(first, trainsOfTile, train.rows), firstTrain);
                    for (int i = rows.start; i < rows.end; i += queriesOfTile)
                    {
                        packed.packQueries(nextRows(i, queriesOfTile, rows.end));
                        kernels.nearest[kept - 1][ofTrains != 0](
                            packed.tile, &queryKeys[size_t(i - rows.start) * kept],
                            ofTrains ? &trainKeys[size_t(first) * kept] : 0);
                    }
                }
                add(queryKeys, isDoubled, ofQueries + size_t(rows.start) * kept);
                const AutoLock lock(mutex);
                add(trainKeys, isDoubled, ofTrains);
            });
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

void allDistances(const Mat& query_, const Mat& train_, bool countPairs, const DistanceSink& sink)
{
    CV_TRACE_FUNCTION();
    const HammingKernels* const kernels = hammingKernels(0);
    if (!kernels || query_.cols > MAX_PACKED_BYTES)
    {
        distancesOneByOne(query_, train_, countPairs, sink);
        return;
    }
    const Mat query = countPairs ? withThirdBits(query_) : query_,
              train = countPairs ? withThirdBits(train_) : train_;
    const int QUERIES = 8, TRAINS = 1024;
    forRows(query.rows, QUERIES,
            [&](const Range& rows)
            {
                PackedTile packed(*kernels, query, train);
                AlignedVector<int> distances(size_t(QUERIES) * TRAINS);
                for (int first = 0; first < train.rows; first += TRAINS)
                {
                    packed.packTrains(nextRows(first, TRAINS, train.rows), 0);
                    for (int i = rows.start; i < rows.end; i += QUERIES)
                    {
                        packed.packQueries(nextRows(i, QUERIES, rows.end));
                        hammingKernels(packed.tile.words)->distances(packed.tile, distances.data(), TRAINS);
                        if (countPairs)
                            std::transform(distances.begin(), distances.end(), distances.begin(),
                                           [](int distance) { return distance / 2; });
                        for (int j = 0; j < packed.tile.queryCount; j++)
                            sink(i + j, first, &distances[size_t(j) * TRAINS], packed.tile.trainCount);
                    }
                }
            });
}

void nearestDescriptors(const Mat& query, const Mat& train, const Mat& mask, bool countPairs, int firstTrain,
                        int kept, DistanceKey* ofQueries, DistanceKey* ofTrains)
{
    CV_TRACE_FUNCTION();
    if (query.empty() || train.empty())
        return;
    if (mask.empty() && kept <= 2 && query.cols <= MAX_KEY_BYTES && hammingKernels(0))
    {
        const Mat q = countPairs ? withThirdBits(query) : query,
                  t = countPairs ? withThirdBits(train) : train;
        nearestInTiles(*hammingKernels(PackedTile::wordsOf(q)), q, t, countPairs, firstTrain, kept, ofQueries,
                       ofTrains);
        return;
    }
    allDistances(query, train, countPairs, nearestSink(mask, firstTrain, kept, ofQueries));
    if (ofTrains)  // never with a mask
        allDistances(train, query, countPairs, nearestSink(mask, 0, kept, ofTrains));
}

}  // namespace aqorb
}  // namespace cv
