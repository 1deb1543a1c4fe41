// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <cfloat>
#include <climits>
#include <limits>

namespace opencv_test
{
namespace
{

KeyPoints randomKeypoints(int count, Size size, int seed)
{
    RNG rng(seed);
    KeyPoints keypoints;
    for (int i = 0; i < count; i++)
    {
        // a third of them in one corner
        const float part = i % 3 ? 1.f : 0.2f;
        keypoints.push_back(KeyPoint(rng.uniform(0.f, part * size.width),
                                     rng.uniform(0.f, part * size.height), rng.uniform(1.f, 99.f),
                                     rng.uniform(-1.f, 360.f), rng.uniform(-5.f, 5.f), rng.uniform(-3, 99),
                                     i));  // class_id tells which it was
    }
    return keypoints;
}

void expectAsReference(const KeyPoints& given, Size size, int npoints)
{
    const KeyPoints expected = reference::retainUniform(given, size, npoints);
    KeyPoints kept = given;
    aqorb::retainUniform(kept, size, npoints);
    EXPECT_TRUE(sameKeypoints(kept, expected));
    aqorb::retainUniform(kept, size, npoints);  // once more changes nothing
    EXPECT_TRUE(sameKeypoints(kept, expected));
}

TEST(Aqorb_RetainUniform, equals_reference_and_touches_no_field)
{
    const Size size(640, 481);
    const KeyPoints all = randomKeypoints(1000, size, 1);
    const int numbers[] = {0, 1, 2, 5, 16, 17, 100, 500, 999, 1000, 5000, INT_MAX};
    for (int n : numbers)
    {
        SCOPED_TRACE(n);
        expectAsReference(all, size, n);
    }
}

TEST(Aqorb_RetainUniform, equals_reference_for_all_kinds_of_responses)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const float odd[] = {nan, -nan,   -inf,   -FLT_MAX, -1.f,    -1e-42f, -0.f,
                         0.f, 1e-45f, 1e-38f, 1.f,      FLT_MAX, inf,     inf};
    const Size size(300, 200);
    for (int seed = 1; seed <= 60; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        KeyPoints keypoints = randomKeypoints(rng.uniform(1, 500), size, seed);
        for (KeyPoint& keypoint : keypoints)
        {
            const int kind = seed % 5;
            if (kind == 0)
                keypoint.response = odd[rng.uniform(0, 14)];
            else if (kind == 1)
                keypoint.response = float(rng.uniform(0, 3));  // many are equal
            else if (kind == 2)
                keypoint.response = 7;
            else if (kind == 3)
                keypoint.response = std::ldexp(rng.uniform(1.f, 2.f), rng.uniform(-149, 128));
            else if (rng.uniform(0, 3) == 0)
                keypoint.response = odd[rng.uniform(0, 14)];
        }
        for (int n = 1; n < 500; n += rng.uniform(1, 150))
            expectAsReference(keypoints, size, n);
    }
}

TEST(Aqorb_RetainUniform, equals_reference_for_all_kinds_of_positions)
{
    for (int seed = 1; seed <= 40; seed++)
    {
        SCOPED_TRACE(seed);
        RNG rng(seed);
        const Size size(rng.uniform(1, 60), rng.uniform(1, 60));
        KeyPoints keypoints = randomKeypoints(rng.uniform(1, 300), size, seed);
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            Point2f& p = keypoints[i].pt;
            const int kind = rng.uniform(0, 5);
            if (kind == 0)
                p = keypoints[rng.uniform(0, int(keypoints.size()))].pt;  // a duplicate
            else if (kind == 1)
                p = Point2f(float(cvFloor(p.x)), float(cvFloor(p.y)));
            else if (kind == 2)
                (i % 2 ? p.x : p.y) = 0;
            else if (kind == 3)  // the last number before the side
                (i % 2 ? p.x : p.y) = std::nextafter(float(i % 2 ? size.width : size.height), 0.f);
            if (seed % 2)
                keypoints[i].response = 1;
        }
        for (int n = 1; n < 300; n += rng.uniform(1, 70))
            expectAsReference(keypoints, size, n);
    }
}

TEST(Aqorb_RetainUniform, equals_reference_for_every_image_size)
{
    const Size sizes[] = {Size(1, 1),
                          Size(1, 2),
                          Size(3, 1),
                          Size(1, 1000),
                          Size(20000, 7),
                          Size(1 << 18, 1 << 18),
                          Size((1 << 18) + 1, 1 << 17),
                          Size(1 << 20, 1 << 20),
                          Size((1 << 20) + 7, 3001),
                          Size(1001, 5000000),
                          Size(1 << 29, 1 << 30)};
    for (const Size& size : sizes)
    {
        SCOPED_TRACE(format("%d x %d", size.width, size.height));
        const KeyPoints keypoints = randomKeypoints(300, size, size.width);
        for (int n : {1, 2, 9, 60, 299})
            expectAsReference(keypoints, size, n);
    }
}

#if CV_SSE2
// GCC's start-up code sets these bits in programs that are linked with -ffast-math.
TEST(Aqorb_RetainUniform, counts_subnormal_responses_as_zero_where_the_cpu_flushes_them)
{
    const Size size(200, 150);
    KeyPoints keypoints = randomKeypoints(900, size, 1), zeros = keypoints;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        keypoints[i].response = 1e-41f * (1 + i * 7 % 300);
        zeros[i].response = 0;
    }
    const auto classesOf = [&](KeyPoints kept)
    {
        aqorb::retainUniform(kept, size, 100);
        std::vector<int> classes;
        for (const KeyPoint& keypoint : kept)
            classes.push_back(keypoint.class_id);
        return classes;
    };
    EXPECT_NE(classesOf(zeros), classesOf(keypoints));
    const unsigned before = _mm_getcsr(), FLUSH_RESULTS = 0x8000, FLUSH_OPERANDS = 0x40;
    _mm_setcsr(before | FLUSH_RESULTS | FLUSH_OPERANDS);
    EXPECT_EQ(classesOf(zeros), classesOf(keypoints));
    _mm_setcsr(before);
}
#endif

TEST(Aqorb_RetainUniform, drops_what_lies_outside)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    const Point2f outside[] = {Point2f(-0.5f, 5), Point2f(5, -1e-6f), Point2f(10, 5),  Point2f(5, 20),
                               Point2f(nan, 5),   Point2f(5, nan),    Point2f(inf, 5), Point2f(5, -inf)};
    KeyPoints keypoints;
    for (const Point2f& p : outside)
        keypoints.push_back(KeyPoint(p, 1));
    keypoints.push_back(KeyPoint(0, 0, 1));
    keypoints.push_back(KeyPoint(9.999f, 19.999f, 1));
    const KeyPoints inside(keypoints.end() - 2, keypoints.end());
    aqorb::retainUniform(keypoints, Size(10, 20), 1000);  // also where fewer than npoints are there
    EXPECT_TRUE(sameKeypoints(keypoints, inside));
    keypoints.clear();
    aqorb::retainUniform(keypoints, Size(10, 20), 3);
    EXPECT_TRUE(keypoints.empty());
}

}  // namespace
}  // namespace opencv_test
