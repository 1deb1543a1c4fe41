// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "allocations.hpp"

#include <opencv2/core.hpp>

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace
{

std::atomic<long> matrices(0), countdown(0);
std::atomic<long long> inUse(0), peak(0);  // bytes, of the whole program
long long inUseBefore = 0;

long long sizeOf(void* memory)
{
#if defined(__GLIBC__)
    return (long long)malloc_usable_size(memory);
#else
    (void)memory;
    return 0;
#endif
}

void addBytes(long long count)
{
    const long long now = inUse += count;
    long long most = peak;
    while (most < now && !peak.compare_exchange_weak(most, now))
    {
    }
}

void freeCounted(void* memory)
{
    if (memory)
        addBytes(-sizeOf(memory));
    std::free(memory);
}

// While OpenCV allocates a matrix, which is counted as one allocation.
thread_local bool isMatrix = false;

// Whether allocations of the thread may fail.
thread_local bool mayFail = false;

//! Whether this is the allocation that is to fail.
bool isToFail()
{
    return mayFail && countdown > 0 && --countdown == 0;
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
        cv::UMatData* const allocated =
            cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
        // So that it comes back here.
        allocated->prevAllocator = allocated->currAllocator = this;
        if (!data)
            addBytes((long long)allocated->size);
        return allocated;
    }
    bool allocate(cv::UMatData* data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const CV_OVERRIDE
    {
        return cv::Mat::getStdAllocator()->allocate(data, flags, usage);
    }
    void deallocate(cv::UMatData* data) const CV_OVERRIDE
    {
        if (data && !(data->flags & cv::UMatData::USER_ALLOCATED))
            addBytes(-(long long)data->size);
        cv::Mat::getStdAllocator()->deallocate(data);
    }

private:
    struct Mark
    {
        Mark() { isMatrix = true; }
        ~Mark() { isMatrix = false; }
    };
};

// It is never destroyed, as matrices that it made may live on to the end of the program.
cv::MatAllocator* matAllocator()
{
    static cv::MatAllocator* const allocator = new CountingMatAllocator;
    return allocator;
}
cv::MatAllocator* before = 0;

}  // namespace

namespace opencv_test
{

AllocationCounter::AllocationCounter(long failing)
{
    CV_Assert(!before);
    before = cv::Mat::getDefaultAllocator();
    cv::Mat::setDefaultAllocator(matAllocator());
    matrices = 0;
    inUseBefore = inUse;
    beginPeak();
    letThreadFail();
    countdown = failing;
}

void AllocationCounter::letThreadFail()
{
    mayFail = true;
}

AllocationCounter::~AllocationCounter()
{
    countdown = 0;
    cv::Mat::setDefaultAllocator(before);
    before = 0;
}

long AllocationCounter::ofMatrices() const
{
    return matrices;
}

bool AllocationCounter::countsBytes()
{
#if defined(__GLIBC__)
    return true;
#else
    return false;
#endif
}

long long AllocationCounter::bytes() const
{
    return inUse - inUseBefore;
}

long long AllocationCounter::peakBytes() const
{
    return peak - inUseBefore;
}

void AllocationCounter::beginPeak()
{
    peak = inUse.load();
}

}  // namespace opencv_test

// All forms, or a sanitizer would see memory go back to where it does not come from.

void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
    if (!isMatrix && isToFail())
        return 0;
    void* const memory = std::malloc(size > 0 ? size : 1);
    if (memory)
        addBytes(sizeOf(memory));
    return memory;
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
    freeCounted(memory);
}

void operator delete[](void* memory) noexcept
{
    freeCounted(memory);
}

// Declared by the standard library from C++14 on; OpenCV's build is C++11.
void operator delete(void* memory, std::size_t) noexcept;
void operator delete[](void* memory, std::size_t) noexcept;

void operator delete(void* memory, std::size_t) noexcept
{
    freeCounted(memory);
}

void operator delete[](void* memory, std::size_t) noexcept
{
    freeCounted(memory);
}

void operator delete(void* memory, const std::nothrow_t&) noexcept
{
    freeCounted(memory);
}

void operator delete[](void* memory, const std::nothrow_t&) noexcept
{
    freeCounted(memory);
}
