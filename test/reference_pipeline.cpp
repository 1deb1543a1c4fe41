// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The path of an image through all steps, point by point: Pipeline::run. Points 7 and 8 of doc/selection.md are take and
// fillUp.

#include "reference.hpp"

#include <map>
#include <numeric>
#include <set>

namespace opencv_test
{

::testing::AssertionResult sameCorners(const std::vector<aqorb::Corner>& a,
                                       const std::vector<aqorb::Corner>& b)
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

void Settings::set(AdaptiveQuadtreeORB& detector) const
{
#define AQORB_SET(property, type, name, ...) detector.set##property(name);
    AQORB_PARAMETERS(AQORB_SET)
#undef AQORB_SET
}

Ptr<AdaptiveQuadtreeORB> Settings::create() const
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
    set(*detector);
    return detector;
}

std::string Settings::text() const
{
    std::string text;
#define AQORB_TEXT(property, type, name, ...) text += format(" " #name " %.17g", double(name));
    AQORB_PARAMETERS(AQORB_TEXT)
#undef AQORB_TEXT
    return text;
}

Ptr<ORB> Settings::createOrb() const
{
    return ORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K, scoreType,
                       patchSize, fastThreshold);
}

Settings randomSettings(RNG& rng)
{
    Settings s;
    s.nfeatures = rng.uniform(0, 3) ? rng.uniform(0, 120) : rng.uniform(0, 3000);
    s.scaleFactor = rng.uniform(1.05f, 2.f);
    s.nlevels = rng.uniform(1, 7);
    s.firstLevel = rng.uniform(0, 4) ? 0 : rng.uniform(0, std::min(s.nlevels, 2));
    s.edgeThreshold = rng.uniform(0, 25);
    s.WTA_K = rng.uniform(2, 5);
    s.scoreType = rng.uniform(0, 2) ? ORB::HARRIS_SCORE : ORB::FAST_SCORE;
    s.patchSize = rng.uniform(2, 45);
    s.fastThreshold = rng.uniform(0, 40);
    s.adaptiveThreshold = rng.uniform(0, 2) != 0;
    s.minThresholdRatio = rng.uniform(0, 3) ? rng.uniform(1., 8.) : 1;
    s.selectionType =
        rng.uniform(0, 4) ? AdaptiveQuadtreeORB::RANKED_SELECTION : AdaptiveQuadtreeORB::QUADTREE_SELECTION;
    const double weights[] = {0, 0.15, rng.uniform(0., 1.), 1000}, radii[] = {0, 1, rng.uniform(0., 4.), 16};
    s.strengthWeight = weights[rng.uniform(0, 4)];
    s.rankRadius = radii[rng.uniform(0, 4)];
    const double distances[] = {-1, 0, rng.uniform(0., 4.), rng.uniform(0., 1.)};
    s.octaveSuppression = distances[rng.uniform(0, 4)];
    s.subPixel = rng.uniform(0, 2) != 0;
    return s;
}

double Settings::octaveSuppressionInUse() const
{
    if (selectionType == AdaptiveQuadtreeORB::QUADTREE_SELECTION)
        return 0;
    return octaveSuppression == -1 ? 2.1 / (1 + strengthWeight) : octaveSuppression;
}

namespace
{

// A corner with its FAST score and with the response that its keypoint gets.
struct Candidate
{
    int x, y, score;
    float response;
};

struct PyramidLevel
{
    Mat image, mask;
    Mat usable;  // the mask without the pixels that have no usable position in the image
    float scale;
    int quota;     // with that of levels that are too small
    int ownQuota;  // without that, but at least 1
    LeafGrid grid;
    double usableShare;  // of the pixels of the root
    Rect root;
    std::vector<Candidate> candidates, selected;
    std::vector<int> ordered;  // indices of candidates
    size_t next;               // of these
};

bool inRasterOrder(const Candidate& a, const Candidate& b)
{
    return a.y != b.y ? a.y < b.y : a.x < b.x;
}
bool hasHigherResponse(const Candidate& a, const Candidate& b)
{
    return a.response > b.response;
}

class Pipeline
{
public:
    Pipeline(const Mat& gray_, const Mat& mask_, const Settings& settings)
        : gray(gray_),
          mask(mask_),
          s(settings),
          isHarris(settings.scoreType == ORB::HARRIS_SCORE),
          isRanked(settings.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION)
    {
        s.subPixel = isRanked && settings.subPixel;
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
    Size sizeOfLevel(int i) const
    {
        return levelSize(gray.size(), levelScale(i, s.firstLevel, s.scaleFactor));
    }
    bool isLargeEnough(Size size) const
    {
        return std::min(size.width, size.height) >= 2 * std::max(s.edgeThreshold, 3) + 1;
    }

    void buildPyramid()
    {
        const double scaleFactor = s.scaleFactor;
        int count = 0;  // of the levels that are large enough
        while (count < s.nlevels && isLargeEnough(sizeOfLevel(count)))
            count++;
        if (count == 0)
            return;
        std::vector<Size> regions;
        std::vector<float> scales;
        for (int i = 0; i < count; i++)
        {
            scales.push_back(levelScale(i, s.firstLevel, s.scaleFactor));
            regions.push_back(sizeOfLevel(i) - Size(2 * s.edgeThreshold, 2 * s.edgeThreshold));
        }
        // A ranked selection distributes the features over these, the paper's over all.
        const std::vector<int> quotaOfLevel = isRanked ? rankedQuotas(s.nfeatures, regions, scales)
                                                       : quotas(s.nfeatures, scaleFactor, s.nlevels);
        both = thresholds(varianceOverMean(gray, mask), s.adaptiveThreshold, s.fastThreshold,
                          s.minThresholdRatio);
        for (int i = 0; i < count; i++)
        {
            PyramidLevel level;
            level.scale = levelScale(i, s.firstLevel, scaleFactor);
            const Size size = sizeOfLevel(i);
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
            level.ownQuota = std::max(quotaOfLevel[i], 1);
            level.root = Rect(s.edgeThreshold, s.edgeThreshold, size.width - 2 * s.edgeThreshold,
                              size.height - 2 * s.edgeThreshold);
            level.usable = usableMask(level);
            level.usableShare = mask.empty() ? 1.
                                             : (double)countNonZero(level.usable(level.root)) /
                                                   ((double)level.root.width * level.root.height);
            level.grid = rankedGrid(level.ownQuota, level.usableShare, level.root.size(),
                                    representativeDensity(s.strengthWeight));
            levels.push_back(level);
        }
        levels.back().quota = std::accumulate(quotaOfLevel.begin() + count - 1, quotaOfLevel.end(), 0);
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
        for (int y = 0; y < level.mask.rows; y++)
            for (int x = 0; x < level.mask.cols; x++)
            {
                Point2f p;
                if (usable.at<uchar>(y, x) && !usablePosition(level, x, y, p))
                    usable.at<uchar>(y, x) = 0;
            }
        return usable;
    }

    std::vector<Candidate> score(const PyramidLevel& level, const std::vector<Corner>& corners) const
    {
        std::vector<Candidate> scored;
        for (size_t i = 0; i < corners.size(); i++)
        {
            const Corner& c = corners[i];
            scored.push_back(
                {c.x, c.y, c.score, isHarris ? harrisResponse(level.image, c.x, c.y) : (float)c.score});
        }
        return scored;
    }

    Point2d exactPosition(const PyramidLevel& level, const Candidate& c) const
    {
        return Point2d((c.x + 0.5) * gray.cols / level.image.cols - 0.5,
                       (c.y + 0.5) * gray.rows / level.image.rows - 0.5);
    }
    bool isNearOther(size_t index, const Candidate& corner) const
    {
        const Point2d p = exactPosition(levels[index], corner);
        const double radius = s.octaveSuppressionInUse() * levels[index].scale;
        for (size_t i = 0; i < levels.size(); i++)
        {
            const bool counts = i + 1 == index || i == index + 1;
            for (size_t j = 0; counts && j < levels[i].selected.size(); j++)
            {
                const Point2d d = exactPosition(levels[i], levels[i].selected[j]) - p;
                if (d.x * d.x + d.y * d.y < radius * radius)
                    return true;
            }
        }
        return false;
    }

    static std::vector<int> quadtreeCorners(const PyramidLevel& level, const std::vector<Candidate>& of)
    {
        std::vector<LeafCorner> corners;
        for (size_t i = 0; i < of.size(); i++)
            corners.push_back(
                {0, 0, float(of[i].x - level.root.x), float(of[i].y - level.root.y), of[i].response, int(i)});
        return quadtreeOrder(corners, level.root.size(), level.quota, quadtreeDepth(level.quota));
    }

    // With the FAST score as their key.
    static std::vector<LeafCorner> leafCorners(const PyramidLevel& level, const std::vector<Candidate>& of)
    {
        std::vector<LeafCorner> corners;
        for (size_t i = 0; i < of.size(); i++)
        {
            const int64 column = int64(of[i].x - level.root.x) * level.grid.columns / level.root.width;
            const int64 row = int64(of[i].y - level.root.y) * level.grid.rows / level.root.height;
            corners.push_back(
                {int(column), int(row), float(of[i].x), float(of[i].y), float(of[i].score), int(i)});
        }
        return corners;
    }

    static std::function<bool(int, int)> unmaskedLeaves(const PyramidLevel& level)
    {
        return [&level](int column, int row)
        {
            const Rect& root = level.root;
            const int64 x = root.x + ((int64)2 * column + 1) * root.width / (2 * level.grid.columns);
            const int64 y = root.y + ((int64)2 * row + 1) * root.height / (2 * level.grid.rows);
            return level.usable.empty() || level.usable.at<uchar>((int)y, (int)x) != 0;
        };
    }

    // The order of the corners that passed all rules.
    std::vector<int> orderCorners(const PyramidLevel& level, const std::vector<Candidate>& of) const
    {
        const std::vector<LeafCorner> corners = leafCorners(level, of);
        const int radius = s.patchSize / 2;
        const auto strengthOf = [&](const LeafCorner& corner)
        {
            int m10 = 0, m01 = 0;
            discMoments(level.image, (int)corner.x, (int)corner.y, s.patchSize, std::max(1, radius / 5), m10,
                        m01);
            const Candidate& candidate = of[corner.index];
            return strength(candidate.score, candidate.response, isHarris, m10, m01);
        };
        const RankRule rule = {level.root.size(), level.grid,   level.usableShare,
                               level.ownQuota,    s.rankRadius, s.strengthWeight / 4};
        return rankedOrder(corners, rule, unmaskedLeaves(level), strengthOf,
                           representativeDensity(s.strengthWeight));
    }

    // Takes up to `wanted` more of a level's ordered corners; returns how many are still wanted.
    int take(size_t index, int wanted)
    {
        PyramidLevel& level = levels[index];
        if (wanted == 0)
            return 0;
        for (; wanted > 0 && level.next < level.ordered.size(); level.next++)
        {
            const Candidate& corner = level.candidates[level.ordered[level.next]];
            if (isNearOther(index, corner))
                continue;
            level.selected.push_back(corner);
            wanted--;
        }
        return wanted;
    }

    // The corners of the highest response * scale of those that FAST finds without any other rule: first those of levels
    // below their quota that keep their distance from keypoints of other levels, then all that keep it, then the others.
    void fillUp(int wanted)
    {
        std::vector<std::pair<size_t, Candidate>> candidates;
        for (size_t i = 0; i < levels.size(); i++)
        {
            const PyramidLevel& level = levels[i];
            const Thresholds t = {both.min, both.min};
            for (const Candidate& c :
                 score(level, findCorners(level.image, level.usable, level.root, t, false)))
            {
                const auto isSame = [&](const Candidate& d) { return c.x == d.x && c.y == d.y; };
                if (std::find_if(level.selected.begin(), level.selected.end(), isSame) ==
                    level.selected.end())
                    candidates.push_back(std::make_pair(i, c));
            }
        }
        std::stable_sort(candidates.begin(), candidates.end(),
                         [&](const std::pair<size_t, Candidate>& a, const std::pair<size_t, Candidate>& b) {
                             return a.second.response * levels[a.first].scale >
                                    b.second.response * levels[b.first].scale;
                         });
        for (int rules = 2; rules >= 0; rules--)
            for (size_t i = 0; i < candidates.size() && wanted > 0;)
            {
                const std::pair<size_t, Candidate> c = candidates[i];
                PyramidLevel& level = levels[c.first];
                if ((rules == 2 && int(level.selected.size()) >= level.quota) ||
                    (rules >= 1 && isNearOther(c.first, c.second)))
                {
                    i++;
                    continue;
                }
                level.selected.push_back(c.second);
                candidates.erase(candidates.begin() + (ptrdiff_t)i);
                wanted--;
            }
    }

    void select()
    {
        for (PyramidLevel& level : levels)
        {
            level.candidates =
                score(level, findCorners(level.image, level.usable, level.root, both, isHarris && isRanked));
            level.ordered =
                isRanked ? orderCorners(level, level.candidates) : quadtreeCorners(level, level.candidates);
            level.next = 0;
            level.selected.clear();
        }
        int wanted = 0;
        for (size_t i = levels.size(); i-- > 0;)
            wanted = take(i, wanted + levels[i].quota);
        for (size_t i = 0; i < levels.size(); i++)
            wanted = take(i, wanted);
        fillUp(wanted);
    }

    void describe(int octave, Features& features)
    {
        PyramidLevel& level = levels[octave];
        std::sort(level.selected.begin(), level.selected.end(), inRasterOrder);
        std::stable_sort(level.selected.begin(), level.selected.end(), hasHigherResponse);
        const Mat blurred = roundedBlur(level.image);
        const std::vector<Point> pattern = descriptorPattern(s.patchSize, s.WTA_K);
        for (size_t i = 0; i < level.selected.size(); i++)
        {
            const Candidate& c = level.selected[i];
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
    Thresholds both = Thresholds();
    Settings s;
    const bool isHarris, isRanked;
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
