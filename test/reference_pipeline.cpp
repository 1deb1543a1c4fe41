// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include <map>
#include <numeric>

namespace opencv_test
{

::testing::AssertionResult sameCorners(const std::vector<aqorb::stages::Corner>& a,
                                       const std::vector<aqorb::stages::Corner>& b)
{
    for (size_t i = 0; i < std::min(a.size(), b.size()); i++)
    {
        if (a[i].x != b[i].x || a[i].y != b[i].y || a[i].score != b[i].score)
            return ::testing::AssertionFailure()
                   << "corner " << i << ": (" << a[i].x << ", " << a[i].y << ") score " << a[i].score
                   << " against (" << b[i].x << ", " << b[i].y << ") score " << b[i].score;
    }
    if (a.size() != b.size())
        return ::testing::AssertionFailure() << a.size() << " corners against " << b.size();
    return ::testing::AssertionSuccess();
}

namespace reference
{

Ptr<AdaptiveQuadtreeORB> Settings::create() const
{
    const Ptr<AdaptiveQuadtreeORB> detector =
        AdaptiveQuadtreeORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K,
                                    scoreType, patchSize, fastThreshold);
    detector->setAdaptiveThreshold(adaptiveThreshold);
    detector->setMinThresholdRatio(minThresholdRatio);
    detector->setCellSize(cellSize);
    detector->setMaxDepth(maxDepth);
    detector->setSelectionType(selectionType);
    detector->setStrengthWeight(strengthWeight);
    detector->setRankRadius(rankRadius);
    detector->setOctaveSuppression(octaveSuppression);
    detector->setSubPixel(subPixel);
    return detector;
}

double Settings::octaveSuppressionInUse() const
{
    if (octaveSuppression != -1)
        return octaveSuppression;
    return selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION ? 0.6 : 0.5;
}

int quadtreeDepth(int quota)
{
    int depth = 0;
    for (double leaves = 1; leaves < quota && depth < 15; leaves *= 4)
        depth++;
    return depth;
}

unsigned leafCode(unsigned column, unsigned row)
{
    unsigned code = 0;
    for (int bit = 0; bit < 16; bit++)
        code |= (column >> bit & 1) << (2 * bit) | (row >> bit & 1) << (2 * bit + 1);
    return code;
}

static bool ranksBefore(const LeafPoint& a, const LeafPoint& b)
{
    if (cvIsNaN(a.response) != cvIsNaN(b.response))
        return cvIsNaN(b.response) != 0;
    if (!cvIsNaN(a.response) && a.response != b.response)
        return a.response > b.response;
    if (a.y != b.y)
        return a.y < b.y;
    return a.x != b.x ? a.x < b.x : a.index < b.index;
}

std::vector<LeafPoint> balancedSequence(const std::vector<LeafPoint>& points, int depth)
{
    typedef std::vector<LeafPoint> Points;
    std::map<unsigned, Points> leaves;
    for (size_t i = 0; i < points.size(); i++)
        leaves[points[i].leaf].push_back(points[i]);

    // A group's list: the best of each of its leaves, then the second best of each, ...
    std::map<unsigned, std::vector<Points>> roundsOfGroup;
    for (std::map<unsigned, Points>::iterator leaf = leaves.begin(); leaf != leaves.end(); ++leaf)
    {
        std::sort(leaf->second.begin(), leaf->second.end(), ranksBefore);
        std::vector<Points>& rounds = roundsOfGroup[leaf->first >> (2 * std::min(depth, 2))];
        rounds.resize(std::max(rounds.size(), leaf->second.size()));
        for (size_t i = 0; i < leaf->second.size(); i++)
            rounds[i].push_back(leaf->second[i]);
    }
    // The sequence: the first of every group, then the second of every group, ...
    std::vector<Points> roundsOfAll(points.size());
    for (std::map<unsigned, std::vector<Points>>::iterator group = roundsOfGroup.begin();
         group != roundsOfGroup.end(); ++group)
    {
        size_t place = 0;
        for (size_t i = 0; i < group->second.size(); i++)
        {
            Points& round = group->second[i];
            std::sort(round.begin(), round.end(), ranksBefore);
            for (size_t j = 0; j < round.size(); j++)
                roundsOfAll[place++].push_back(round[j]);
        }
    }
    Points sequence;
    for (size_t i = 0; i < roundsOfAll.size(); i++)
    {
        std::sort(roundsOfAll[i].begin(), roundsOfAll[i].end(), ranksBefore);
        sequence.insert(sequence.end(), roundsOfAll[i].begin(), roundsOfAll[i].end());
    }
    return sequence;
}

namespace
{

struct PyramidLevel
{
    Mat image, mask;
    float scale;
    int quota, depth;
    Rect root;
    Corners corners;
    std::vector<RankedCorner> candidates, passedOver, chosen;
    std::vector<LeafPoint> sequence;
    size_t next;  // of the sequence
    bool begun;
};

bool inRasterOrder(const RankedCorner& a, const RankedCorner& b)
{
    return a.y != b.y ? a.y < b.y : a.x < b.x;
}

class Pipeline
{
public:
    Pipeline(const Mat& gray_, const Mat& mask_, const Settings& settings)
        : gray(gray_), mask(mask_), s(settings), isHarris(settings.scoreType == ORB::HARRIS_SCORE)
    {
    }
    Features run()
    {
        buildPyramid();
        select();
        Features features;
        for (size_t i = 0; i < levels.size(); i++)
            describe(int(i), features);
        return features;
    }

private:
    void buildPyramid()
    {
        const double scaleFactor = s.scaleFactor;
        const std::vector<int> quotaOfLevel = quotas(s.nfeatures, scaleFactor, s.nlevels);
        const Thresholds t = thresholds(varianceOverMean(gray, mask), s.adaptiveThreshold, s.fastThreshold,
                                        s.minThresholdRatio);
        int unused = 0;  // quota of levels that are too small
        for (int i = 0; i < s.nlevels; i++)
        {
            PyramidLevel level;
            level.scale = levelScale(i, s.firstLevel, scaleFactor);
            const Size size = levelSize(gray.size(), level.scale);
            if (std::min(size.width, size.height) < 2 * std::max(s.edgeThreshold, 3) + 1)
            {
                unused = std::accumulate(quotaOfLevel.begin() + i, quotaOfLevel.end(), 0);
                break;
            }
            level.image = gray;
            level.mask = mask;
            if (i != s.firstLevel)
            {
                const Mat& from = i <= s.firstLevel + 1 ? gray : levels[i - 1].image;
                Mat resized;
                cv::resize(from, resized, size, 0, 0, INTER_LINEAR_EXACT);
                level.image = resized;
                if (!mask.empty())
                    level.mask = resizeMask(i <= s.firstLevel + 1 ? mask : levels[i - 1].mask, size);
            }
            level.quota = quotaOfLevel[i];
            level.depth = s.maxDepth >= 0 ? s.maxDepth : quadtreeDepth(level.quota);
            level.root = Rect(s.edgeThreshold, s.edgeThreshold, size.width - 2 * s.edgeThreshold,
                              size.height - 2 * s.edgeThreshold);
            level.corners = findCorners(level.image, usableMask(level), level.root, t, s.cellSize, isHarris);
            level.begun = false;
            level.next = 0;
            levels.push_back(level);
        }
        if (!levels.empty())
            levels.back().quota += unused;
    }

    Point2f positionOf(const PyramidLevel& level, int x, int y, Point2d d) const
    {
        return position(x, y, d, gray.size(), level.image.size(), level.scale, s.edgeThreshold, s.subPixel);
    }

    bool usablePosition(const PyramidLevel& level, int x, int y, Point2f& p) const
    {
        return reference::usablePosition(mask, x, y, level.image.size(), level.scale, s.edgeThreshold,
                                         s.subPixel, p);
    }

    // The level's mask without the pixels that have no usable position in the image. (Levels made from this
    // one have positions of their own.)
    Mat usableMask(const PyramidLevel& level) const
    {
        Mat usable = level.mask.clone();
        for (int y = 3; y < level.mask.rows - 3; y++)
        {
            for (int x = 3; x < level.mask.cols - 3; x++)
            {
                Point2f p;
                if (usable.at<uchar>(y, x) && !usablePosition(level, x, y, p))
                    usable.at<uchar>(y, x) = 0;
            }
        }
        return usable;
    }

    std::vector<RankedCorner> rank(const PyramidLevel& level, const std::vector<Corner>& corners) const
    {
        std::vector<RankedCorner> ranked;
        for (size_t i = 0; i < corners.size(); i++)
        {
            const Corner& c = corners[i];
            const RankedCorner corner = {c.x, c.y,
                                         isHarris ? harrisResponse(level.image, c.x, c.y) : (float)c.score};
            ranked.push_back(corner);
        }
        return ranked;
    }

    Point2d exactPosition(const PyramidLevel& level, const RankedCorner& c) const
    {
        return Point2d((c.x + 0.5) * gray.cols / level.image.cols - 0.5,
                       (c.y + 0.5) * gray.rows / level.image.rows - 0.5);
    }
    bool isNearOther(size_t index, const RankedCorner& corner) const
    {
        const Point2d p = exactPosition(levels[index], corner);
        const double radius = s.octaveSuppressionInUse() * levels[index].scale;
        for (size_t i = 0; i < levels.size(); i++)
        {
            for (size_t j = 0; i != index && j < levels[i].chosen.size(); j++)
            {
                const Point2d d = exactPosition(levels[i], levels[i].chosen[j]) - p;
                if (d.x * d.x + d.y * d.y < radius * radius)
                    return true;
            }
        }
        return false;
    }

    static std::vector<LeafPoint> sequenceOf(const PyramidLevel& level, const std::vector<RankedCorner>& of)
    {
        std::vector<LeafPoint> points;
        for (size_t i = 0; i < of.size(); i++)
        {
            const int64 column = (int64(of[i].x - level.root.x) << level.depth) / level.root.width;
            const int64 row = (int64(of[i].y - level.root.y) << level.depth) / level.root.height;
            const LeafPoint point = {leafCode(unsigned(column), unsigned(row)), of[i].response,
                                     float(of[i].x), float(of[i].y), int(i)};
            points.push_back(point);
        }
        return balancedSequence(points, level.depth);
    }

    // Takes up to `wanted` more of a level's sequence; returns how many are still wanted.
    int choose(size_t index, int wanted)
    {
        PyramidLevel& level = levels[index];
        if (wanted == 0)
            return 0;
        if (!level.begun)
        {
            level.begun = true;
            const std::vector<RankedCorner> all = rank(level, level.corners.kept);
            for (size_t i = 0; i < all.size(); i++)
                (isNearOther(index, all[i]) ? level.passedOver : level.candidates).push_back(all[i]);
            level.sequence = sequenceOf(level, level.candidates);
        }
        for (; wanted > 0 && level.next < level.sequence.size(); level.next++)
        {
            const RankedCorner& corner = level.candidates[level.sequence[level.next].index];
            if (isNearOther(index, corner))
            {
                level.passedOver.push_back(corner);
            }
            else
            {
                level.chosen.push_back(corner);
                wanted--;
            }
        }
        return wanted;
    }

    static int fill(PyramidLevel& level, const std::vector<RankedCorner>& from, int wanted)
    {
        const std::vector<LeafPoint> sequence = sequenceOf(level, from);
        for (size_t i = 0; i < sequence.size() && wanted > 0; i++, wanted--)
            level.chosen.push_back(from[sequence[i].index]);
        return wanted;
    }

    void select()
    {
        int wanted = 0;
        for (size_t i = levels.size(); i-- > 0;)
            wanted = choose(i, wanted + levels[i].quota);
        for (size_t i = 0; i < levels.size(); i++)
            wanted = choose(i, wanted);
        for (size_t i = 0; i < levels.size(); i++)
            wanted = fill(levels[i], levels[i].passedOver, wanted);
        for (size_t i = 0; i < levels.size(); i++)
            wanted = fill(levels[i], rank(levels[i], levels[i].corners.suppressed), wanted);
        for (size_t i = 0; i < levels.size(); i++)
            wanted = fill(levels[i], rank(levels[i], levels[i].corners.weak), wanted);
    }

    void describe(int octave, Features& features)
    {
        PyramidLevel& level = levels[octave];
        std::sort(level.chosen.begin(), level.chosen.end(), inRasterOrder);
        const Mat blurred = roundedBlur(level.image);
        const std::vector<Point> pattern = descriptorPattern(s.patchSize, s.WTA_K);
        for (size_t i = 0; i < level.chosen.size(); i++)
        {
            const RankedCorner& c = level.chosen[i];
            Point2f p = positionOf(level, c.x, c.y, Point2d());
            if (s.subPixel)
            {
                const Point2f refined = positionOf(level, c.x, c.y, subPixelOffset(level.image, c.x, c.y));
                if (mask.empty() || mask.at<uchar>(cvRound(refined.y), cvRound(refined.x)))
                    p = refined;
                else
                    usablePosition(level, c.x, c.y, p);
            }
            const float angle = orientation(level.image, c.x, c.y, s.patchSize);
            features.keypoints.push_back(
                KeyPoint(p, s.patchSize * level.scale, angle, c.response, octave, -1));
            Mat row(1, 32, CV_8UC1);
            descriptor(level.image, blurred, Point(c.x, c.y), angle, pattern, s.WTA_K, row.ptr());
            features.descriptors.push_back(row);
        }
    }

    const Mat gray, mask;
    const Settings s;
    const bool isHarris;
    std::vector<PyramidLevel> levels;
};

}  // namespace

Features detectAndCompute(const Mat& image, const Mat& mask, const Settings& settings)
{
    Mat gray = image;
    if (image.channels() != 1)
        cvtColor(image, gray, COLOR_BGR2GRAY);
    return Pipeline(gray, mask, settings).run();
}

}  // namespace reference
}  // namespace opencv_test
