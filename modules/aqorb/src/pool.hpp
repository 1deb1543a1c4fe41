// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_POOL_HPP
#define OPENCV_AQORB_POOL_HPP

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include <vector>

namespace cv
{
namespace aqorb
{

/** Lends objects, each to one user at a time, and keeps them with their memory. So an object that lends its work space
 can serve several threads at once without allocating memory for every image. */
template <typename T> class Pool
{
public:
    Pool() : made(0) {}

    //! A loan, which ends with the scope.
    class Lease
    {
    public:
        explicit Lease(Pool& pool_) : pool(pool_), lent(pool.take()) {}
        ~Lease() { pool.give(lent); }
        T& operator*() const { return *lent; }

    private:
        Lease(const Lease&);
        Lease& operator=(const Lease&);

        Pool& pool;
        Ptr<T> lent;
    };

private:
    Ptr<T> take()
    {
        AutoLock lock(mutex);
        if (idle.empty())
        {
            idle.reserve(++made);  // so that giving back, which a destructor does, cannot fail
            return makePtr<T>();
        }
        const Ptr<T> lent = idle.back();
        idle.pop_back();
        return lent;
    }
    void give(const Ptr<T>& lent)
    {
        AutoLock lock(mutex);
        idle.push_back(lent);
    }

    Mutex mutex;
    size_t made;
    std::vector<Ptr<T>> idle;
};

}  // namespace aqorb
}  // namespace cv

#endif
