// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "reference.hpp"

#include "detector/selection.hpp"

#include <climits>
#include <memory>

namespace opencv_test
{
namespace
{

using namespace aqorb;

TEST(Aqorb_Selection, leaves_equal_reference)
{
    RNG rng(1);
    for (int i = 0; i < 20000; i++)
    {
        const Size size(rng.uniform(1, 1 << rng.uniform(1, 15)), rng.uniform(1, 1 << rng.uniform(1, 15)));
        const int quota = rng.uniform(1, 1 << rng.uniform(1, 24));
        const double usable = i % 3 ? rng.uniform(0., 1.) : i % 2;
        const double density = i % 2 ? 1 : rng.uniform(1., 7000.);
        const LeafGrid grid = rankedGrid(size, usable, quota, density),
                       expected = reference::rankedGrid(quota, usable, size, density);
        ASSERT_EQ(Size(grid.columns, grid.rows), Size(expected.columns, expected.rows))
            << size << usable << " " << quota;
        ASSERT_EQ(grid.columnBits, expected.columnBits);
    }
    EXPECT_EQ(rankedGrid(Size(INT_MAX, INT_MAX), 1, INT_MAX).columns, 1 << 12);
}

//! Points over a region, and the strengths of the representatives among them by their indices.
struct Scene
{
    RankRule rule;
    std::vector<reference::LeafCorner> corners;  // in the order that breaks ties; their bases are their keys
    std::vector<float> strengths;                // by index
    std::vector<uchar> usable;
    double density;
};

//! @param isLarge whether the scene has thousands of points in hundreds of leaves
Scene randomScene(int seed, bool isLarge = false)
{
    RNG rng(seed);
    const int kind = seed % 5;
    Scene scene;
    scene.density = seed % 2 ? 1 : rng.uniform(1., 3.);
    const int shortest = isLarge ? 200 : 1;
    const Size size(rng.uniform(shortest, 300), rng.uniform(shortest, 300));
    // Some scenes have several trees side by side.
    const int depth = rng.uniform(isLarge ? 5 : 0, isLarge ? 7 : 8);
    const LeafGrid grid = leafGrid(size, isLarge || rng.uniform(0, 2) ? 1 : rng.uniform(2, 12), depth);
    scene.rule = {size,
                  grid,
                  1,
                  rng.uniform(1, 1 << rng.uniform(1, 9)),
                  seed % 3 ? rng.uniform(0., 3.) : rng.uniform(0., 16.),
                  seed % 4 ? rng.uniform(0., 2.) : rng.uniform(0, 2) * 1000.};
    const int count = (isLarge ? 4000 : 0) + rng.uniform(0, 1 << rng.uniform(1, 11));
    for (int i = 0; i < count; i++)
    {
        const Point p(rng.uniform(0, size.width), rng.uniform(0, size.height));
        scene.corners.push_back({p.x * grid.columns / size.width, p.y * grid.rows / size.height, float(p.x),
                                 float(p.y), randomResponse(rng, kind), i});
        scene.strengths.push_back(randomResponse(rng, kind));
    }
    std::sort(scene.corners.begin(), scene.corners.end(),
              [](const reference::LeafCorner& a, const reference::LeafCorner& b) {
                  return a.y != b.y ? a.y < b.y : a.x != b.x ? a.x < b.x : a.index < b.index;
              });
    if (rng.uniform(0, 2))
    {
        scene.rule.usable = rng.uniform(0., 1.);
        for (size_t i = 0; i < grid.numbers(); i++)
            scene.usable.push_back(uchar(rng.uniform(0, 3) ? rng.uniform(1, 256) : 0));
    }
    return scene;
}

std::vector<int> expectedOrder(const Scene& scene)
{
    return reference::rankedOrder(
        scene.corners, scene.rule,
        [&](int column, int row)
        { return scene.usable.empty() || scene.usable[scene.rule.grid.numberOf(column, row)]; },
        [&](const reference::LeafCorner& corner) { return scene.strengths[corner.index]; }, scene.density);
}

//! The order of a scene, step by step.
std::vector<int> orderOf(const Scene& scene)
{
    std::vector<LeafPoint> points;
    for (const reference::LeafCorner& corner : scene.corners)
        points.push_back({scene.rule.grid.numberOf(corner.column, corner.row), aqorb::sortKey(corner.key)});
    const std::vector<unsigned> representatives = findRepresentatives(points, scene.rule.grid, scene.density);
    std::vector<unsigned> leaves;
    std::vector<float> strengths;
    for (unsigned index : representatives)
    {
        leaves.push_back(points[index].leaf);
        strengths.push_back(scene.strengths[scene.corners[index].index]);
    }
    std::vector<int> order;
    for (unsigned index : orderRepresentatives(leaves, strengths, scene.rule, scene.usable))
        order.push_back(scene.corners[representatives[index]].index);
    return order;
}

TEST(Aqorb_Selection, order_equals_reference)
{
    size_t compared = 0;
    for (int seed = 1; seed <= 650; seed++)
    {
        SCOPED_TRACE(seed);
        // The kernels for this CPU and the baseline's.
        const std::unique_ptr<WithoutOptimization> baseline(seed % 4 ? 0 : new WithoutOptimization);
        const Scene scene = randomScene(seed, seed > 600);
        const std::vector<int> expected = expectedOrder(scene);
        ASSERT_EQ(orderOf(scene), expected);
        compared += expected.size();
    }
    EXPECT_GT(compared, 50000u);
}

//! How many keypoints two lists have in common.
int common(const KeyPoints& a, const KeyPoints& b)
{
    int count = 0;
    for (const KeyPoint& k : a)
        count +=
            std::any_of(b.begin(), b.end(),
                        [&](const KeyPoint& other)
                        { return other.pt == k.pt && other.octave == k.octave && other.angle == k.angle; });
    return count;
}

// Leaves of one tree are limited by the shorter side. There were too few of them, and the strongest corners filled up.
TEST(Aqorb_Selection, narrow_images_are_covered)
{
    const Size sizes[] = {Size(1024, 128), Size(1024, 64),   Size(4096, 64),
                          Size(32768, 40), Size(100000, 36), Size(64, 1024)};
    for (const Size& size : sizes)
    {
        SCOPED_TRACE(format("%d x %d", size.width, size.height));
        const bool isWide = size.width > size.height;
        Mat image = makeNoise(size, 7);
        Mat weaker = isWide ? image.colRange(0, size.width / 2) : image.rowRange(0, size.height / 2);
        weaker = weaker / 2 + 64;
        reference::Settings settings;
        for (int n : {250, 500, 1000})
        {
            settings.nfeatures = n;
            const KeyPoints keypoints = detectAndCompute(*settings.create(), image).keypoints;
            ASSERT_EQ(keypoints.size(), size_t(n));
            const auto isInWeaker = [&](const KeyPoint& k)
            { return isWide ? k.pt.x < size.width / 2 : k.pt.y < size.height / 2; };
            EXPECT_GE(std::count_if(keypoints.begin(), keypoints.end(), isInWeaker), n * 27 / 100) << n;
        }
    }
}

TEST(Aqorb_Selection, the_weight_leads_from_evenness_to_strength)
{
    const double weights[] = {0, 1, 4, 1000};
    double strong[4] = {0, 0, 0, 0}, occupancy[4] = {0, 0, 0, 0};  // sums over scenes
    const int SCENES = 5, n = 300;
    for (int seed = 1; seed <= SCENES; seed++)
    {
        const Mat image = makeScene(Size(640, 480), seed);
        reference::Settings settings;
        settings.nfeatures = n;
        settings.octaveSuppression = 1;  // its default would follow the weight
        settings.rankRadius = 0;
        settings.strengthWeight = 1000;
        const KeyPoints strongest = detectAndCompute(*settings.create(), image).keypoints;
        settings.rankRadius = 1;
        for (int i = 0; i < 4; i++)
        {
            settings.strengthWeight = weights[i];
            const KeyPoints keypoints = detectAndCompute(*settings.create(), image).keypoints;
            ASSERT_EQ(keypoints.size(), size_t(n));
            strong[i] += common(keypoints, strongest);
            occupancy[i] += aqorb::distributionOccupancy(keypoints, image.size());
        }
    }
    for (int i = 1; i < 4; i++)
    {
        EXPECT_GT(strong[i], strong[i - 1]) << weights[i];
        EXPECT_LT(occupancy[i], occupancy[i - 1]) << weights[i];
    }
    EXPECT_GE(strong[3], 0.95 * SCENES * n);
}

// Letters on a plain sign before fine texture: strong corners, but few leaves.
TEST(Aqorb_Selection, the_largest_weight_takes_most_strong_corners_that_orb_takes)
{
    Mat sign(600, 600, CV_8UC1, Scalar(60)), scene = makeNoise(Size(1280, 960)), isSign, drawn;
    // The letters PKO. OpenCV 5 has other fonts than OpenCV 4.
    const std::vector<std::vector<Point>> strokes = {
        {{110, 370}, {110, 244}, {170, 244}, {195, 275}, {170, 306}, {110, 306}},
        {{250, 370}, {250, 244}},
        {{335, 244}, {250, 320}},
        {{280, 295}, {335, 370}}};
    polylines(sign, strokes, false, Scalar(235), 36, LINE_AA);
    ellipse(sign, Point(440, 307), Size(55, 63), 0, 0, 360, Scalar(235), 36, LINE_AA);
    GaussianBlur(scene, scene, Size(), 1.4);
    scene.convertTo(scene, CV_8U, 1.9, -130);
    const Mat map = (Mat_<double>(2, 3) << 0.25, -0.025, 560, 0.025, 0.25, 380);
    warpAffine(Mat(sign.size(), CV_8UC1, Scalar(255)), isSign, map, scene.size());
    GaussianBlur(sign, drawn, Size(), 1.8);
    warpAffine(drawn, drawn, map, scene.size());
    drawn.copyTo(scene, isSign == 255);
    GaussianBlur(scene, scene, Size(), 0.7);
    const auto keypointsAndMatches = [&](Feature2D& detector)
    {
        const Features object = detectAndCompute(detector, sign), found = detectAndCompute(detector, scene);
        std::vector<DMatch> matches;
        BFMatcher(NORM_HAMMING, true).match(object.descriptors, found.descriptors, matches);
        const auto isOnSign = [&](const KeyPoint& k) { return isSign.at<uchar>(k.pt) == 255; };
        const auto isRight = [&](const DMatch& match)
        {
            const Point2f p = object.keypoints[match.queryIdx].pt, q = found.keypoints[match.trainIdx].pt;
            const Mat at = map * (Mat_<double>(3, 1) << p.x, p.y, 1);
            return cv::norm(Point2d(at.at<double>(0), at.at<double>(1)) - Point2d(q)) < 4;
        };
        return Point(int(std::count_if(found.keypoints.begin(), found.keypoints.end(), isOnSign)),
                     int(std::count_if(matches.begin(), matches.end(), isRight)));
    };
    const Point theirs = keypointsAndMatches(*ORB::create(500));
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(500);
    const Point even = keypointsAndMatches(*detector);
    detector->setStrengthWeight(1000);
    detector->setOctaveSuppression(0);
    detector->setMinThresholdRatio(1);
    const Point strong = keypointsAndMatches(*detector);
    EXPECT_GE(strong.x, 0.75 * theirs.x) << theirs << even << strong;
    EXPECT_GE(strong.y, 0.75 * theirs.y) << theirs << even << strong;
    EXPECT_LT(even.x, 0.3 * theirs.x) << theirs << even << strong;
}

}  // namespace
}  // namespace opencv_test
