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

bool isToFail()
{
    return ++allocations == failing;
}

class FailingMatAllocator : public cv::MatAllocator
{
public:
    cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step,
                           cv::AccessFlag flags, cv::UMatUsageFlags usage) const CV_OVERRIDE
    {
        if (!data && isToFail())
            CV_Error(cv::Error::StsNoMem, "no memory, on purpose");
        return cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
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

void* operator new(std::size_t size)
{
    void* const memory = isToFail() ? 0 : std::malloc(size ? size : 1);
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

void operator delete[](void* memory) noexcept
{
    std::free(memory);
}

void operator delete[](void* memory, std::size_t) noexcept
{
    std::free(memory);
}
