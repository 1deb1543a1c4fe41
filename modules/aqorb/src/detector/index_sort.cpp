// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Radix sort.

#include "precomp.hpp"

#include "detector/index_sort.hpp"

namespace cv
{
namespace aqorb
{

namespace
{
struct ByKey
{
    bool operator()(unsigned a, unsigned b) const { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; }
    const uint64* keys;
};
}  // namespace

std::vector<unsigned> sortIndices(const std::vector<uint64>& keys)
{
    const size_t FEW = 128, size = keys.size();
    const ByKey byKey = {keys.data()};
    std::vector<unsigned> indices(size);
    if (size <= FEW)
    {
        std::iota(indices.begin(), indices.end(), 0u);
        std::sort(indices.begin(), indices.end(), byKey);
        return indices;
    }
    const auto range = std::minmax_element(keys.begin(), keys.end());
    const uint64 least = *range.first, greatest = *range.second;
    // After two passes over the upper bits of the range few indices remain to compare. Few keys take short digits,
    // whose counts are cheap to add up.
    const int MAX_BITS = 11, digitBits = size < 1024 ? 8 : MAX_BITS, digits = 1 << digitBits;
    int shift = 0;
    while ((greatest - least) >> shift >= uint64(digits) * digits)
        shift++;
    const auto digitsOf = [&](size_t i) { return unsigned((keys[i] - least) >> shift); };
    unsigned starts[2][(1 << MAX_BITS) + 1];
    for (unsigned* of : {starts[0], starts[1]})
        std::fill_n(of, digits + 1, 0u);
    for (size_t i = 0; i < size; i++)
    {
        starts[0][(digitsOf(i) & (digits - 1)) + 1]++;
        starts[1][(digitsOf(i) >> digitBits) + 1]++;
    }
    for (unsigned* of : {starts[0], starts[1]})
        std::partial_sum(of, of + digits, of);
    std::vector<uint64> items(size);
    for (size_t i = 0; i < size; i++)
        items[starts[0][digitsOf(i) & (digits - 1)]++] = uint64(digitsOf(i)) << 32 | i;
    for (uint64 item : items)
        indices[starts[1][item >> (32 + digitBits)]++] = unsigned(item);
    if (shift == 0)
        return indices;  // two digits cover the whole keys
    for (size_t i = 1, begin = 0; i <= size; i++)
    {
        if (i < size && digitsOf(indices[i]) == digitsOf(indices[begin]))
            continue;
        if (i - begin > 1)
            std::sort(indices.begin() + begin, indices.begin() + i, byKey);
        begin = i;
    }
    return indices;
}

}  // namespace aqorb
}  // namespace cv
