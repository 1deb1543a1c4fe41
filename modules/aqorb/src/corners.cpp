// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Searches bands of all levels side by side, and applies the mesh of cells and the suppression to them.

#include "precomp.hpp"

#include "corners.hpp"
#include "for_each.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{

namespace
{

// Lists the corners of the rows before `end`, and takes their blocks out. The SUPPRESS_RADIUS rows from there on must
// have their scores, too, as far as there are any.
void listBefore(int end, bool suppressNear, CornerScratch& scratch, std::vector<Corner>& found)
{
    CornerBlocks& blocks = scratch.blocks;
    int taken = blocks.count, left = 0;  // corners that are not listed yet
    while (taken > 0 && blocks.storage[taken - 1].y >= end)
        left += bitCount(blocks.storage[--taken].columns);
    const int corners = blocks.cornerCount - left;
    if (!suppressNear)
    {
        listCorners(blocks.storage.data(), blocks.storage.data() + taken, scratch.plane, found);
    }
    else if (corners > 0)
    {
        // The kernel writes every corner before it knows whether it is kept.
        growTo(scratch.kept, size_t(corners) + 1);
        const int kept = writeKeptCorners(blocks.storage.data(), corners, scratch.plane, scratch.kept.data());
        // Lists of corners are long and stay, so they grow by little more than they need.
        const size_t size = found.size() + size_t(kept);
        if (size > found.capacity())
            found.reserve(size + size / 8);
        found.insert(found.end(), scratch.kept.data(), scratch.kept.data() + kept);
    }
    std::copy(blocks.storage.begin() + taken, blocks.storage.begin() + blocks.count, blocks.storage.begin());
    blocks.count -= taken;
    blocks.cornerCount = left;
}

}  // namespace

void searchBand(const Level& level, const Rect& region, const Range& rows, const CornerRules& rules,
                CornerScratch& scratch, std::vector<Corner>& found)
{
    CV_TRACE_FUNCTION();
    found.clear();
    // Whether a corner is kept depends on corners in the next rows, and these on their cells.
    const int above = rules.suppressNear ? std::min(CELL_SIZE, rows.start - region.y) : 0;
    const int below = rules.suppressNear ? std::min(CELL_SIZE, region.br().y - rows.end) : 0;
    const Rect band(region.x, rows.start - above, region.width, rows.size() + above + below);
    const Rect scanned = fastRegion(level.image.size(), band);
    if (scanned.empty())
        return;
    const Point end = band.br();
    const int bottom = scanned.y + scanned.height;
    scratch.plane.reset(level.image.cols, Range(scanned.x, scanned.x + scanned.width), scanned.y,
                        std::min(CELL_SIZE, scanned.height));
    scratch.scanner.reset(level, scanned, rules.thresholds, scratch.plane, scratch.blocks);
    for (int y = band.y; y < end.y; y += CELL_SIZE)
    {
        const int scannedEnd = std::min(y + CELL_SIZE, bottom);
        scratch.plane.slideTo(std::min(y, bottom));
        scratch.scanner.scan(scannedEnd);
        for (int x = band.x; x < end.x; x += CELL_SIZE)
        {
            const Range cell(x, std::min(x + CELL_SIZE, end.x));
            if (scratch.scanner.hasStrong(cell))
                scratch.scanner.dropWeak(cell);
        }
        scratch.scanner.collect();
        listBefore(scannedEnd - SUPPRESS_RADIUS, rules.suppressNear, scratch, found);
    }
    scratch.plane.clearBelow(bottom);
    listBefore(bottom, rules.suppressNear, scratch, found);
    const auto isOutside = [&](const Corner& corner)
    { return corner.y < rows.start || corner.y >= rows.end; };
    if (above + below > 0)
        found.erase(std::remove_if(found.begin(), found.end(), isOutside), found.end());
}

std::vector<Band> divideIntoBands(const std::vector<Rect>& regions, int threads)
{
    double pixels = 0;
    for (const Rect& region : regions)
        pixels += double(region.width) * region.height;
    std::vector<Band> bands;
    for (size_t i = 0; i < regions.size(); i++)
    {
        // Rows of cells at the borders between bands are searched twice, so there are no more bands than threads need.
        const Rect& region = regions[i];
        const int64 cells = (int64(region.height) + CELL_SIZE - 1) / CELL_SIZE;
        const double share = double(region.width) * region.height * threads / pixels;
        const int64 count = std::max<int64>(std::min(int64(cvCeil(share)), cells / 2), 1);
        for (int64 j = 0; j < count; j++)
        {
            const int64 top = cells * j / count * CELL_SIZE, end = cells * (j + 1) / count * CELL_SIZE;
            bands.push_back(
                {int(i), Range(region.y + int(top), region.y + int(std::min<int64>(end, region.height)))});
        }
    }
    return bands;
}

const std::vector<std::vector<Corner>>& findCorners(const std::vector<Level>& levels,
                                                    const std::vector<Rect>& regions,
                                                    const CornerRules& rules, int threads, CornerSpace& space)
{
    CV_TRACE_FUNCTION();
    const std::vector<Band> bands = divideIntoBands(regions, threads);
    space.threads.resize(std::max(space.threads.size(), size_t(threads)));
    space.bands.resize(std::max(space.bands.size(), bands.size()));
    space.levels.resize(levels.size());
    forEach(bands.size(), threads,
            [&](size_t i, int thread)
            {
                const int level = bands[i].level;
                const bool isFirst = bands[i].rows.start == regions[level].y;
                searchBand(levels[level], regions[level], bands[i].rows, rules, space.threads[thread],
                           isFirst ? space.levels[level] : space.bands[i]);
            });
    for (size_t i = 0; i < bands.size(); i++)
    {
        std::vector<Corner>& corners = space.levels[bands[i].level];
        if (bands[i].rows.start > regions[bands[i].level].y)
            corners.insert(corners.end(), space.bands[i].begin(), space.bands[i].end());
    }
    return space.levels;
}

}  // namespace aqorb
}  // namespace cv
