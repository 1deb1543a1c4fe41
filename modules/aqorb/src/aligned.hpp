// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_ALIGNED_HPP
#define OPENCV_AQORB_ALIGNED_HPP

#include <opencv2/core.hpp>

#include <new>
#include <vector>

namespace cv
{
namespace aqorb
{

//! Bytes of a cache line. The widest vectors are as long, so one that does not begin at a line lies across two.
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
        // Before the elements there is always space for the address that is to be freed.
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

//! A vector whose elements begin at a cache line.
template <typename T> using AlignedVector = std::vector<T, LineAllocator<T>>;

//! Gives work space at least so many elements, of any values. It never shrinks, so that it is soon allocated for good. It is
//! freed before it grows, and has no more than is needed: a vector that grows by itself may get twice as much.
template <typename Vector> void growTo(Vector& elements, size_t count)
{
    if (elements.size() < count)
    {
        Vector().swap(elements);
        elements.resize(count);
    }
}
template <typename Vector> typename Vector::value_type* grown(Vector& elements, size_t count)
{
    growTo(elements, count);
    return elements.data();
}

}  // namespace aqorb
}  // namespace cv

#endif
