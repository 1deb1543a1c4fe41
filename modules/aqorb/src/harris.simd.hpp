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

//! harrisResponse at p. Readable must be 3 pixels around and 6 to the right.
float harrisAt(const uchar* p, ptrdiff_t step);

//! harrisResponse of corners; readable as for harrisAt.
void harrisOfCorners(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                     RankedCorner* ranked);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

// The sums over the 5x5 block of the products of the Sobel derivatives, as whole numbers.
static CV_ALWAYS_INLINE void sumDerivatives(const uchar* p, ptrdiff_t step, int& xx, int& yy, int& xy)
{
#if CV_SIMD128
    // A row of the window of 7 x 7 pixels that the block is made of, in lanes 0 to 4: the horizontal
    // difference and the horizontal smoothing.
    struct Row
    {
        v_int16x8 difference, smooth;
        CV_ALWAYS_INLINE explicit Row(const uchar* q)
        {
            const v_int16x8 left = v_reinterpret_as_s16(v_load_expand(q));
            const v_int16x8 middle = v_reinterpret_as_s16(v_load_expand(q + 1));
            const v_int16x8 right = v_reinterpret_as_s16(v_load_expand(q + 2));
            difference = v_sub(right, left);
            smooth = v_add(v_add(left, right), v_add(middle, middle));
        }
    };
    const uchar* q = p - 3 * step - 3;
    const v_int16x8 inBlock(-1, -1, -1, -1, -1, 0, 0, 0);
    v_int32x4 sumXX = v_setzero_s32(), sumYY = v_setzero_s32(), sumXY = v_setzero_s32();
    Row above(q), row(q + step);
    for (int i = 2; i < 7; i++)
    {
        const Row below(q + i * step);
        const v_int16x8 Ix = v_and(
            v_add(v_add(above.difference, below.difference), v_add(row.difference, row.difference)), inBlock);
        const v_int16x8 Iy = v_and(v_sub(below.smooth, above.smooth), inBlock);
        sumXX = v_add(sumXX, v_dotprod(Ix, Ix));
        sumYY = v_add(sumYY, v_dotprod(Iy, Iy));
        sumXY = v_add(sumXY, v_dotprod(Ix, Iy));
        above = row;
        row = below;
    }
    xx = v_reduce_sum(sumXX);
    yy = v_reduce_sum(sumYY);
    xy = v_reduce_sum(sumXY);
#else
    xx = yy = xy = 0;
    for (int dy = -2; dy <= 2; dy++)
    {
        for (int dx = -2; dx <= 2; dx++)
        {
            const uchar* q = p + dy * step + dx;
            const int Ix = (q[1] - q[-1]) * 2 + (q[-step + 1] - q[-step - 1]) + (q[step + 1] - q[step - 1]);
            const int Iy =
                (q[step] - q[-step]) * 2 + (q[step - 1] - q[-step - 1]) + (q[step + 1] - q[-step + 1]);
            xx += Ix * Ix;
            yy += Iy * Iy;
            xy += Ix * Iy;
        }
    }
#endif
}

static CV_ALWAYS_INLINE float responseOf(int a, int b, int c)
{
    const float K = 0.04f, SCALE = 1.f / ((1 << 2) * 5 * 255.f);
    // operation by operation as in cv::ORB
    return (float(a) * b - float(c) * c - K * (float(a) + b) * (float(a) + b)) *
           (SCALE * SCALE * SCALE * SCALE);
}

float harrisAt(const uchar* p, ptrdiff_t step)
{
    int a, b, c;
    sumDerivatives(p, step, a, b, c);
    return responseOf(a, b, c);
}

#if CV_AVX2
// sumDerivatives of two corners, one in each half of the vectors.
static CV_ALWAYS_INLINE void sumDerivativesOfTwo(const uchar* p0, const uchar* p1, ptrdiff_t step,
                                                 int sums[6])
{
    struct Row
    {
        __m256i difference, smooth;
        CV_ALWAYS_INLINE Row(const uchar* a, const uchar* b)
        {
            // Eight bytes of each: shifted by two, the seven that the window has are still there.
            const __m128i both = _mm_unpacklo_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(a)),
                                                    _mm_loadl_epi64(reinterpret_cast<const __m128i*>(b)));
            const __m256i left = _mm256_cvtepu8_epi16(both);
            const __m256i middle = _mm256_cvtepu8_epi16(_mm_srli_epi64(both, 8));
            const __m256i right = _mm256_cvtepu8_epi16(_mm_srli_epi64(both, 16));
            difference = _mm256_sub_epi16(right, left);
            smooth = _mm256_add_epi16(_mm256_add_epi16(left, right), _mm256_add_epi16(middle, middle));
        }
    };
    const uchar *a = p0 - 3 * step - 3, *b = p1 - 3 * step - 3;
    const __m256i inBlock = _mm256_setr_epi16(-1, -1, -1, -1, -1, 0, 0, 0, -1, -1, -1, -1, -1, 0, 0, 0);
    __m256i xx = _mm256_setzero_si256(), yy = xx, xy = xx;
    Row above(a, b), row(a + step, b + step);
    for (int i = 2; i < 7; i++)
    {
        const Row below(a + i * step, b + i * step);
        const __m256i twice = _mm256_add_epi16(row.difference, row.difference);
        const __m256i Ix = _mm256_and_si256(
            _mm256_add_epi16(_mm256_add_epi16(above.difference, below.difference), twice), inBlock);
        const __m256i Iy = _mm256_and_si256(_mm256_sub_epi16(below.smooth, above.smooth), inBlock);
        xx = _mm256_add_epi32(xx, _mm256_madd_epi16(Ix, Ix));
        yy = _mm256_add_epi32(yy, _mm256_madd_epi16(Iy, Iy));
        xy = _mm256_add_epi32(xy, _mm256_madd_epi16(Ix, Iy));
        above = row;
        row = below;
    }
    // xx, yy, xy, xy of both corners
    const __m256i total = _mm256_hadd_epi32(_mm256_hadd_epi32(xx, yy), _mm256_hadd_epi32(xy, xy));
    int all[8];
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(all), total);
    for (int i = 0; i < 3; i++)
    {
        sums[i] = all[i];
        sums[3 + i] = all[4 + i];
    }
}
#endif

void harrisOfCorners(const uchar* image, ptrdiff_t step, const Corner* corners, int count,
                     RankedCorner* ranked)
{
    int i = 0;
#if CV_AVX2
    for (; i + 2 <= count; i += 2)
    {
        int sums[6];
        sumDerivativesOfTwo(image + corners[i].y * step + corners[i].x,
                            image + corners[i + 1].y * step + corners[i + 1].x, step, sums);
        for (int j = 0; j < 2; j++)
        {
            ranked[i + j].x = corners[i + j].x;
            ranked[i + j].y = corners[i + j].y;
            ranked[i + j].response = responseOf(sums[3 * j], sums[3 * j + 1], sums[3 * j + 2]);
        }
    }
#endif
    for (; i < count; i++)
    {
        ranked[i].x = corners[i].x;
        ranked[i].y = corners[i].y;
        ranked[i].response = harrisAt(image + corners[i].y * step + corners[i].x, step);
    }
}

#endif  // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace stages
}  // namespace aqorb
}  // namespace cv
