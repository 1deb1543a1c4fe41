// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "output.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

void outputFeatures(const LevelFeatures& features, OutputScratch& scratch, KeyPoint* keypoints, int row,
                    Mat& descriptors)
{
    const FeatureBatch &byQuota = features.byQuota, &filled = features.filled;
    // Features are numbered through both batches. Each is in raster order. Both together are sorted, as std::inplace_merge
    // would allocate memory.
    const unsigned quota = unsigned(byQuota.points.size()), count = unsigned(features.size());
    const auto batchOf = [&](unsigned index) -> const FeatureBatch&
    { return index < quota ? byQuota : filled; };
    const auto place = [&](unsigned index) { return index < quota ? index : index - quota; };
    std::vector<unsigned>& rasterOrder = scratch.rasterOrder;
    rasterOrder.resize(count);
    std::iota(rasterOrder.begin(), rasterOrder.end(), 0u);
    if (quota < count)
        std::sort(rasterOrder.begin(), rasterOrder.end(),
                  [&](unsigned a, unsigned b)
                  { return InRasterOrder()(batchOf(a).points[place(a)], batchOf(b).points[place(b)]); });
    scratch.keys.resize(count);
    for (unsigned i = 0; i < count; i++)
        scratch.keys[i] = batchOf(rasterOrder[i]).outputKeys[place(rasterOrder[i])];
    sortIndices(scratch.keys, scratch.sorting, scratch.sorted);
    for (unsigned i = 0; i < count; i++, row++)
    {
        const unsigned index = rasterOrder[scratch.sorted[i]];
        keypoints[i] = batchOf(index).keypoints[place(index)];
        if (!descriptors.empty())
            std::memcpy(descriptors.ptr(row),
                        &batchOf(index).descriptors[size_t(place(index)) * DESCRIPTOR_BYTES],
                        DESCRIPTOR_BYTES);
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
