// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Prints hashes of the module's results, to compare CPUs, compilers and versions of OpenCV:
//
//   aqorb_fingerprint [--plain] [--quadtree] [IMAGE ...]
//
// One line stands for a scene or an image and a set of parameters. The hashes of the image and of the pyramid show
// whether a difference comes from the input or from the detector. --plain calls cv::setUseOptimized(false). --quadtree
// sets QUADTREE_SELECTION. Standard error lists the CPU features that OpenCV uses.

#include "lines.hpp"

#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include <cstdio>
#include <string>
#include <vector>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

int main(int argc, char** argv)
{
    std::vector<std::string> arguments(argv + 1, argv + argc);
    AdaptiveQuadtreeORB::SelectionType selection = AdaptiveQuadtreeORB::RANKED_SELECTION;
    for (; !arguments.empty() && arguments[0].compare(0, 2, "--") == 0; arguments.erase(arguments.begin()))
    {
        if (arguments[0] == "--plain")
        {
            setUseOptimized(false);
        }
        else if (arguments[0] == "--quadtree")
        {
            selection = AdaptiveQuadtreeORB::QUADTREE_SELECTION;
        }
        else
        {
            std::fprintf(stderr, "%s: --plain or --quadtree is accepted\n", arguments[0].c_str());
            return 1;
        }
    }
    std::fprintf(stderr, "%s, %s%s\n", CV_VERSION, getCPUFeaturesLine().c_str(),
                 useOptimized() ? "" : ", setUseOptimized(false)");

    FingerprintLines lines(selection);
    std::fputs(lines.scenes().c_str(), stdout);
    for (const std::string& file : arguments)
    {
        const Mat image = imread(file, IMREAD_COLOR);
        if (image.empty())
        {
            std::fprintf(stderr, "cannot read %s\n", file.c_str());
            return 1;
        }
        std::fputs(lines.image(file, image).c_str(), stdout);
    }
    return 0;
}
