// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Searches bands of all levels in parallel, by the mesh of cells and with non-maximum suppression.

#include "precomp.hpp"

#include "detector/corners.hpp"
#include "common/for_each.hpp"

namespace cv
{
namespace aqorb
{

template <typename C> static void eraseOutside(const Range& rows, std::vector<C>& corners)
{
    const auto isOutside = [&](const C& corner) { return corner.y < rows.start || corner.y >= rows.end; };
    corners.erase(std::remove_if(corners.begin(), corners.end(), isOutside), corners.end());
}

void searchBand(const Level& level, const Rect& region, const Range& rows, const CornerRules& rules,
                FastScanner& scanner, CornerLists& found)
{
    CV_TRACE_FUNCTION();
    found.chosen.clear();
    found.all.clear();
    // Suppression depends on corners in the next rows, and these depend on their cells.
    const int above = rules.suppressNear ? std::min(CELL_SIZE, rows.start - region.y) : 0;
    const int below = rules.suppressNear ? std::min(CELL_SIZE, region.br().y - rows.end) : 0;
    const Rect band(region.x, rows.start - above, region.width, rows.size() + above + below);
    const Rect scanned = fastRegion(level.image.size(), band);
    if (scanned.empty())
        return;
    std::vector<Range> cells;  // of a row
    for (int x = band.x; x < band.br().x; x += CELL_SIZE)
        cells.push_back(Range(x, std::min(x + CELL_SIZE, band.br().x)));
    scanner.begin(level, scanned, rules.thresholds, CELL_SIZE);
    for (int y = band.y; y < scanned.br().y; y += CELL_SIZE)
    {
        scanner.scan(y + CELL_SIZE, cells, *rules.room, found.all);
        scanner.append(rules.suppressNear, found.chosen);
    }
    if (above + below > 0)
    {
        eraseOutside(rows, found.chosen);
        eraseOutside(rows, found.all);
    }
}

std::vector<Band> divideIntoBands(const std::vector<Rect>& regions, int threads)
{
    double pixels = 0;
    for (const Rect& region : regions)
        pixels += double(region.width) * region.height;
    std::vector<Band> bands;
    for (size_t i = 0; i < regions.size(); i++)
    {
        // Neighbouring bands both search the cells at their border, so there are only as many bands as threads need.
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

void findCorners(const std::vector<Level>& levels, const std::vector<Rect>& regions, const CornerRules& rules,
                 int threads, CornerSpace& space)
{
    CV_TRACE_FUNCTION();
    const std::vector<Band> bands = divideIntoBands(regions, threads);
    space.scanners.resize(std::max(space.scanners.size(), size_t(threads)));
    space.bands.resize(std::max(space.bands.size(), bands.size()));
    space.levels.resize(levels.size());
    forEach(bands.size(), threads,
            [&](size_t i, int thread)
            {
                const int level = bands[i].level;
                const bool isFirst = bands[i].rows.start == regions[level].y;
                searchBand(levels[level], regions[level], bands[i].rows, rules, space.scanners[thread],
                           isFirst ? space.levels[level] : space.bands[i]);
            });
    for (size_t i = 0; i < bands.size(); i++)
    {
        if (bands[i].rows.start == regions[bands[i].level].y)
            continue;
        CornerLists& level = space.levels[bands[i].level];
        const CornerLists& band = space.bands[i];
        level.chosen.insert(level.chosen.end(), band.chosen.begin(), band.chosen.end());
        level.all.insert(level.all.end(), band.all.begin(), band.all.end());
    }
}

}  // namespace aqorb
}  // namespace cv
