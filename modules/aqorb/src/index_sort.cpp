// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "index_sort.hpp"

namespace cv
{
namespace aqorb
{

namespace
{
struct ByNumber
{
    bool operator()(unsigned a, unsigned b) const
    {
        return numbers[a] != numbers[b] ? numbers[a] < numbers[b] : a < b;
    }
    const uint64* numbers;
};
}  // namespace

void sortIndices(const std::vector<uint64>& numbers, uint64 least, uint64 greatest, SortScratch& scratch,
                 std::vector<unsigned>& indices)
{
    const size_t FEW = 128, size = numbers.size();
    const ByNumber byNumber = {numbers.data()};
    indices.resize(size);
    if (size <= FEW)
    {
        std::iota(indices.begin(), indices.end(), 0u);
        std::sort(indices.begin(), indices.end(), byNumber);
        return;
    }
    // Two digits of the upper bits of the range leave few indices to compare. Fewer numbers need shorter digits, whose
    // counts are sooner added up.
    const int MOST_BITS = 11, digitBits = size < 1024 ? 8 : MOST_BITS, digits = 1 << digitBits;
    int shift = 0;
    while ((greatest - least) >> shift >= uint64(digits) * digits)
        shift++;
    unsigned starts[2][1 << MOST_BITS];
    for (int pass = 0; pass < 2; pass++)
        std::fill_n(starts[pass], digits, 0u);
    scratch.items.resize(size);
    scratch.moved.resize(size);
    for (size_t i = 0; i < size; i++)
    {
        const uint64 above = std::min(std::max(numbers[i], least), greatest) - least;
        const unsigned both = unsigned(above >> shift);
        scratch.items[i] = uint64(both) << 32 | i;
        starts[0][both & (digits - 1)]++;
        starts[1][both >> digitBits]++;
    }
    for (int pass = 0; pass < 2; pass++)
    {
        unsigned begin = 0;
        for (int digit = 0; digit < digits; digit++)
        {
            const unsigned count = starts[pass][digit];
            starts[pass][digit] = begin;
            begin += count;
        }
        const int digitShift = 32 + pass * digitBits;
        for (size_t i = 0; i < size; i++)
            scratch.moved[starts[pass][scratch.items[i] >> digitShift & (digits - 1)]++] = scratch.items[i];
        scratch.items.swap(scratch.moved);
    }
    for (size_t i = 0; i < size; i++)
        indices[i] = unsigned(scratch.items[i]);
    for (size_t i = 1, begin = 0; i <= size; i++)
    {
        if (i < size && scratch.items[i] >> 32 == scratch.items[begin] >> 32)
            continue;
        if (i - begin > 1)
            std::sort(indices.begin() + begin, indices.begin() + i, byNumber);
        begin = i;
    }
}

void sortIndices(const std::vector<uint64>& numbers, SortScratch& scratch, std::vector<unsigned>& indices)
{
    uint64 least = 0, greatest = 0;
    for (size_t i = 0; i < numbers.size(); i++)
    {
        least = i == 0 ? numbers[i] : std::min(least, numbers[i]);
        greatest = std::max(greatest, numbers[i]);
    }
    sortIndices(numbers, least, greatest, scratch, indices);
}

}  // namespace aqorb
}  // namespace cv
