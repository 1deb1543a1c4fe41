// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "kernels.hpp"
#include "simd_compat.hpp"

#include <cmath>

namespace cv
{
namespace aqorb
{
namespace stages
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

//! exactBlur at p, whose pixels 3 around must be readable; taps of the centre and 1, 2, 3 off it.
uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps);

//! Row pass of approximateBlur; row[-3 .. width + 3) must be readable.
void blurRow(const uchar* row, int width, const ushort* taps, ushort* out);

//! Column pass of approximateBlur of the seven rows around the output's.
void blurColumn(const ushort* const* rows, int width, const ushort* taps, ushort* out);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

uchar exactBlurAt(const uchar* p, ptrdiff_t step, const float* taps)
{
    float rows[7];
    for (int i = 0; i < 7; i++)
    {
        const uchar* q = p + (i - 3) * step;
        float sum = taps[3] * q[-3];
        sum = std::fma(taps[2], float(q[-2]), sum);
        sum = std::fma(taps[1], float(q[-1]), sum);
        sum = std::fma(taps[0], float(q[0]), sum);
        sum = std::fma(taps[1], float(q[1]), sum);
        sum = std::fma(taps[2], float(q[2]), sum);
        rows[i] = std::fma(taps[3], float(q[3]), sum);
    }
    float sum = taps[0] * rows[3];
    sum = std::fma(rows[4] + rows[2], taps[1], sum);
    sum = std::fma(rows[5] + rows[1], taps[2], sum);
    sum = std::fma(rows[6] + rows[0], taps[3], sum);
    return uchar(cvRound(sum));  // the taps add up to 1, so there is nothing to saturate
}

namespace
{

CV_ALWAYS_INLINE unsigned upperHalf(unsigned a, unsigned b)
{
    return (a * b) >> 16;
}

#if CV_SIMD
CV_ALWAYS_INLINE v_uint16 average(const v_uint16& a, const v_uint16& b)  // rounds up
{
#if CV_AVX512_SKX && CV_SIMD_WIDTH == 64
    return v_uint16(_mm512_avg_epu16(a.val, b.val));
#elif CV_AVX2 && CV_SIMD_WIDTH == 32
    return v_uint16(_mm256_avg_epu16(a.val, b.val));
#elif CV_SSE2 && CV_SIMD_WIDTH == 16
    return v_uint16(_mm_avg_epu16(a.val, b.val));
#elif CV_NEON && CV_SIMD_WIDTH == 16
    return v_uint16(vrhaddq_u16(a.val, b.val));
#else
    return v_sub(v_or(a, b), v_shr<1>(v_xor(a, b)));
#endif
}
#endif

}  // namespace

void blurRow(const uchar* row, int width, const ushort* taps, ushort* out)
{
    int x = 0;
#if CV_SIMD
    const int LANES = AQORB_LANES(v_uint16);
    const v_uint16 t0 = vx_setall_u16(taps[0]), t1 = vx_setall_u16(taps[1]), t2 = vx_setall_u16(taps[2]),
                   t3 = vx_setall_u16(taps[3]), center = vx_setall_u16(2);
    while (width >= LANES && x < width)
    {
        const uchar* p = row + x;
        const v_uint16 c = v_shl<8>(vx_load_expand(p));
        const v_uint16 s1 = v_shl<6>(v_add(vx_load_expand(p - 1), vx_load_expand(p + 1)));
        const v_uint16 s2 = v_shl<6>(v_add(vx_load_expand(p - 2), vx_load_expand(p + 2)));
        const v_uint16 s3 = v_shl<6>(v_add(vx_load_expand(p - 3), vx_load_expand(p + 3)));
        const v_uint16 inner = v_add(v_mul_hi(c, t0), v_mul_hi(s1, t1));
        const v_uint16 outer = v_add(v_mul_hi(s2, t2), v_mul_hi(s3, t3));
        v_store(out + x, v_add(v_add(inner, outer), center));
        x = x + LANES == width       ? width
            : x + 2 * LANES <= width ? x + LANES
                                     : width - LANES;  // the last one overlaps
    }
#endif
    for (; x < width; x++)
    {
        const uchar* p = row + x;
        out[x] =
            ushort(upperHalf(p[0] << 8, taps[0]) + upperHalf((p[1] + p[-1]) << 6, taps[1]) +
                   upperHalf((p[2] + p[-2]) << 6, taps[2]) + upperHalf((p[3] + p[-3]) << 6, taps[3]) + 2);
    }
}

void blurColumn(const ushort* const* rows, int width, const ushort* taps, ushort* out)
{
    int x = 0;
#if CV_SIMD
    const int LANES = AQORB_LANES(v_uint16);
    const v_uint16 t0 = vx_setall_u16(taps[0]), t1 = vx_setall_u16(taps[1]), t2 = vx_setall_u16(taps[2]),
                   t3 = vx_setall_u16(taps[3]), center = vx_setall_u16(2);
    const ushort *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3], *r4 = rows[4], *r5 = rows[5],
                 *r6 = rows[6];
    while (width >= LANES && x < width)
    {
        const v_uint16 a1 = average(vx_load(r4 + x), vx_load(r2 + x));
        const v_uint16 a2 = average(vx_load(r5 + x), vx_load(r1 + x));
        const v_uint16 a3 = average(vx_load(r6 + x), vx_load(r0 + x));
        const v_uint16 inner = v_add(v_mul_hi(vx_load(r3 + x), t0), v_mul_hi(a1, t1));
        const v_uint16 outer = v_add(v_mul_hi(a2, t2), v_mul_hi(a3, t3));
        v_store(out + x, v_add(v_add(inner, outer), center));
        x = x + LANES == width ? width : x + 2 * LANES <= width ? x + LANES : width - LANES;
    }
#endif
    for (; x < width; x++)
    {
        const unsigned a1 = (rows[4][x] + rows[2][x] + 1u) >> 1, a2 = (rows[5][x] + rows[1][x] + 1u) >> 1,
                       a3 = (rows[6][x] + rows[0][x] + 1u) >> 1;
        out[x] = ushort(upperHalf(rows[3][x], taps[0]) + upperHalf(a1, taps[1]) + upperHalf(a2, taps[2]) +
                        upperHalf(a3, taps[3]) + 2);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
