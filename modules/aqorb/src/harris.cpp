// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

float harrisResponse(const Mat& image, int x, int y)
{
    const int BLOCK = 5, RADIUS = BLOCK / 2;
    const float K = 0.04f;
    const float scale = 1.f / ((1 << 2) * BLOCK * 255.f);

    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, RADIUS + 1, buffer);
    const ptrdiff_t step = patch.step;
    int a = 0, b = 0, c = 0;
    for (int dy = -RADIUS; dy <= RADIUS; dy++)
    {
        for (int dx = -RADIUS; dx <= RADIUS; dx++)
        {
            const uchar* p = patch.center + dy * step + dx;
            const int Ix = (p[1] - p[-1]) * 2 + (p[-step + 1] - p[-step - 1]) + (p[step + 1] - p[step - 1]);
            const int Iy = (p[step] - p[-step]) * 2 + (p[step - 1] - p[-step - 1]) + (p[step + 1] - p[-step + 1]);
            a += Ix * Ix;
            b += Iy * Iy;
            c += Ix * Iy;
        }
    }
    // operation by operation as in cv::ORB
    return (float(a) * b - float(c) * c - K * (float(a) + b) * (float(a) + b)) *
           (scale * scale * scale * scale);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
