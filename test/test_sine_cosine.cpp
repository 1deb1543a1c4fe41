// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "descriptor.hpp"

#include <cfloat>
#include <cmath>

namespace opencv_test
{
namespace
{

unsigned bitsOf(float v)
{
    Cv32suf bits;
    bits.f = v;
    return bits.u;
}

//! Angles of either sign: every exponent, with many mantissas.
std::vector<float> manyAngles(float largest = 120)
{
    std::vector<float> angles;
    for (unsigned bits = 0; bits <= bitsOf(largest); bits += 1009)
    {
        Cv32suf angle;
        angle.u = bits;
        angles.push_back(angle.f);
        angles.push_back(-angle.f);
    }
    return angles;
}

#if defined(__GLIBC__)
#if !__GLIBC_PREREQ(2, 42)  // later versions were not compared
TEST(Aqorb_SineCosine, are_those_of_the_gnu_c_library)
{
    int different = 0;
    for (const float angle : manyAngles(FLT_MAX))
    {
        float sine, cosine;
        aqorb::sineAndCosine(angle, sine, cosine);
        different += sine != std::sin(angle) || cosine != std::cos(angle);
    }
    EXPECT_EQ(0, different);
}
#endif
#endif

TEST(Aqorb_SineCosine, are_the_same_on_every_system)
{
    uint64 hash = 0;
    for (const float angle : manyAngles())
    {
        float sine, cosine;
        aqorb::sineAndCosine(angle, sine, cosine);
        // The sign of a zero is of no effect.
        hash = (hash ^ bitsOf(sine + 0.f)) * 0x9e3779b97f4a7c15ULL;
        hash = (hash ^ bitsOf(cosine + 0.f)) * 0x9e3779b97f4a7c15ULL;
    }
    EXPECT_EQ(uint64(0xb64e51f6095d960), hash);
}

}  // namespace
}  // namespace opencv_test
