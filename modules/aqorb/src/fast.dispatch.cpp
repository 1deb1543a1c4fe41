// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "fast.simd.hpp"
#include "fast.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

static int continueFastScan(FastScan& scan, Corner* corners, int capacity)
{
    CV_CPU_DISPATCH(continueScan, (scan, corners, capacity), CV_CPU_DISPATCH_MODES_ALL);
}

void detectCorners(const Mat& image, const Rect& region, int threshold, std::vector<Corner>& corners)
{
    const int RADIUS = 3;  // of the circle
    const Rect hasCircle(RADIUS, RADIUS, image.cols - 2 * RADIUS, image.rows - 2 * RADIUS);
    const Rect wanted = region & hasCircle;
    if (wanted.empty())
        return;
    // Corners are suppressed by those just outside the region, too.
    const Rect scored = Rect(wanted.x - 1, wanted.y - 1, wanted.width + 2, wanted.height + 2) & hasCircle;

    FastScan scan;
    scan.image = image.ptr();
    scan.step = ptrdiff_t(image.step);
    scan.threshold = std::min(std::max(threshold, 1), 255);  // as suppression needs scores > 0
    scan.left = scored.x;
    scan.top = scored.y;
    scan.width = scored.width;
    scan.bottom = scored.y + scored.height;
    scan.regionLeft = wanted.x;
    scan.regionRight = wanted.x + wanted.width;
    scan.regionTop = wanted.y;
    scan.regionBottom = wanted.y + wanted.height;
    scan.y = scored.y;
    const size_t rowBytes = size_t(scan.width) + 2 * SCAN_MARGIN, rowBlocks = size_t(scan.width) / 8 + 2;
    AutoBuffer<uchar> scores(3 * rowBytes);
    AutoBuffer<int> blocks(3 * rowBlocks);
    std::fill(scores.data(), scores.data() + 3 * rowBytes, uchar(0));
    for (int i = 0; i < 3; i++)
    {
        scan.scores[i] = scores.data() + i * rowBytes;
        scan.blocks[i] = blocks.data() + i * rowBlocks;
        scan.count[i] = 0;
    }

    while (scan.y <= scan.bottom)
    {
        const size_t before = corners.size();
        const int capacity = 4 * (scan.width / 2 + 1);
        corners.resize(before + capacity);
        const int found = continueFastScan(scan, &corners[before], capacity);
        corners.resize(before + found);
    }
}

int cornerScore(const uchar* p, size_t pixelStep)
{
    return cpu_baseline::scoreOfPixel(p, ptrdiff_t(pixelStep));
}

static void neighborCornerScores(const uchar* p, ptrdiff_t step, int scores[3][3])
{
    CV_CPU_DISPATCH(neighborScores, (p, step, scores), CV_CPU_DISPATCH_MODES_ALL);
}

void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3])
{
    const int RADIUS = 4, LANES = 16;  // vectors read on to the right
    if (x >= RADIUS && y >= RADIUS && x + LANES + RADIUS < image.cols && y + RADIUS < image.rows)
    {
        neighborCornerScores(image.ptr(y) + x, ptrdiff_t(image.step), scores);
        return;
    }
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, RADIUS, buffer);
    for (int dy = -1; dy <= 1; dy++)
    {
        for (int dx = -1; dx <= 1; dx++)
            scores[dy + 1][dx + 1] = cornerScore(patch.center + dy * patch.step + dx, size_t(patch.step));
    }
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
