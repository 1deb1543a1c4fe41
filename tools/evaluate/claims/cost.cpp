// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../common/median.hpp"
#include "subjects.hpp"

#include <ctime>

void measureCost(const std::vector<ImageSet>& sets, const std::vector<cv::Ptr<Method>>& methods, int n,
                 int runs, Measurements& results)
{
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1);
    for (const ImageSet& set : sets)
    {
        std::vector<std::vector<double>> times(methods.size());
        for (int run = -1; run < runs; run++)  // the first one warms up
        {
            for (size_t i = 0; i < methods.size(); i++)
            {
                const std::clock_t start = std::clock();
                methods[i]->compute(set.images[0], n);
                if (run >= 0)
                    times[i].push_back(1e3 * double(std::clock() - start) / CLOCKS_PER_SEC);
            }
        }
        for (size_t i = 0; i < methods.size(); i++)
            results.add(
                {"cost", set.name + "/1", methods[i]->name, n, "milliseconds", tools::median(times[i])});
    }
    cv::setNumThreads(threads);
}
