// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_HAMMING_DISTANCE_HPP
#define OPENCV_AQORB_HAMMING_DISTANCE_HPP

// How descriptors are packed and bits are counted on each kind of CPU, for the kernels in hamming.simd.hpp.

#include "hamming.hpp"
#include "simd_compat.hpp"

#include <cstring>

namespace cv
{
namespace aqorb
{
CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

#if CV_SIMD && (CV_SSE2 || CV_NEON)

namespace
{

#if CV_AVX_512BITALG

//! Makes the keys of distances with a number, which one instruction shifts in from the highest bit on.
struct KeyMaker
{
    explicit KeyMaker(int indexBits) : shift(vx_setall_u16(ushort(indexBits))), one(1 << (16 - indexBits)) {}
    v_uint16 keys(const v_uint16& distances, const v_uint16& numbers) const
    {
        return v_uint16(_mm512_shldv_epi16(distances.val, numbers.val, shift.val));
    }
    const v_uint16 shift;
    const int one;  //!< the step from a number to the next
};

/** Packs queries and trains into planes of 16-bit words: a vector has the same word of each descriptor of a block. A
 query has each word twice, because the CPU spreads 32 bits over a vector while it loads them.

 The bits of three differences are added like digits: their xor, and with twice the weight their majority. That leaves
 two vectors to count instead of three. The xor of differences is the difference of xors. It is packed in place of the third
 word, and so costs nothing. A group of 16 words, w0 to w15, is packed as w0, w1, w0^w1^w2, w3, w0^...^w4, and so on to
 w0^...^w14, and w15. */
template <bool> struct Packing
{
    enum
    {
        QUERY_PLANES = 2,
        TRAIN_PLANES = 1,
        IN_REGISTERS = 1,  // a block of known size fits there
        GROUP = 16
    };

    static int block() { return 32; }

    //! The 64-bit words of a group that begins before so many bytes.
    static int wordsOf(int bytes) { return bytes < 32 ? (bytes + 7) / 8 : 4; }

    //! The planes of a group, in 32 bits each.
    static __m512i planesOf(const uchar* group, int bytes)
    {
        const __mmask32 present = bytes < 32 ? (__mmask32(1) << bytes) - 1 : ~__mmask32(0);
        const __m512i words = _mm512_cvtepu16_epi32(_mm256_maskz_loadu_epi8(present, group)),
                      zero = _mm512_setzero_si512();
        __m512i sums = _mm512_xor_si512(words, _mm512_alignr_epi32(words, zero, 15));
        sums = _mm512_xor_si512(sums, _mm512_alignr_epi32(sums, zero, 14));
        sums = _mm512_xor_si512(sums, _mm512_alignr_epi32(sums, zero, 12));
        sums = _mm512_xor_si512(sums, _mm512_alignr_epi32(sums, zero, 8));
        return _mm512_mask_mov_epi32(words, 0x5555, sums);
    }

    static void packQueries(const uchar* rows, size_t step, int count, int bytes, uint64* packed)
    {
        for (int i = 0; i < count; i++)
        {
            for (int j = 0; j < bytes; j += 32)
            {
                const int words = wordsOf(bytes - j);
                const __m512i planes = planesOf(rows + i * step + j, bytes - j);
                _mm512_mask_storeu_epi64(packed, __mmask8((1 << 2 * words) - 1),
                                         _mm512_or_si512(planes, _mm512_slli_epi32(planes, 16)));
                packed += 2 * words;
            }
        }
    }

    static void packTrains(const uchar* rows, size_t step, int count, int bytes, uint64* packed)
    {
        ushort halves[2][32];
        for (int i = 0; i < 32; i++)
            for (int j = 0; j < 2; j++)
                halves[j][i] = ushort(16 * j + i / 2 + i % 2 * 32);
        for (int j = 0; j < bytes; j += 32)
        {
            __m512i planes[2][16];
            __m256i* const packedRows = reinterpret_cast<__m256i*>(planes[0]);
            for (int i = 0; i < 32; i++)
                packedRows[i] = i < count ? _mm512_cvtepi32_epi16(planesOf(rows + i * step + j, bytes - j))
                                          : _mm256_setzero_si256();
            // A round puts the elements of the second half between those of the first. Five rounds transpose.
            for (int round = 0; round < 5; round++)
                for (int i = 0; i < 16; i++)
                    planes[1 - round % 2][i] =
                        _mm512_permutex2var_epi16(planes[round % 2][i / 2], _mm512_loadu_si512(halves[i % 2]),
                                                  planes[round % 2][i / 2 + 8]);
            for (int i = 0; i < 4 * wordsOf(bytes - j); i++, packed += 8)
                _mm512_storeu_si512(packed, planes[1][i]);
        }
    }
};

//! The differences between a word of a query and those of a block.
inline __m512i difference(const unsigned* query, const uint64* block, int word)
{
    return _mm512_xor_si512(_mm512_set1_epi32(int(query[word])), _mm512_loadu_si512(block + 8 * word));
}

template <bool, int WORDS>
inline v_uint16 blockDistances(const uint64* packed, const uint64* block, int words)
{
    const int GROUP = Packing<false>::GROUP;
    const unsigned* query = reinterpret_cast<const unsigned*>(packed);
    __m512i distances = _mm512_setzero_si512();
    for (int left = 4 * (WORDS ? WORDS : words); left > 0; left -= GROUP)
    {
        const int count = WORDS == 4 || left > GROUP ? GROUP : left;
        __m512i sum = difference(query, block, 0), twos = _mm512_setzero_si512();
        for (int i = 1; i + 2 < count; i += 2)
        {
            const __m512i next = difference(query, block, i + 1);
            // The majority of three bits, from two of them and the sum.
            const __m512i carries = _mm512_ternarylogic_epi64(sum, difference(query, block, i), next, 0xd4);
            twos = _mm512_add_epi16(twos, _mm512_popcnt_epi16(carries));
            sum = next;
        }
        const __m512i last = difference(query, block, count - 1);
        const __m512i ones = _mm512_add_epi16(_mm512_popcnt_epi16(sum), _mm512_popcnt_epi16(last));
        distances = _mm512_add_epi16(distances, _mm512_add_epi16(ones, _mm512_add_epi16(twos, twos)));
        query += count;
        block += 8 * count;
    }
    return v_uint16(distances);
}

#else

//! Makes the keys of distances with a number.
struct KeyMaker
{
    explicit KeyMaker(int indexBits) : shift(vx_setall_u16(ushort(1 << indexBits))), one(1) {}
    v_uint16 keys(const v_uint16& distances, const v_uint16& numbers) const
    {
        return v_or(v_mul_wrap(distances, shift), numbers);
    }
    const v_uint16 shift;
    const int one;  //!< the step from a number to the next
};

/** Counts bits in vectors of 64-bit words, one word of as many descriptors as there are lanes. The sums of counts lie
 in the bytes of a word.
 PAIRS: two bits count as one. */
template <bool PAIRS> struct BitCounter
{
    typedef v_uint8 Vector;

#if CV_SSSE3
    // The counts of four bits each come from a table of 16 bytes. Descriptors are packed with their low and their high
    // halves of bytes apart, so that the difference of two is an index of the table.
    enum
    {
        NIBBLES = 1
    };
    static Vector added(const Vector& sums, const Vector& nibbles)
    {
        const __m128i table = PAIRS ? _mm_setr_epi8(0, 1, 1, 1, 1, 2, 2, 2, 1, 2, 2, 2, 1, 2, 2, 2)
                                    : _mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
#if CV_AVX512_SKX
        const Vector counts(_mm512_shuffle_epi8(_mm512_broadcast_i32x4(table), nibbles.val));
#elif CV_AVX2
        const Vector counts(_mm256_shuffle_epi8(_mm256_broadcastsi128_si256(table), nibbles.val));
#else
        const Vector counts(_mm_shuffle_epi8(table, nibbles.val));
#endif
        Vector result = v_add_wrap(sums, counts);
#if defined(__GNUC__) && defined(__x86_64__)
        // Otherwise GCC adds in an order that needs more registers than there are.
        __asm__("" : "+v"(result.val));
#endif
        return result;
    }
#else
    enum
    {
        NIBBLES = 0
    };
    static Vector added(const Vector& sums, const Vector& bits)
    {
        const v_uint64 word = v_reinterpret_as_u64(bits), low = v_shr<1>(word),
                       ones = v_reinterpret_as_u64(vx_setall_u8(0x55));
#if CV_NEON
        return v_add(sums, v_popcount(PAIRS ? v_reinterpret_as_u8(v_and(v_or(word, low), ones)) : bits));
#else
        // The counts of two bits, of four, and of eight: two instructions less than v_popcount.
        const v_uint64 threes = v_reinterpret_as_u64(vx_setall_u8(0x33)),
                       fifteens = v_reinterpret_as_u64(vx_setall_u8(0x0f));
        const v_uint64 ofTwo = PAIRS ? v_and(v_or(word, low), ones) : v_sub(word, v_and(low, ones));
        const v_uint64 ofFour = v_add(v_and(ofTwo, threes), v_and(v_shr<2>(ofTwo), threes));
        const v_uint64 ofEight = v_and(v_add(ofFour, v_shr<4>(ofFour)), fifteens);
        return v_add_wrap(sums, v_reinterpret_as_u8(ofEight));
#endif
    }
#endif

    //! The sums of the words of four vectors, in the order of laneOf.
    static v_uint16 total(const Vector* sums)
    {
#if CV_NEON
        const uint16x8_t a = pairwise(vpaddlq_u8(sums[0].val), vpaddlq_u8(sums[1].val));
        const uint16x8_t b = pairwise(vpaddlq_u8(sums[2].val), vpaddlq_u8(sums[3].val));
        return v_uint16(pairwise(a, b));
#elif CV_AVX512_SKX
        const __m512i a = _mm512_packs_epi32(word(sums[0].val), word(sums[1].val));
        const __m512i b = _mm512_packs_epi32(word(sums[2].val), word(sums[3].val));
        return v_uint16(_mm512_packs_epi32(a, b));
#elif CV_AVX2
        const __m256i a = _mm256_packs_epi32(word(sums[0].val), word(sums[1].val));
        const __m256i b = _mm256_packs_epi32(word(sums[2].val), word(sums[3].val));
        return v_uint16(_mm256_packs_epi32(a, b));
#else
        const __m128i a = _mm_packs_epi32(word(sums[0].val), word(sums[1].val));
        const __m128i b = _mm_packs_epi32(word(sums[2].val), word(sums[3].val));
        return v_uint16(_mm_packs_epi32(a, b));
#endif
    }

    //! Where in the four vectors the word of a descriptor of the block lies, in words.
    static int laneOf(int i)
    {
        const int lanes = AQORB_LANES(v_uint64);
        return i % 8 / 2 * lanes + i / 8 * 2 + i % 2;
    }

private:
#if CV_NEON
    static uint16x8_t pairwise(uint16x8_t a, uint16x8_t b)
    {
#if defined(__aarch64__) || defined(_M_ARM64)
        return vpaddq_u16(a, b);
#else
        return vcombine_u16(vpadd_u16(vget_low_u16(a), vget_high_u16(a)),
                            vpadd_u16(vget_low_u16(b), vget_high_u16(b)));
#endif
    }
#elif CV_AVX512_SKX
    static __m512i word(const __m512i& sums)
    {
        return _mm512_sad_epu8(sums, _mm512_setzero_si512());
    }
#elif CV_AVX2
    static __m256i word(const __m256i& sums)
    {
        return _mm256_sad_epu8(sums, _mm256_setzero_si256());
    }
#else
    static __m128i word(const __m128i& sums)
    {
        return _mm_sad_epu8(sums, _mm_setzero_si128());
    }
#endif
};

//! The words whose counts, at most 8 a byte, can be added in bytes.
const int WORDS_AT_ONCE = 31;

//! A descriptor with 64-bit words, whose bits or nibbles lie in planes.
template <bool PAIRS> struct Packing
{
    enum
    {
        PLANES = 1 + BitCounter<PAIRS>::NIBBLES,
        QUERY_PLANES = PLANES,
        TRAIN_PLANES = PLANES,
        IN_REGISTERS = 0
    };

    static int block() { return AQORB_LANES(v_uint16); }

    //! Writes the planes of a descriptor, which are stride words apart.
    static void pack(const uchar* descriptor, int bytes, uint64* packed, int stride)
    {
        for (int i = 0; i < bytes; i += 8, packed += PLANES * stride)
        {
            uint64 word = 0;
            if (bytes - i >= 8)
                std::memcpy(&word, descriptor + i, 8);
            else
                std::memcpy(&word, descriptor + i, size_t(bytes - i));
            const uint64 low = 0x0f0f0f0f0f0f0f0fu;
            packed[0] = PLANES == 1 ? word : word & low;
            if (PLANES == 2)
                packed[stride] = word >> 4 & low;
        }
    }

    static void packQueries(const uchar* rows, size_t step, int count, int bytes, uint64* packed)
    {
        const int words = (bytes + 7) / 8 * PLANES;
        for (int i = 0; i < count; i++)
            pack(rows + i * step, bytes, packed + size_t(i) * words, 1);
    }

    static void packTrains(const uchar* rows, size_t step, int count, int bytes, uint64* packed)
    {
        if (count < block())
            std::memset(packed, 0, size_t((bytes + 7) / 8) * PLANES * 4 * sizeof(v_uint64));
        for (int i = 0; i < count; i++)
            pack(rows + i * step, bytes, packed + BitCounter<PAIRS>::laneOf(i), 4 * AQORB_LANES(v_uint64));
    }
};

//! The distances of a query to the trains of a block. WORDS: of a descriptor, or 0 for the number that is given.
template <bool PAIRS, int WORDS>
inline v_uint16 blockDistances(const uint64* query, const uint64* block, int words)
{
    typedef BitCounter<PAIRS> Counter;
    const int lanes = AQORB_LANES(v_uint64), PLANES = Packing<PAIRS>::PLANES;
    v_uint16 distances = vx_setzero_u16();
    for (int left = WORDS ? WORDS : words; left > 0; left -= WORDS_AT_ONCE)
    {
        const int planes = WORDS ? WORDS * PLANES : (left < WORDS_AT_ONCE ? left : WORDS_AT_ONCE) * PLANES;
        v_uint8 sums[4] = {vx_setzero_u8(), vx_setzero_u8(), vx_setzero_u8(), vx_setzero_u8()};
        for (int i = 0; i < planes; i++, query++, block += 4 * lanes)
        {
            const v_uint8 own = v_reinterpret_as_u8(vx_setall_u64(*query));
            for (int j = 0; j < 4; j++)
            {
                const v_uint8 other = v_reinterpret_as_u8(vx_load(block + j * lanes));
                sums[j] = Counter::added(sums[j], v_xor(own, other));
            }
        }
        distances = WORDS ? Counter::total(sums) : v_add_wrap(distances, Counter::total(sums));
    }
    return distances;
}

#endif

}  // namespace

#endif

CV_CPU_OPTIMIZATION_NAMESPACE_END
}  // namespace aqorb
}  // namespace cv

#endif
