// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Vectors that begin at a cache line, and buffers that only grow.

#ifndef OPENCV_AQORB_MEMORY_HPP
#define OPENCV_AQORB_MEMORY_HPP

#include <opencv2/core.hpp>

#include <new>
#include <vector>

namespace cv
{
namespace aqorb
{

//! Bytes of a cache line. The widest vectors are as long; an unaligned one lies across two lines.
const int CACHE_LINE = 64;

//! Allocates memory that begins at a cache line.
template <typename T> struct LineAllocator
{
    typedef T value_type;
    LineAllocator() {}
    template <typename U> LineAllocator(const LineAllocator<U>&) {}

    T* allocate(size_t count)
    {
        if (count > (~size_t(0) - CACHE_LINE) / sizeof(T))
            throw std::bad_alloc();
        // The address to free lies before the elements.
        uchar* const memory = static_cast<uchar*>(::operator new(count * sizeof(T) + CACHE_LINE));
        uchar* const elements = alignPtr(memory + sizeof(void*), CACHE_LINE);
        reinterpret_cast<void**>(elements)[-1] = memory;
        return reinterpret_cast<T*>(elements);
    }
    void deallocate(T* elements, size_t) { ::operator delete(reinterpret_cast<void**>(elements)[-1]); }
};
template <typename T, typename U> bool operator==(const LineAllocator<T>&, const LineAllocator<U>&)
{
    return true;
}
template <typename T, typename U> bool operator!=(const LineAllocator<T>&, const LineAllocator<U>&)
{
    return false;
}

//! Vector whose elements begin at a cache line.
template <typename T> using AlignedVector = std::vector<T, LineAllocator<T>>;

//! Grows a buffer to at least `count` elements; never shrinks it. A buffer that grows loses its elements, because it
//! frees its old memory first. It allocates exactly `count` elements; std::vector would double.
//! @return address of the first element
template <typename Vector> typename Vector::value_type* growTo(Vector& elements, size_t count)
{
    if (elements.size() < count)
    {
        Vector().swap(elements);
        elements.resize(count);
    }
    return elements.data();
}

}  // namespace aqorb
}  // namespace cv

#endif
