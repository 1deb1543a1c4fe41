// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "allocations.hpp"

#include <opencv2/core.hpp>

#include <atomic>
#include <cstdlib>
#include <new>

namespace
{

std::atomic<long> newCalls(0), matrices(0), countdown(0);

// While OpenCV allocates a matrix, which is counted as one allocation.
thread_local bool isMatrix = false;

//! Whether this is the allocation that is to fail.
bool isToFail()
{
    return countdown > 0 && --countdown == 0;
}

class CountingMatAllocator : public cv::MatAllocator
{
public:
    cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                           cv::AccessFlag flags, cv::UMatUsageFlags usage) const CV_OVERRIDE
    {
        matrices++;
        if (!data && isToFail())
            CV_Error(cv::Error::StsNoMem, "no memory, on purpose");
        const Mark mark;
        return cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
    }
    bool allocate(cv::UMatData* data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const CV_OVERRIDE
    {
        return cv::Mat::getStdAllocator()->allocate(data, flags, usage);
    }
    void deallocate(cv::UMatData* data) const CV_OVERRIDE { cv::Mat::getStdAllocator()->deallocate(data); }

private:
    struct Mark
    {
        Mark() { isMatrix = true; }
        ~Mark() { isMatrix = false; }
    };
};

// Lives on after the counter: a matrix may be made while that ends.
CountingMatAllocator matAllocator;
cv::MatAllocator* before = 0;

}  // namespace

namespace opencv_test
{

AllocationCounter::AllocationCounter(long failing)
{
    CV_Assert(!before);
    before = cv::Mat::getDefaultAllocator();
    cv::Mat::setDefaultAllocator(&matAllocator);
    newCalls = 0;
    matrices = 0;
    countdown = failing;
}

AllocationCounter::~AllocationCounter()
{
    countdown = 0;
    cv::Mat::setDefaultAllocator(before);
    before = 0;
}

long AllocationCounter::ofNew() const
{
    return newCalls;
}

long AllocationCounter::ofMatrices() const
{
    return matrices;
}

}  // namespace opencv_test

// All forms, or a sanitizer would see memory go back to where it does not come from.

void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
    if (!isMatrix)
    {
        newCalls++;
        if (isToFail())
            return 0;
    }
    return std::malloc(size > 0 ? size : 1);
}

void* operator new[](std::size_t size, const std::nothrow_t& nothrow) noexcept
{
    return operator new(size, nothrow);
}

void* operator new(std::size_t size)
{
    if (void* memory = operator new(size, std::nothrow))
        return memory;
    throw std::bad_alloc();
}

void* operator new[](std::size_t size)
{
    return operator new(size);
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory) noexcept
{
    std::free(memory);
}

// Declared by the standard library from C++14 on; OpenCV's build is C++11.
void operator delete(void* memory, std::size_t) noexcept;
void operator delete[](void* memory, std::size_t) noexcept;

void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, std::size_t) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, const std::nothrow_t&) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, const std::nothrow_t&) noexcept
{
    std::free(memory);
}
