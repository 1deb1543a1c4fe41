// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "index_sort.hpp"

#include <algorithm>
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
    aqorb::SortScratch scratch;
    std::vector<unsigned> indices;
    RNG rng(1);
    for (int size : SIZES)
    {
        // All bits, few different numbers, and numbers that differ in their lowest bits only.
        for (const uint64 mask : {~uint64(0), uint64(7) << 40, uint64(0xffff)})
        {
            std::vector<uint64> numbers(size);
            for (uint64& number : numbers)
                number = ((uint64(rng.next()) << 32 | rng.next()) & mask) | (uint64(1) << 62 & ~mask);
            aqorb::sortIndices(numbers, scratch, indices);
            EXPECT_EQ(sortedPlainly(numbers), indices) << size << " numbers with the bits " << mask;
        }
    }
}

TEST(Aqorb_IndexSort, some_numbers_may_lie_outside_of_the_range)
{
    aqorb::SortScratch scratch;
    std::vector<unsigned> indices;
    RNG rng(2);
    const uint64 least = 1 << 20, greatest = 1 << 21;
    for (int size : SIZES)
    {
        std::vector<uint64> numbers(size);
        for (size_t i = 0; i < numbers.size(); i++)
            numbers[i] = i % 10 == 0   ? rng.next() % least
                         : i % 11 == 0 ? ~uint64(rng.next() % 1000)
                                       : least + rng.next() % (greatest - least);
        aqorb::sortIndices(numbers, least, greatest, scratch, indices);
        EXPECT_EQ(sortedPlainly(numbers), indices) << size << " numbers";
    }
}

}  // namespace
}  // namespace opencv_test
