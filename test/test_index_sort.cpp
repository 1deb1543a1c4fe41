// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "index_sort.hpp"

#include <algorithm>
#include <climits>
#include <limits>
#include <numeric>

namespace opencv_test
{
namespace
{

//! The indices of numbers in their order; equal numbers in the order of their indices.
std::vector<unsigned> sortedPlainly(const std::vector<uint64>& numbers)
{
    std::vector<unsigned> indices(numbers.size());
    std::iota(indices.begin(), indices.end(), 0u);
    std::stable_sort(indices.begin(), indices.end(),
                     [&](unsigned a, unsigned b) { return numbers[a] < numbers[b]; });
    return indices;
}

// The sizes lie around those at which the method changes.
const int SIZES[] = {0, 1, 2, 127, 128, 129, 130, 1023, 1024, 1025, 5000};

TEST(Aqorb_IndexSort, sorts_any_number_of_numbers)
{
    RNG rng(1);
    for (int size : SIZES)
    {
        // All bits, few different numbers, and numbers that differ in their lowest bits only.
        for (const uint64 mask : {~uint64(0), uint64(7) << 40, uint64(0xffff)})
        {
            std::vector<uint64> numbers(size);
            for (uint64& number : numbers)
                number = ((uint64(rng.next()) << 32 | rng.next()) & mask) | (uint64(1) << 62 & ~mask);
            EXPECT_EQ(sortedPlainly(numbers), aqorb::sortIndices(numbers))
                << size << " numbers with the bits " << mask;
        }
    }
}

TEST(Aqorb_IndexSort, keys_sort_as_values_do)
{
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const float values[] = {nan, -inf, -1.f, -1e-42f, 0.f, 1e-42f, 1.f, 2.f, inf};
    for (int i = 0; i < 9; i++)
    {
        const int key = aqorb::sortKey(values[i]);
        EXPECT_NE(key, INT_MIN);
        if (i > 0)
        {
            EXPECT_GT(key, aqorb::sortKey(values[i - 1])) << values[i];
            EXPECT_LT(aqorb::descendingKey(key), aqorb::descendingKey(aqorb::sortKey(values[i - 1])));
        }
    }
    EXPECT_EQ(aqorb::sortKey(-0.f), aqorb::sortKey(0.f));
    EXPECT_EQ(aqorb::sortKey(-nan), aqorb::sortKey(nan));
}

}  // namespace
}  // namespace opencv_test
