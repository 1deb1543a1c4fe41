// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "scenes.hpp"

using namespace cv;

namespace tools
{

Mat makeIntegerScene(Size size, int channels, uint64 seed)
{
    RNG rng(seed);
    Mat scene(size, CV_8UC(channels));
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width * channels; x++)
            scene.ptr(y)[x] = uchar(60 + 80 * x / (size.width * channels) + 40 * y / size.height);
    }
    for (int i = 0; i < size.area() / 900; i++)
    {
        // Braces: they have an order of evaluation.
        const Rect rect{rng.uniform(0, size.width), rng.uniform(0, size.height), rng.uniform(3, 30),
                        rng.uniform(3, 30)};
        const Scalar colour{double(rng.uniform(0, 256)), double(rng.uniform(0, 256)),
                            double(rng.uniform(0, 256)), 255};
        scene(rect & Rect(Point(), size)).setTo(colour);
    }
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width * channels; x++)
        {
            const int noise = x < size.width * channels / 3 ? 30 : 3;
            uchar& value = scene.ptr(y)[x];
            value = saturate_cast<uchar>(value + rng.uniform(-noise, noise + 1));
        }
    }
    return scene;
}

}  // namespace tools
