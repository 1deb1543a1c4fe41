// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "descriptor.hpp"

#include <cmath>
#include <limits>

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

//! Angles of either sign up to 120: every exponent, with many mantissas.
std::vector<float> manyAngles()
{
    std::vector<float> angles;
    for (unsigned bits = 0; bits <= bitsOf(120.f); bits += 1009)
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
    for (const float angle : manyAngles())
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

TEST(Aqorb_SineCosine, of_any_number_are_defined)
{
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float angle : {120.f, -120.f, 1e9f, -3e38f})
    {
        float sine, cosine;
        aqorb::sineAndCosine(angle, sine, cosine);
        EXPECT_NEAR(std::sin(double(angle)), sine, 1e-6) << angle;
        EXPECT_NEAR(std::cos(double(angle)), cosine, 1e-6) << angle;
    }
    for (const float angle : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()})
    {
        float sine, cosine;
        aqorb::sineAndCosine(angle, sine, cosine);
        EXPECT_TRUE(cvIsNaN(sine) && cvIsNaN(cosine)) << angle;
    }
}

}  // namespace
}  // namespace opencv_test
