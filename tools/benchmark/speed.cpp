// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How long a frame takes beside another detector.

#include "benchmark.hpp"
#include "table.hpp"

#include <opencv2/core/utility.hpp>

#include <algorithm>
#include <iostream>

using namespace cv;

void touchOtherMemory()
{
    static std::vector<uint64> words((64 << 20) / sizeof(uint64));
    for (size_t i = 0; i < words.size(); i += 8)  // each cache line
        words[i]++;
}

namespace
{

//! Calls a detector on one image again and again.
class Runner
{
public:
    Runner(const Contender& contender, int n, const Mat& image_, bool cold_)
        : detector(contender.create(n)), image(image_), cold(cold_)
    {
    }

    double operator()()
    {
        if (cold)
            touchOtherMemory();
        return timeFrame(*detector, image, features);
    }

private:
    Ptr<Feature2D> detector;
    Mat image;
    bool cold;
    Features features;
};

}  // namespace

void measureSpeed(const Settings& settings, const Contender& other)
{
    const Contender ours = aqorbHere();
    const std::string ratio = "time of " + other.name + " / time of " + ours.name;
    std::cout << cpuName() << (settings.cold ? ", cold" : "") << "\n\n";
    Table cases({"image", "n", "threads", other.name + ", ms", ours.name + ", ms", ratio});
    Table means({"threads", ratio + ", geometric mean", "lowest", "highest"});
    for (const int threads : settings.threads)
    {
        setNumThreads(threads);
        std::vector<double> ratios;
        for (const std::string& spec : settings.images)
        {
            const Image image(spec);
            for (const int n : settings.numbers)
            {
                double ms[2];
                Runner theirs(other, n, image.pixels, settings.cold),
                    own(ours, n, image.pixels, settings.cold);
                ratios.push_back(medianRatio(std::ref(theirs), std::ref(own), settings.turns, ms));
                cases.add({image.name, std::to_string(n), std::to_string(threads), cell(ms[0]), cell(ms[1]),
                           cell(ratios.back())});
            }
        }
        means.add({std::to_string(threads), cell(geometricMean(ratios), 3),
                   cell(*std::min_element(ratios.begin(), ratios.end())),
                   cell(*std::max_element(ratios.begin(), ratios.end()))});
    }
    std::cout << cases.text() << "\n" << means.text() << std::flush;
}
