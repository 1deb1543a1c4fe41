// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

#include "orientation.hpp"

#include <opencv2/imgproc.hpp>

#include <numeric>

// The keypoint distribution of ORB_SLAM (Mur-Artal et al. 2015), the paper's column B, written from its
// description: FAST with threshold 20 in cells, and with threshold 7 in those that stay empty. Then a quadtree
// is split until it has as many nodes as the level is to have keypoints. The paper names no thresholds; these
// are the usual ones of ORB_SLAM.

namespace
{

namespace aqorb = cv::aqorb;

typedef std::vector<cv::KeyPoint> KeyPoints;

const int LEVELS = 8;
const float SCALE_FACTOR = 1.2f;
const int PATCH_SIZE = 31;
const int BORDER = 16, CELL = 30, OVERLAP = 3;  // pixels of the level
const int INITIAL_THRESHOLD = 20, MINIMUM_THRESHOLD = 7;

//! Corners of a level, cell by cell.
KeyPoints detectInCells(const cv::Mat& level)
{
    const cv::Rect region(BORDER, BORDER, level.cols - 2 * BORDER, level.rows - 2 * BORDER);
    KeyPoints corners, inCell;
    if (region.width <= 0 || region.height <= 0)
        return corners;
    const int columns = std::max(region.width / CELL, 1), rows = std::max(region.height / CELL, 1);
    const int width = (region.width + columns - 1) / columns, height = (region.height + rows - 1) / rows;
    for (int y = region.y; y < region.br().y; y += height)
        for (int x = region.x; x < region.br().x; x += width)
        {
            const cv::Rect cell =
                cv::Rect(x - OVERLAP, y - OVERLAP, width + 2 * OVERLAP, height + 2 * OVERLAP) & region;
            cv::FAST(level(cell), inCell, INITIAL_THRESHOLD, true);
            if (inCell.empty())
                cv::FAST(level(cell), inCell, MINIMUM_THRESHOLD, true);
            for (cv::KeyPoint& corner : inCell)
            {
                corner.pt += cv::Point2f(cell.tl());
                corners.push_back(corner);
            }
        }
    return corners;
}

struct Node
{
    cv::Rect2f area;
    KeyPoints points;
};

//! The children of a node that hold a keypoint.
std::vector<Node> split(const Node& node)
{
    const cv::Size2f half(node.area.width / 2, node.area.height / 2);
    const cv::Point2f centre(node.area.x + half.width, node.area.y + half.height);
    std::vector<Node> children(4);
    for (int i = 0; i < 4; i++)
        children[i].area = cv::Rect2f(i % 2 ? centre.x : node.area.x, i / 2 ? centre.y : node.area.y,
                                      half.width, half.height);
    for (const cv::KeyPoint& point : node.points)
        children[(point.pt.x >= centre.x) + 2 * (point.pt.y >= centre.y)].points.push_back(point);
    children.erase(std::remove_if(children.begin(), children.end(),
                                  [](const Node& child) { return child.points.empty(); }),
                   children.end());
    return children;
}

bool splits(const Node& node)
{
    // Keypoints on the same pixel could never be separated. FAST does not give such, but the loop must end.
    return node.points.size() > 1 && node.area.width > 1e-3f;
}

//! Splits the level into about as many nodes as the quota and takes one keypoint from each.
KeyPoints distribute(const KeyPoints& corners, cv::Size size, int quota)
{
    const cv::Size2f region(float(size.width - 2 * BORDER), float(size.height - 2 * BORDER));
    const int roots = std::max(cvRound(region.width / region.height), 1);
    const float rootWidth = region.width / roots;
    std::vector<Node> nodes(roots);
    for (int i = 0; i < roots; i++)
        nodes[i].area = cv::Rect2f(BORDER + i * rootWidth, BORDER, rootWidth, region.height);
    for (const cv::KeyPoint& corner : corners)
        nodes[std::min(int((corner.pt.x - BORDER) / rootWidth), roots - 1)].points.push_back(corner);
    nodes.erase(
        std::remove_if(nodes.begin(), nodes.end(), [](const Node& node) { return node.points.empty(); }),
        nodes.end());

    while (int(nodes.size()) < quota)
    {
        // The nodes to be split come first, in descending order of their number of keypoints.
        const auto end = std::stable_partition(nodes.begin(), nodes.end(), splits);
        const int splittable = int(end - nodes.begin());
        if (splittable == 0)
            break;
        std::stable_sort(nodes.begin(), end,
                         [](const Node& a, const Node& b) { return a.points.size() > b.points.size(); });
        const bool oneByOne = int(nodes.size()) + 3 * splittable > quota;
        std::vector<Node> next;
        int count = int(nodes.size());
        for (int i = 0; i < int(nodes.size()); i++)
        {
            if (i >= splittable || (oneByOne && count >= quota))
            {
                next.push_back(std::move(nodes[i]));
                continue;
            }
            for (Node& child : split(nodes[i]))
            {
                next.push_back(std::move(child));
                count++;
            }
            count--;
        }
        nodes.swap(next);
    }

    KeyPoints best;
    for (const Node& node : nodes)
        best.push_back(*std::max_element(node.points.begin(), node.points.end(),
                                         [](const cv::KeyPoint& a, const cv::KeyPoint& b)
                                         { return a.response < b.response; }));
    return best;
}

//! Number of keypoints of each level, equation (8).
std::vector<int> quotas(int n)
{
    const double ratio = 1 / double(SCALE_FACTOR);
    double share = n * (1 - ratio) / (1 - std::pow(ratio, LEVELS));
    std::vector<int> result;
    for (int level = 0; level < LEVELS - 1; level++, share *= ratio)
        result.push_back(cvRound(share));
    result.push_back(std::max(n - std::accumulate(result.begin(), result.end(), 0), 0));
    return result;
}

class OrbSlam : public Method
{
public:
    Features compute(const cv::Mat& image, int n) override
    {
        cv::Mat level = grayOf(image);
        const cv::Size size = level.size();
        const std::vector<int> quota = quotas(n);
        Features features;
        float scale = 1;
        for (int octave = 0; octave < LEVELS; octave++, scale *= SCALE_FACTOR)
        {
            if (octave > 0)
            {
                cv::Mat smaller;
                cv::resize(level, smaller,
                           cv::Size(cvRound(size.width / scale), cvRound(size.height / scale)), 0, 0,
                           cv::INTER_LINEAR);
                level = smaller;
            }
            KeyPoints points = distribute(detectInCells(level), level.size(), quota[octave]);
            for (cv::KeyPoint& point : points)
            {
                aqorb::FeaturePoint centre = {int(point.pt.x), int(point.pt.y), 0};
                aqorb::orientations(level, patch, &centre, 1);
                point.angle = centre.angle;
                point.size = float(PATCH_SIZE);
            }
            cv::Mat descriptors;
            describe->compute(level, points, descriptors);
            for (cv::KeyPoint& point : points)
            {
                point.pt *= scale;
                point.size *= scale;
                point.octave = octave;
                features.keypoints.push_back(point);
            }
            features.descriptors.push_back(descriptors);
        }
        return features;
    }

private:
    const aqorb::OrientationPatch patch{aqorb::circularPatch(PATCH_SIZE)};
    // cv::ORB's descriptor on one level.
    cv::Ptr<cv::ORB> describe = cv::ORB::create(1, SCALE_FACTOR, 1, BORDER);
};

}  // namespace

cv::Ptr<Method> makeOrbSlam()
{
    return cv::makePtr<OrbSlam>();
}
