// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_ALLOCATIONS_HPP
#define OPENCV_AQORB_TEST_ALLOCATIONS_HPP

namespace opencv_test
{

/** Counts allocations of memory and their bytes while it lives, on all threads, and lets one of them fail on request.
 A program that compiles allocations.cpp has its operator new, which serves the libraries that it loads, too.
 OpenCV takes two allocations for a matrix, and would lose the first if the second one failed; here they are
 one. There may be one such object at a time. */
class AllocationCounter
{
public:
    /** @param failing the number, from 1, of the allocation that fails; 0: none does. Those of the calling thread
     count, and those of threads that have called letThreadFail. OpenCV would end the program if one failed while it
     starts a thread. */
    explicit AllocationCounter(long failing = 0);
    ~AllocationCounter();
    static void letThreadFail();

    //! Allocations of a matrix's data.
    long ofMatrices() const;

    //! Whether bytes are counted here: the C library must tell the size of a block.
    static bool countsBytes();
    //! Bytes in use, less those in use when the counter was made.
    long long bytes() const;
    //! The most that bytes() has been since the counter was made, or since beginPeak.
    long long peakBytes() const;
    void beginPeak();

private:
    AllocationCounter(const AllocationCounter&);
    AllocationCounter& operator=(const AllocationCounter&);
};

}  // namespace opencv_test

#endif
