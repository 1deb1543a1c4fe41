// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_TOOLS_MEDIAN_HPP
#define AQORB_TOOLS_MEDIAN_HPP

#include <algorithm>
#include <vector>

namespace tools
{

//! The median; of an even number of values the mean of the middle two, and 0 of none.
inline double median(std::vector<double> values)
{
    if (values.empty())
        return 0;
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace tools

#endif
