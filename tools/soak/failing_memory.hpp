// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_SOAK_FAILING_MEMORY_HPP
#define OPENCV_AQORB_SOAK_FAILING_MEMORY_HPP

// operator new and the memory of matrices, made to fail. The program's operator new serves the libraries
// that it loads, too.

namespace soak
{

//! Lets the allocation number `countdown` from now on fail, on any thread; once, and 0 for none.
void failAllocation(long countdown);

//! Allocations since the last failAllocation.
long allocationsSince();

}  // namespace soak

#endif
