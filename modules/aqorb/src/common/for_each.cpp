// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Which threads a call may use.

#include "precomp.hpp"

#include "common/for_each.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

// Number of open SingleThreadScopes of this thread. A scope that outlives its thread keeps the counter alive.
static const std::shared_ptr<std::atomic<int>>& threadScopes()
{
    static thread_local const auto scopes = std::make_shared<std::atomic<int>>(0);
    return scopes;
}

SingleThreadScope::SingleThreadScope() : scopes(threadScopes())
{
    ++*scopes;
}

SingleThreadScope::~SingleThreadScope()
{
    --*scopes;
}

int threadsAllowed()
{
    return *threadScopes() > 0 ? 1 : std::max(getNumThreads(), 1);
}

}  // namespace aqorb
}  // namespace cv
