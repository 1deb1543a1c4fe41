// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TYPES_HPP
#define OPENCV_AQORB_TYPES_HPP

#include <opencv2/core.hpp>

#include <new>
#include <vector>

// The types that several stages share. A stage and the structs that only its own kernel needs are declared in
// the header of the stage, so that a change in one stage does not recompile the others.
//
// What passes between a stage and its kernel (*.simd.hpp) are raw pointers and plain structs only. A function of
// a class or a template that the compiler emits in a file compiled for one CPU could be chosen by the linker for
// the whole program, which would then crash on other CPUs.

namespace cv
{
namespace aqorb
{

//! One level of the pyramid. Its pixels are continued outside of the image by reflection (BORDER_REFLECT_101).
struct Level
{
    Mat image;             //!< CV_8UC1
    Mat mask;              //!< CV_8UC1 of the same size, not 0 where a corner may lie; empty: everywhere
    float scale = 1;       //!< size of a pixel of this level in pixels of the input image
    bool isInput = false;  //!< whether the level is the input image itself
};

const int FAST_RADIUS = 3;  //!< of the circle of pixels that FAST compares with a pixel

//! FAST thresholds of an image: `ini` everywhere, `min` in cells that have no corner at `ini`.
struct Thresholds
{
    int ini, min;
};

//! A FAST corner: a pixel of a level and its FAST score (the highest threshold at which it is a corner).
struct Corner
{
    int x;
    int y : 22, score : 10;  // a level has thousands of corners: 8 bytes for each
};

//! A corner with its response: its Harris response or its FAST score.
struct CornerResponse
{
    int x, y;
    float response;
};

//! Orders corners by rows, and by columns within a row. It is a type because std::sort does not inline functions.
struct InRasterOrder
{
    template <typename C> bool operator()(const C& a, const C& b) const
    {
        return a.y != b.y ? a.y < b.y : a.x < b.x;
    }
};

//! The pixel of a level at which a feature is described, and in which direction.
struct FeaturePoint
{
    int x, y;
    float angle;  //!< degrees
};

//! Features of a level.
struct FeatureList
{
    std::vector<FeaturePoint> points;  //!< in raster order
    std::vector<KeyPoint> keypoints;   //!< of the points
    std::vector<uchar> descriptors;    //!< of the points, ORB::kBytes each; empty if they are not wanted
    std::vector<uint64> outputKeys;    //!< of the points: features come in the output by ascending keys
};

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

//! Makes a buffer at least so long. If it grows, its elements are lost, because the old memory is freed first. It gets
//! no more than is needed, where a vector may double its memory. It never shrinks, so later images need no new memory.
//! @return the first element
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
