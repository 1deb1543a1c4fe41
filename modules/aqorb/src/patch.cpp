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

Patch patchAround(const Mat& image, int x, int y, int radius, PatchBuffer& buffer)
{
    if (x >= radius && y >= radius && x < image.cols - radius && y < image.rows - radius)
    {
        const Patch patch = {image.ptr(y) + x, ptrdiff_t(image.step)};
        return patch;
    }
    const int side = 2 * radius + 1;
    buffer.allocate(size_t(side) * side);
    for (int row = 0; row < side; row++)
    {
        const uchar* source = image.ptr(borderInterpolate(y - radius + row, image.rows, BORDER_REFLECT_101));
        uchar* out = buffer.data() + size_t(row) * side;
        for (int column = 0; column < side; column++)
            out[column] = source[borderInterpolate(x - radius + column, image.cols, BORDER_REFLECT_101)];
    }
    const Patch patch = {buffer.data() + size_t(radius) * side + radius, side};
    return patch;
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
