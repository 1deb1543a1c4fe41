// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "kernels.hpp"
#include "simd_compat.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

/** Which corners fall to a better one within SUPPRESS_RADIUS: of a higher score, or as high and before
 it in raster order.
 @param scores the plane of the corners' scores, 0 elsewhere; 16 pixels around each must be readable
 @param falls 1 or 0 for each corner */
void findSuppressed(const uchar* scores, ptrdiff_t step, const Corner* corners, int count, uchar* falls);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

void findSuppressed(const uchar* scores, ptrdiff_t step, const Corner* corners, int count, uchar* falls)
{
    const int RADIUS = SUPPRESS_RADIUS;
    for (int i = 0; i < count; i++)
    {
        const uchar* p = scores + corners[i].y * step + corners[i].x;
        const uchar* q = p - RADIUS;
        // The highest scores of the pixels that come before it in raster order, and after.
#if CV_SIMD128
        const v_uint8x16 above = v_max(v_max(v_load(q - 3 * step), v_load(q - 2 * step)), v_load(q - step));
        const v_uint8x16 below = v_max(v_max(v_load(q + 3 * step), v_load(q + 2 * step)), v_load(q + step));
        const v_uint8x16 row = v_load(q);
        const v_uint8x16 window(255, 255, 255, 255, 255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        const v_uint8x16 left(255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        const v_uint8x16 right(0, 0, 0, 0, 255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0);
        const v_uint8x16 before = v_max(v_and(above, window), v_and(row, left));
        const v_uint8x16 after = v_max(v_and(below, window), v_and(row, right));
        const v_uint8x16 score = v_setall_u8(*p);
        falls[i] = v_check_any(v_or(v_ge(before, score), v_gt(after, score)));
#else
        int before = 0, after = 0;
        for (int y = 0; y <= 2 * RADIUS; y++)
        {
            for (int x = 0; x <= 2 * RADIUS; x++)
            {
                const int score = q[(y - RADIUS) * step + x];
                if (y < RADIUS || (y == RADIUS && x < RADIUS))
                    before = score > before ? score : before;
                else if (y > RADIUS || x > RADIUS)
                    after = score > after ? score : after;
            }
        }
        falls[i] = before >= *p || after > *p;
#endif
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
