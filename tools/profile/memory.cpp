// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The heap in use is counted by standing in for malloc and its kin, which glibc provides for.

#include "measure.hpp"

#include <opencv2/core/utility.hpp>

#include <atomic>
#include <cerrno>

#include <malloc.h>

namespace
{

std::atomic<size_t> inUse(0), peak(0);

void* counted(void* block)
{
    const size_t now = inUse += malloc_usable_size(block);
    size_t before = peak;
    while (before < now && !peak.compare_exchange_weak(before, now))
        ;
    return block;
}

void discount(void* block)
{
    inUse -= malloc_usable_size(block);
}

}  // namespace

extern "C"
{
    void* __libc_malloc(size_t size);
    void* __libc_calloc(size_t count, size_t size);
    void* __libc_realloc(void* block, size_t size);
    void* __libc_memalign(size_t alignment, size_t size);
    void __libc_free(void* block);

    void* malloc(size_t size) noexcept
    {
        return counted(__libc_malloc(size));
    }
    void* calloc(size_t count, size_t size) noexcept
    {
        return counted(__libc_calloc(count, size));
    }
    void* realloc(void* block, size_t size) noexcept
    {
        discount(block);
        return counted(__libc_realloc(block, size));
    }
    void* memalign(size_t alignment, size_t size) noexcept
    {
        return counted(__libc_memalign(alignment, size));
    }
    void* aligned_alloc(size_t alignment, size_t size) noexcept
    {
        return memalign(alignment, size);
    }
    int posix_memalign(void** block, size_t alignment, size_t size) noexcept
    {
        *block = memalign(alignment, size);
        return *block ? 0 : ENOMEM;
    }
    void free(void* block) noexcept
    {
        discount(block);
        __libc_free(block);
    }
}

namespace
{
using namespace cv;

const int LATER_FRAMES = 20;

//! Bytes above what was in use before the detector was created.
struct Memory
{
    size_t first, later;  //!< peaks during the first frame and during the later ones
    size_t kept;          //!< after them, without their outputs
};

Memory measure(Detector id, const Image& image, int nfeatures)
{
    Memory memory;
    const size_t before = inUse;
    const Ptr<Feature2D> detector = createDetector(id, nfeatures);
    Features features;
    peak = inUse.load();
    timeFrame(*detector, image.pixels, features);
    memory.first = peak - before;
    features = Features();
    peak = inUse.load();
    for (int i = 0; i < LATER_FRAMES; i++)  // which threads take part is chance
        timeFrame(*detector, image.pixels, features);
    memory.later = peak - before;
    features = Features();
    memory.kept = inUse - before;
    return memory;
}

}  // namespace

tools::CsvTable measureMemory(const Settings& settings)
{
    tools::CsvTable table({"image", "pixels", "threads", "detector", "first", "later", "kept"});
    for (const std::string& spec : settings.images)
    {
        const Image image(spec);
        for (int threads = 1; threads <= std::min(getNumberOfCPUs(), 2); threads++)
        {
            setNumThreads(threads);
            for (Detector id : {AQORB, CV_ORB})  // for what OpenCV allocates once, such as threads
                measure(id, image, settings.nfeatures);
            for (Detector id : {AQORB, CV_ORB})
            {
                const Memory memory = measure(id, image, settings.nfeatures);
                table.add({image.name, std::to_string(image.pixels.total()), std::to_string(threads),
                           nameOf(id), std::to_string(memory.first), std::to_string(memory.later),
                           std::to_string(memory.kept)});
            }
        }
    }
    return table;
}
