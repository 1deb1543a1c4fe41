// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include <opencv2/features2d.hpp>

namespace cv
{
namespace aqorb
{
namespace stages
{

void detectCorners(const Mat& image, const Rect& region, int threshold, std::vector<Corner>& corners)
{
    // Suppression looks one pixel beyond the region, the circle three pixels beyond that.
    const int MARGIN = 4;
    const Rect reach(region.x - MARGIN, region.y - MARGIN, region.width + 2 * MARGIN, region.height + 2 * MARGIN);
    const Rect window = reach & Rect(Point(), image.size());
    std::vector<KeyPoint> keypoints;
    FAST(image(window), keypoints, threshold, true);
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point p = Point(keypoints[i].pt) + window.tl();
        if (region.contains(p))
        {
            const Corner corner = {p.x, p.y, cvRound(keypoints[i].response)};
            corners.push_back(corner);
        }
    }
}

int cornerScore(const uchar* p, size_t pixelStep)
{
    const int CIRCLE = 16, ARC = 9;
    const ptrdiff_t step = ptrdiff_t(pixelStep);
    const ptrdiff_t offsets[CIRCLE] = {3 * step,      3 * step + 1,  2 * step + 2,  step + 3,
                                       3,             -step + 3,     -2 * step + 2, -3 * step + 1,
                                       -3 * step,     -3 * step - 1, -2 * step - 2, -step - 3,
                                       -3,            step - 3,      2 * step - 2,  3 * step - 1};
    int score = -255;
    for (int first = 0; first < CIRCLE; first++)
    {
        int darkest = 255, brightest = 0;
        for (int i = first; i < first + ARC; i++)
        {
            darkest = std::min(darkest, int(p[offsets[i % CIRCLE]]));
            brightest = std::max(brightest, int(p[offsets[i % CIRCLE]]));
        }
        score = std::max(score, std::max(darkest - p[0], p[0] - brightest));
    }
    return score;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
