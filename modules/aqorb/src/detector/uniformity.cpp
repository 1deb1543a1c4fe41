// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Uniformity of the distribution of keypoints of any detector.

#include "precomp.hpp"

#include "detector/arguments.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

double distributionUniformity(const std::vector<KeyPoint>& keypoints, Size imageSize)
{
    checkImageSize(imageSize);
    const double W = imageSize.width, H = imageSize.height;
    const int HALVINGS = 5;
    int64 first[HALVINGS] = {};  // keypoints in the first region of each halving
    int64 count = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const double x = keypoints[i].pt.x, y = keypoints[i].pt.y;
        if (!std::isfinite(x) || !std::isfinite(y))
            continue;
        count++;
        first[0] += x <= W / 2;
        first[1] += y <= H / 2;
        first[2] += y * W - x * H < 0;          // above the main diagonal
        first[3] += y * W + x * H - W * H < 0;  // above the other diagonal
        // in the centred rectangle of half the area
        first[4] +=
            std::abs(x - W / 2) <= W / (2 * std::sqrt(2.)) && std::abs(y - H / 2) <= H / (2 * std::sqrt(2.));
    }
    // Both counts of a halving deviate equally from their mean, count / 2.
    double squares = 0;
    for (int i = 0; i < HALVINGS; i++)
    {
        const double deviation = first[i] - count / 2.;
        squares += deviation * deviation;
    }
    const double sigma = std::sqrt(squares / HALVINGS);
    return 101 * std::log10(std::max(sigma, 1.));
}

double distributionOccupancy(const std::vector<KeyPoint>& keypoints, Size imageSize, Size grid)
{
    checkImageSize(imageSize);
    if (grid.width <= 0 || grid.height <= 0 || int64(grid.width) * grid.height > (1 << 24))
        CV_Error_(Error::StsOutOfRange, ("grid must be positive and have at most 2^24 cells, got %d x %d",
                                         grid.width, grid.height));
    std::vector<uchar> occupied(size_t(grid.width) * grid.height, uchar(0));
    size_t cells = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const double x = keypoints[i].pt.x, y = keypoints[i].pt.y;
        if (!(x >= 0 && y >= 0 && x < imageSize.width && y < imageSize.height))
            continue;
        const int column = int(x * grid.width / imageSize.width);
        const int row = int(y * grid.height / imageSize.height);
        uchar& cell = occupied[size_t(row) * grid.width + column];
        cells += !cell;
        cell = 1;
    }
    return double(cells) / double(occupied.size());
}

}  // namespace aqorb
}  // namespace cv
