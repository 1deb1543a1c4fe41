// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_POOL_HPP
#define OPENCV_AQORB_POOL_HPP

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <vector>

namespace cv
{
namespace aqorb
{

/** Lends objects, each to one user at a time, and keeps them with their memory. So an object that lends its work space
 can serve several threads at once without allocating memory for every image. It does not keep memory for ever: it
 frees objects beyond the number of CPUs, objects that were not among the last KEPT_CALLS loans, and an object that
 served a much larger image than the last KEPT_CALLS ones. */
template <typename T> class Pool
{
    //! An object, and when it was lent.
    struct Entry
    {
        Ptr<T> object;
        size_t largest = 0;  // that the object was lent for
        int smaller = 0;     // loans since one of at least half of that size
        uint64 loan = 0;     // the last one
    };

public:
    enum
    {
        KEPT_CALLS = 64
    };

    //! A loan, which ends with the scope.
    class Lease
    {
    public:
        //! @param size of what the object is needed for, in any unit
        Lease(Pool& pool_, size_t size) : pool(pool_), lent(pool.take(size)) {}
        ~Lease() { pool.give(lent); }
        T& operator*() const { return *lent.object; }

    private:
        Lease(const Lease&);
        Lease& operator=(const Lease&);

        Pool& pool;
        Entry lent;
    };

    //! Frees the objects that are not lent.
    void clear()
    {
        AutoLock lock(mutex);
        idle.clear();
    }

private:
    Entry take(size_t size)
    {
        AutoLock lock(mutex);
        // So that giving back, which a destructor does, cannot fail.
        idle.reserve(std::max(idle.size(), size_t(1)) + lentCount);
        Entry lent;
        if (!idle.empty())
        {
            lent = idle.back();
            idle.pop_back();
        }
        lent.smaller = size >= lent.largest / 2 ? 0 : lent.smaller + 1;
        if (!lent.object || lent.smaller == KEPT_CALLS)
        {
            lent = Entry();
            lent.object = makePtr<T>();
        }
        lent.largest = std::max(lent.largest, size);
        lent.loan = ++loans;
        lentCount++;
        return lent;
    }
    void give(const Entry& lent)
    {
        AutoLock lock(mutex);
        idle.push_back(lent);
        lentCount--;
        // The last one given is lent first, so that the first one has been idle for the longest time.
        if (idle.size() > size_t(std::max(getNumberOfCPUs(), 1)) ||
            loans - idle.front().loan > uint64(KEPT_CALLS))
            idle.erase(idle.begin());
    }

    Mutex mutex;
    size_t lentCount = 0;
    uint64 loans = 0;
    std::vector<Entry> idle;
};

}  // namespace aqorb
}  // namespace cv

#endif
