// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The heap in use is counted by standing in for malloc and its kin, which glibc provides for.

#include "benchmark.hpp"
#include "table.hpp"

#include <opencv2/core/utility.hpp>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <iostream>

#include <malloc.h>

namespace
{

std::atomic<bool> isCounting(false);  // so that what is timed does not pay for it
std::atomic<int64_t> inUse(0), peak(0);

void* counted(void* block)
{
    if (isCounting)
    {
        const int64_t now = inUse += int64_t(malloc_usable_size(block));
        int64_t before = peak;
        while (before < now && !peak.compare_exchange_weak(before, now))
            ;
    }
    return block;
}

void discount(void* block)
{
    if (isCounting)
        inUse -= int64_t(malloc_usable_size(block));
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

//! Bytes above what was in use before the detector was created, without the outputs.
struct Memory
{
    int64_t first, later;  //!< peaks during the first frame and during the later ones
    int64_t kept;          //!< between frames
};

/** Outputs of a frame that need not grow during it: they have been made before the detector and do not count. cv::ORB
 and AdaptiveQuadtreeORB write to such outputs in place. */
Features madeOutputs(const Contender& contender, const Image& image, int nfeatures)
{
    Features features;
    timeFrame(*contender.create(nfeatures), image.pixels, features);
    return features;
}

Memory measure(const Contender& contender, const Image& image, int nfeatures)
{
    Features features = madeOutputs(contender, image, nfeatures);
    Memory memory;
    const int64_t before = inUse;
    const Ptr<Feature2D> detector = contender.create(nfeatures);
    peak = inUse.load();
    timeFrame(*detector, image.pixels, features);
    memory.first = peak - before;
    peak = inUse.load();
    for (int i = 0; i < LATER_FRAMES; i++)  // which threads take part is chance
        timeFrame(*detector, image.pixels, features);
    memory.later = peak - before;
    memory.kept = inUse - before;
    return memory;
}

}  // namespace

void measureMemory(const Settings& settings, const std::vector<Contender>& contenders)
{
    Table table({"image", "n", "threads", "detector", "first frame", "later frames", "kept"});
    isCounting = true;
    for (const std::string& spec : settings.images)
    {
        const Image image(spec);
        const double pixels = double(image.pixels.total());  // a pixel is a byte
        for (const int n : settings.numbers)
        {
            for (const int threads : settings.threads)
            {
                setNumThreads(threads);
                for (const Contender& contender :
                     contenders)  // for what OpenCV allocates once, such as threads
                    measure(contender, image, n);
                for (const Contender& contender : contenders)
                {
                    const Memory memory = measure(contender, image, n);
                    table.add({image.name, std::to_string(n), std::to_string(threads), contender.name,
                               cell(double(memory.first) / pixels), cell(double(memory.later) / pixels),
                               cell(double(memory.kept) / pixels)});
                }
            }
        }
    }
    std::cout << table.text() << std::flush;
}
