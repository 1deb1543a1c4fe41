// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "types.hpp"

namespace opencv_test
{
namespace
{

TEST(Aqorb_Aligned, vectors_begin_at_a_cache_line)
{
    for (size_t size = 1; size < 300; size++)
    {
        aqorb::AlignedVector<uchar> elements(size, uchar(1));
        elements.push_back(2);
        EXPECT_EQ(size_t(0), size_t(elements.data()) % aqorb::CACHE_LINE) << size << " elements";
        EXPECT_EQ(1, elements[size - 1]);
        EXPECT_EQ(2, elements[size]);
    }
    aqorb::LineAllocator<int> allocator;
    EXPECT_THROW(allocator.allocate(~size_t(0) / sizeof(int)), std::bad_alloc);
}

}  // namespace
}  // namespace opencv_test
