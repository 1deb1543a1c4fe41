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
    Mesh(const Rect& region_, int cellSize)
        : region(region_),
          side(std::min(cellSize, std::max(std::max(region.width, region.height), 1))),
          columns((region.width + side - 1) / side),
          rows((region.height + side - 1) / side),
          full(size_t(columns) * rows, uchar(0))
    {
    }
    void fill(const Corner& corner) { full[index(corner)] = 1; }
    bool isFull(const Corner& corner) const { return full[index(corner)] != 0; }
    // The runs of empty cells side by side, as rectangles of the level.
    void emptyRuns(std::vector<Rect>& runs) const
    {
        for (int row = 0; row < rows; row++)
        {
            const uchar* cells = &full[size_t(row) * columns];
            for (int column = 0; column < columns; column++)
            {
                if (cells[column])
                    continue;
                const int first = column;
                while (column < columns && !cells[column])
                    column++;
                runs.push_back(region & Rect(region.x + first * side, region.y + row * side,
                                             (column - first) * side, side));
            }
        }
    }

private:
    size_t index(const Corner& corner) const
    {
        return size_t((corner.y - region.y) / side) * columns + (corner.x - region.x) / side;
    }

    Rect region;
    int side, columns, rows;
    std::vector<uchar> full;
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

// Moves the corners that fall to a better one nearby, even if that falls itself, to `suppressed`.
static void suppress(Size size, LevelCorners& corners, CornerScratch& scratch)
{
    const int MARGIN = 16;  // the kernel reads vectors
    const size_t step = size_t(size.width) + 2 * MARGIN, count = step * (size.height + 2 * MARGIN);
    if (scratch.scores.size() < count)
        scratch.scores.resize(count, uchar(0));
    // Nothing may throw while scores are set.
    scratch.falls.resize(corners.kept.size());
    corners.suppressed.reserve(corners.kept.size());
    uchar* scores = scratch.scores.data() + MARGIN * step + MARGIN;
    for (size_t i = 0; i < corners.kept.size(); i++)
    {
        const Corner& corner = corners.kept[i];  // scores are 1 to 254, so 0 means no corner
        scores[corner.y * step + corner.x] = uchar(corner.score);
    }
    suppressedOf(scores, ptrdiff_t(step), corners.kept, scratch.falls.data());
    size_t kept = 0;
    for (size_t i = 0; i < scratch.falls.size(); i++)
    {
        const Corner corner = corners.kept[i];
        scores[corner.y * step + corner.x] = 0;
        if (scratch.falls[i])
            corners.suppressed.push_back(corner);
        else
            corners.kept[kept++] = corner;
    }
    corners.kept.resize(kept);
}

void findCorners(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                 bool suppressNear, LevelCorners& corners, CornerScratch& scratch)
{
    CV_TRACE_FUNCTION();
    corners.kept.clear();
    corners.suppressed.clear();

    detectCorners(level.image, region, thresholds.ini, corners.kept);
    dropMasked(level.mask, 0, corners.kept);
    if (thresholds.min < thresholds.ini)
    {
        Mesh mesh(region, cellSize);
        for (size_t i = 0; i < corners.kept.size(); i++)
            mesh.fill(corners.kept[i]);
        std::vector<Rect> runs;
        mesh.emptyRuns(runs);
        const size_t first = corners.kept.size();
        for (size_t i = 0; i < runs.size(); i++)
            detectCorners(level.image, runs[i], thresholds.min, corners.kept);
        dropMasked(level.mask, first, corners.kept);
    }
    if (suppressNear)
        suppress(level.image.size(), corners, scratch);
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
    Mesh mesh(region, cellSize);
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
