// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "corners.simd.hpp"
#include "corners.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

// The square mesh over a region: which of its cells hold a corner at iniT.
class Mesh
{
public:
    Mesh(const Rect& region_, int cellSize, std::vector<uchar>& full_)
        : region(region_),
          side(std::min(cellSize, std::max(std::max(region.width, region.height), 1))),
          inverseSide(1.f / side),
          columns((region.width + side - 1) / side),
          rows((region.height + side - 1) / side),
          full(full_)
    {
        full.assign(size_t(columns) * rows, uchar(0));
    }
    int rowCount() const { return rows; }
    void fill(const Corner& corner) { full[index(corner)] = 1; }
    bool isFull(const Corner& corner) const { return full[index(corner)] != 0; }
    Range rowsOf(int row) const
    {
        const int first = region.y + row * side;
        return Range(first, first + std::min(side, region.y + region.height - first));
    }
    // The runs of empty cells side by side, as columns of the level.
    void emptyRuns(int row, std::vector<Range>& runs) const
    {
        runs.clear();
        const uchar* cells = full.data() + size_t(row) * columns;
        for (int column = 0; column < columns; column++)
        {
            if (cells[column])
                continue;
            const int first = column;
            while (column < columns && !cells[column])
                column++;
            const int end = column < columns ? column * side : region.width;
            runs.push_back(Range(region.x + first * side, region.x + end));
        }
    }

private:
    // Exact, as level sides are below 2^20: a half is further from the next cell than roundings reach.
    int cell(int offset) const { return int((offset + 0.5f) * inverseSide); }
    size_t index(const Corner& corner) const
    {
        return size_t(cell(corner.y - region.y)) * columns + cell(corner.x - region.x);
    }

    Rect region;
    int side;
    float inverseSide;
    int columns, rows;
    std::vector<uchar>& full;
};

static void dropMasked(const Mat& mask, size_t first, std::vector<Corner>& corners)
{
    if (mask.empty())
        return;
    size_t kept = first;
    for (size_t i = first; i < corners.size(); i++)
    {
        if (mask.at<uchar>(corners[i].y, corners[i].x))
            corners[kept++] = corners[i];
    }
    corners.resize(kept);
}

static void suppressedOf(const uchar* scores, ptrdiff_t step, const std::vector<Corner>& corners,
                         uchar* falls)
{
    CV_CPU_DISPATCH(findSuppressed, (scores, step, corners.data(), int(corners.size()), falls),
                    CV_CPU_DISPATCH_MODES_ALL);
}

void suppressCorners(Size size, LevelCorners& corners, CornerScratch& scratch)
{
    CV_TRACE_FUNCTION();
    const int MARGIN = 16;  // the kernel reads vectors
    const size_t step = size_t(size.width) + 2 * MARGIN, count = step * (size.height + 2 * MARGIN);
    if (scratch.scores.size() < count)
        scratch.scores.resize(count, uchar(0));
    // Nothing may throw while scores are set.
    scratch.falls.resize(corners.kept.size());
    corners.suppressed.resize(corners.kept.size());
    uchar* scores = scratch.scores.data() + MARGIN * step + MARGIN;
    for (size_t i = 0; i < corners.kept.size(); i++)
    {
        const Corner& corner = corners.kept[i];  // scores are 1 to 254, so 0 means no corner
        scores[corner.y * step + corner.x] = uchar(corner.score);
    }
    suppressedOf(scores, ptrdiff_t(step), corners.kept, scratch.falls.data());
    // Each corner is written to both, as which of them keeps it is hard to predict.
    size_t kept = 0, suppressed = 0;
    for (size_t i = 0; i < scratch.falls.size(); i++)
    {
        const Corner corner = corners.kept[i];
        scores[corner.y * step + corner.x] = 0;
        const int falls = scratch.falls[i];
        corners.suppressed[suppressed] = corners.kept[kept] = corner;
        suppressed += falls;
        kept += 1 - falls;
    }
    corners.kept.resize(kept);
    corners.suppressed.resize(suppressed);
}

Range cornerBand(const Rect& region, int cellSize, int index)
{
    const int ROWS = 64;  // enough for a thread to be worth its while
    const int64 rows = (ROWS + int64(cellSize) - 1) / cellSize * cellSize,
                end = region.y + int64(region.height);
    return Range(int(std::min(region.y + index * rows, end)),
                 int(std::min(region.y + (index + 1) * rows, end)));
}

void findBandCorners(const Level& level, const Rect& band, Thresholds thresholds, int cellSize,
                     std::vector<Corner>& corners, CornerScratch& scratch)
{
    CV_TRACE_FUNCTION();
    corners.clear();
    detectCorners(level.image, band, thresholds, corners, scratch.fast);
    dropMasked(level.mask, 0, corners);
    if (thresholds.min >= thresholds.ini)
        return;
    CV_TRACE_REGION("empty cells");
    Mesh mesh(band, cellSize, scratch.fullCells);
    const size_t first = corners.size();
    for (size_t i = 0; i < first; i++)
        mesh.fill(corners[i]);
    for (int row = 0; row < mesh.rowCount(); row++)
    {
        mesh.emptyRuns(row, scratch.columns);
        takeWeakCorners(mesh.rowsOf(row), scratch.columns, corners, scratch.fast);
    }
    dropMasked(level.mask, first, corners);
}

void findCorners(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                 bool suppressNear, LevelCorners& corners, CornerScratch& scratch)
{
    corners.kept.clear();
    corners.suppressed.clear();
    std::vector<Corner> found;
    for (int i = 0;; i++)
    {
        const Range rows = cornerBand(region, cellSize, i);
        if (rows.start >= rows.end)
            break;
        findBandCorners(level, Rect(region.x, rows.start, region.width, rows.size()), thresholds, cellSize,
                        found, scratch);
        corners.kept.insert(corners.kept.end(), found.begin(), found.end());
    }
    if (suppressNear)
        suppressCorners(level.image.size(), corners, scratch);
}

void findCellRejects(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                     std::vector<Corner>& corners)
{
    CV_TRACE_FUNCTION();
    corners.clear();
    if (thresholds.min >= thresholds.ini)
        return;
    detectCorners(level.image, region, thresholds.min, corners);
    dropMasked(level.mask, 0, corners);
    std::vector<uchar> fullCells;
    Mesh mesh(region, cellSize, fullCells);
    for (size_t i = 0; i < corners.size(); i++)
    {
        if (corners[i].score >= thresholds.ini)
            mesh.fill(corners[i]);
    }
    size_t rejects = 0;
    for (size_t i = 0; i < corners.size(); i++)
    {
        if (corners[i].score < thresholds.ini && mesh.isFull(corners[i]))
            corners[rejects++] = corners[i];
    }
    corners.resize(rejects);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
