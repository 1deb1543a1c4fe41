// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "failing_memory.hpp"

#include <opencv2/core.hpp>

#include <atomic>
#include <cstdlib>
#include <new>

namespace
{

std::atomic<long> allocations(0), failing(0);

// While OpenCV allocates a matrix, which takes two allocations: it loses the first if the second one fails.
thread_local bool isSpared = false;

bool isToFail()
{
    return !isSpared && ++allocations == failing;
}

class FailingMatAllocator : public cv::MatAllocator
{
public:
    cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                           cv::AccessFlag flags, cv::UMatUsageFlags usage) const CV_OVERRIDE
    {
        if (!data && isToFail())
            CV_Error(cv::Error::StsNoMem, "no memory, on purpose");
        isSpared = true;
        cv::UMatData* const allocated =
            cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
        isSpared = false;
        return allocated;
    }
    bool allocate(cv::UMatData* data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const CV_OVERRIDE
    {
        return cv::Mat::getStdAllocator()->allocate(data, flags, usage);
    }
    void deallocate(cv::UMatData* data) const CV_OVERRIDE { cv::Mat::getStdAllocator()->deallocate(data); }
};

}  // namespace

namespace soak
{

void failAllocation(long countdown)
{
    static FailingMatAllocator allocator;
    cv::Mat::setDefaultAllocator(&allocator);
    failing = 0;
    allocations = 0;
    failing = countdown;
}

long allocationsSince()
{
    return allocations;
}

}  // namespace soak

// All forms, or a sanitizer would see memory go back to where it does not come from.

void* operator new(std::size_t size, const std::nothrow_t&) noexcept
{
    return isToFail() ? 0 : std::malloc(size ? size : 1);
}

void* operator new[](std::size_t size, const std::nothrow_t& nothrow) noexcept
{
    return operator new(size, nothrow);
}

void* operator new(std::size_t size)
{
    void* const memory = operator new(size, std::nothrow);
    if (!memory)
        throw std::bad_alloc();
    return memory;
}

void* operator new[](std::size_t size)
{
    return operator new(size);
}

void operator delete(void* memory) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

void operator delete(void* memory, const std::nothrow_t&) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, std::size_t) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, const std::nothrow_t&) noexcept
{
    std::free(memory);
}
