// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TYPES_HPP
#define OPENCV_AQORB_TYPES_HPP

#include <opencv2/core.hpp>

#include <new>
#include <vector>

// Types that several stages share. The header of a stage declares the stage and the structs of its kernel, so a change
// in one stage does not recompile the others.
//
// A stage and its kernel (*.simd.hpp) exchange only raw pointers and plain structs. The compiler may emit a member or
// template function in a file compiled for one CPU; if the linker chose it for the whole program, the program would
// crash on other CPUs.

namespace cv
{
namespace aqorb
{

//! Level of the pyramid. Outside its border its pixels continue by reflection (BORDER_REFLECT_101).
struct Level
{
    Mat image;             //!< CV_8UC1
    Mat mask;              //!< CV_8UC1 of the same size, not 0 at usable pixels; empty: all are usable
    float scale = 1;       //!< size of a pixel of this level in pixels of the input image
    bool isInput = false;  //!< whether the level is the input image itself
};

const int FAST_RADIUS = 3;  //!< radius of FAST's circle of pixels

//! FAST thresholds of an image: `ini` everywhere, `min` in cells without a corner at `ini`.
struct Thresholds
{
    int ini, min;
};

//! FAST corner: a pixel of a level and its score, the highest threshold at which it is a corner.
struct Corner
{
    int x;
    int y : 22, score : 10;  // 8 bytes a corner: a level has thousands
};

//! Corner with its response: Harris response or FAST score.
struct CornerResponse
{
    int x, y;
    float response;
};

//! Orders corners by row, then by column. A type, because std::sort does not inline functions.
struct InRasterOrder
{
    template <typename C> bool operator()(const C& a, const C& b) const
    {
        return a.y != b.y ? a.y < b.y : a.x < b.x;
    }
};

//! Pixel of a level and direction of a feature.
struct FeaturePoint
{
    int x, y;
    float angle;  //!< degrees
};

//! Features of a level.
struct FeatureList
{
    std::vector<FeaturePoint> points;  //!< in raster order
    std::vector<KeyPoint> keypoints;   //!< one for each point
    std::vector<uchar> descriptors;    //!< ORB::kBytes for each point; empty without descriptors
    std::vector<uint64> outputKeys;    //!< one for each point; ascending keys order the output
};

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
