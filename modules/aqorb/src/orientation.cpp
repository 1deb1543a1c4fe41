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

std::vector<int> circularPatch(int patchSize)
{
    // cv::ORB's circle: the upper octant by rounding, the rest mirrored so that the patch is symmetric
    const int radius = patchSize / 2;
    const int vmax = cvFloor(radius * std::sqrt(2.f) / 2 + 1);
    const int vmin = cvCeil(radius * std::sqrt(2.f) / 2);
    std::vector<int> halfWidths(radius + 2);
    for (int v = 0; v <= vmax; v++)
        halfWidths[v] = cvRound(std::sqrt(double(radius) * radius - double(v) * v));
    for (int v = radius, v0 = 0; v >= vmin; v--)
    {
        while (halfWidths[v0] == halfWidths[v0 + 1])
            v0++;
        halfWidths[v] = v0;
        v0++;
    }
    halfWidths.resize(radius + 1);
    halfWidths[0] = radius;  // the centre row is summed over the whole width
    return halfWidths;
}

float orientation(const Mat& image, int x, int y, const std::vector<int>& halfWidths)
{
    const int radius = int(halfWidths.size()) - 1;
    PatchBuffer buffer;
    const Patch patch = patchAround(image, x, y, radius, buffer);

    // unsigned: the moments of very large patches wrap around, as cv::ORB's do
    unsigned m01 = 0, m10 = 0;
    for (int v = -radius; v <= radius; v++)
    {
        const uchar* row = patch.center + v * patch.step;
        const int halfWidth = halfWidths[std::abs(v)];
        unsigned sum = 0;
        for (int u = -halfWidth; u <= halfWidth; u++)
        {
            sum += row[u];
            m10 += unsigned(u) * row[u];
        }
        m01 += unsigned(v) * sum;
    }
    return fastAtan2(float(int(m01)), float(int(m10)));
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
