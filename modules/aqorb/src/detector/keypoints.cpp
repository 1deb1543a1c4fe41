// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Turns selected corners, and given keypoints, into keypoints with descriptors.

#include "precomp.hpp"

#include "detector/keypoints.hpp"

#include "common/for_each.hpp"
#include "detector/arguments.hpp"
#include "detector/fast.hpp"
#include "detector/index_sort.hpp"
#include "detector/pyramid.hpp"

namespace cv
{
namespace aqorb
{

// Limit on the octaves of given keypoints. Another detector may have more levels than this one.
static const int MAX_GIVEN_LEVELS = 64;

// Highest octave of the keypoints, or 0 without keypoints. Throws if an octave is negative or an angle is not finite.
static int highestOctave(const std::vector<KeyPoint>& keypoints)
{
    int highest = 0;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const int octave = keypoints[i].octave;
        if (octave < 0)
            CV_Error_(
                Error::StsOutOfRange,
                ("keypoints must have an octave of at least 0, got %d (SIFT packs more than the octave into "
                 "the field: unpack it first)",
                 octave));
        // A NaN or infinite angle would make the descriptor read outside the image.
        if (!std::isfinite(keypoints[i].angle))
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints must have a finite angle, got %g", keypoints[i].angle));
        highest = std::max(highest, octave);
    }
    return highest;
}

std::vector<FeatureList> groupGivenKeypoints(const std::vector<KeyPoint>& keypoints,
                                             const Parameters& parameters, Size imageSize)
{
    const int highest = highestOctave(keypoints);
    parameters.checkTogether(std::max(parameters.nlevels, highest > 0 ? 2 : 1));
    const auto scaleOf = [&](int octave)
    { return levelScale(octave, parameters.firstLevel, parameters.scaleFactor); };
    const Size smallest = levelSize(imageSize, scaleOf(highest));
    const int most = std::max(parameters.nlevels, MAX_GIVEN_LEVELS);
    if (highest >= most || smallest.width < 1 || smallest.height < 1)
        CV_Error_(
            Error::StsOutOfRange,
            ("keypoints must have octaves below %d whose levels have pixels, got octave %d (SIFT packs more "
             "than the octave into the field: unpack it first)",
             most, highest));

    std::vector<float> inverseScales;
    for (int octave = 0; octave <= highest; octave++)
        inverseScales.push_back(1.f / scaleOf(octave));
    const auto pointOf = [&](const KeyPoint& keypoint)
    {
        const Point2f p = keypoint.pt * inverseScales[keypoint.octave];
        return FeaturePoint{cvRound(p.x), cvRound(p.y), keypoint.angle};
    };
    // The area begins half a pixel before the centre of the first pixel and ends a whole pixel after the centre of the
    // last pixel. cv::ORB also describes points of the last half pixel, although they round to a pixel beside the
    // image. On an enlarged level half a pixel of the image is many pixels wide, and cv::ORB reads foreign memory
    // there. Keypoints more than one pixel outside the level are therefore dropped.
    const Rect2f area(-0.5f, -0.5f, float(imageSize.width) + 0.5f, float(imageSize.height) + 0.5f);
    const auto isReadable = [&](const KeyPoint& keypoint)
    { return area.contains(keypoint.pt) && pointOf(keypoint).x >= -1 && pointOf(keypoint).y >= -1; };
    std::vector<KeyPoint> inside;
    std::copy_if(keypoints.begin(), keypoints.end(), std::back_inserter(inside), isReadable);
    // OpenCV's own filter drops keypoints near the border, because its versions differ in rounding positions.
    const int border = std::min(parameters.edgeThreshold, std::max(imageSize.width, imageSize.height));
    KeyPointsFilter::runByImageBorder(inside, imageSize, border);
    std::vector<FeatureList> features(inside.empty() ? 0 : size_t(highestOctave(inside)) + 1);
    std::vector<uint64> rasterKeys;
    for (const KeyPoint& keypoint : inside)
        rasterKeys.push_back(uint64(pointOf(keypoint).y + 1) << 32 | uint64(pointOf(keypoint).x + 1));
    for (unsigned index : sortIndices(rasterKeys))
    {
        FeatureList& list = features[size_t(inside[index].octave)];
        list.points.push_back(pointOf(inside[index]));
        list.keypoints.push_back(inside[index]);
        list.outputKeys.push_back(index);
    }
    return features;
}

Point2d subPixelOffset(const Mat& image, int x, int y)
{
    int s[3][3];
    cornerScores3x3(image, x, y, s);

    // Derivatives by central differences, scaled to whole numbers: twice the gradient and four times dxy.
    const int gx2 = s[1][2] - s[1][0], gy2 = s[2][1] - s[0][1];
    const int dxx = s[1][2] - 2 * s[1][1] + s[1][0], dyy = s[2][1] - 2 * s[1][1] + s[0][1];
    const int dxy4 = s[2][2] - s[2][0] - s[0][2] + s[0][0];
    const int determinant16 = 16 * dxx * dyy - dxy4 * dxy4;
    if (dxx >= 0 || determinant16 <= 0)  // no peak
        return Point2d(0, 0);
    // The peak is at minus the inverse of the Hessian times the gradient.
    const double px = 2. * (dxy4 * gy2 - 4 * dyy * gx2) / determinant16;
    const double py = 2. * (dxy4 * gx2 - 4 * dxx * gy2) / determinant16;
    return Point2d(std::min(std::max(px, -0.5), 0.5), std::min(std::max(py, -0.5), 0.5));
}

namespace
{

// Features of a level, described by one thread.
struct FeatureRange
{
    int level;
    size_t begin, end;
};

}  // namespace

// Divides features into ranges that balance the threads' work against its overhead.
static std::vector<FeatureRange> divideIntoRanges(const std::vector<FeatureList>& features, int threads)
{
    const size_t MIN_FEATURES = 64;
    size_t all = 0;
    for (const FeatureList& list : features)
        all += list.points.size();
    const size_t most = threads == 1 ? all + 1 : std::max(all / (4 * threads), MIN_FEATURES);
    std::vector<FeatureRange> ranges;
    for (size_t level = 0; level < features.size(); level++)
    {
        const size_t count = features[level].points.size(), parts = (count + most - 1) / most;
        for (size_t i = 0; i < parts; i++)
            ranges.push_back({int(level), count * i / parts, count * (i + 1) / parts});
    }
    return ranges;
}

// Finds the directions of features and completes their keypoints.
static void findKeypoints(const Mat& image, const DescriptionRules& rules, const FeatureRange& range,
                          FeatureList& list)
{
    CV_TRACE_FUNCTION();
    const Mat& mask = rules.imageMask;
    const PositionMap& position = rules.positions[range.level];
    const bool subPixel = position.subPixel;
    orientations(image, *rules.patch, &list.points[range.begin], range.end - range.begin);
    for (size_t i = range.begin; i < range.end; i++)
    {
        const FeaturePoint& point = list.points[i];
        KeyPoint& keypoint = list.keypoints[i];
        const Point2d offset = subPixel ? subPixelOffset(image, point.x, point.y) : Point2d();
        keypoint.pt = position(point.x, point.y, offset.x, offset.y);
        keypoint.angle = point.angle;
        if (subPixel && !mask.empty() && !isUsable(mask, keypoint.pt))
            usablePosition(mask, position, point.x, point.y, keypoint.pt);
    }
}

// Computes descriptors, and blurs the level from top to bottom, some rows at a time.
static void describeRange(const Mat& image, const DescriptorTests& tests, const FeatureRange& range,
                          FeatureList& list, DescriptionSpace& space)
{
    const int ROWS = 128;  // blurred at once; more rows would be faster and take more memory
    const int reach = tests.reach, margin = tests.margin();
    const int rowsEnd = image.rows + margin;
    const std::vector<FeaturePoint>& points = list.points;
    space.region.reset(image.size(), margin);
    for (size_t i = range.begin; i < range.end; i++)
        space.region.addDisc(Point(points[i].x, points[i].y), tests.halfHeights);

    BlurredRows blurred;
    blurred.step = ptrdiff_t(alignSize(size_t(image.cols) + 2 * margin, CACHE_LINE / sizeof(ushort)));
    const size_t capacity = size_t(std::min<int64>(ROWS + 2 * int64(reach) + 1, rowsEnd + margin));
    growTo(space.blurred, capacity * blurred.step);
    blurred.data = space.blurred.data() + margin;
    int filled = -margin;  // rows from blurred.top to `filled`, exclusive, are blurred
    bool isExact = false;
    for (size_t next, i = range.begin; i < range.end;)
    {
        // Keeps the rows that the next features read.
        const int top = std::max(points[i].y - reach, -margin);
        if (top < filled)
            std::memmove(blurred.data - margin, blurred.row(top) - margin,
                         sizeof(ushort) * blurred.step * (filled - top));
        blurred.top = top;
        filled = std::max(filled, top);
        const int bottom = std::min(std::max(points[i].y + reach + 1, filled + ROWS), rowsEnd);
        for (next = i; next < range.end && (points[next].y + reach < bottom || bottom == rowsEnd);)
            next++;
        approximateBlur(image, space.region, Range(filled, bottom), blurred, space.blur, isExact);
        filled = bottom;
        i += computeDescriptors(image, blurred, &points[i], next - i, tests,
                                &list.descriptors[i * ORB::kBytes], ORB::kBytes, !isExact);
        if (i < next)
        {
            isExact = true;
            filled = -margin;
        }
    }
}

void describeFeatures(const std::vector<Level>& levels, const DescriptionRules& rules, int threads,
                      std::vector<DescriptionSpace>& spaces, std::vector<FeatureList>& features)
{
    if (rules.tests)
        for (FeatureList& list : features)
            list.descriptors.resize(list.points.size() * ORB::kBytes);
    spaces.resize(std::max(spaces.size(), size_t(threads)));
    const std::vector<FeatureRange> ranges = divideIntoRanges(features, threads);
    forEach(ranges.size(), threads,
            [&](size_t i, int thread)
            {
                const FeatureRange& range = ranges[i];
                const Mat& image = levels[range.level].image;
                if (rules.patch)
                    findKeypoints(image, rules, range, features[range.level]);
                if (rules.tests)
                    describeRange(image, *rules.tests, range, features[range.level], spaces[thread]);
            });
}

void outputFeatures(const std::vector<FeatureList>& features, std::vector<KeyPoint>& keypoints,
                    OutputArray descriptors_)
{
    CV_TRACE_FUNCTION();
    size_t count = 0;
    for (const FeatureList& level : features)
        count += level.points.size();
    Mat descriptors = descriptors_.needed() ? createDescriptors(descriptors_, int(count)) : Mat();
    keypoints.clear();
    for (const FeatureList& level : features)
    {
        for (unsigned i : sortIndices(level.outputKeys))
        {
            if (!descriptors.empty())
                std::memcpy(descriptors.ptr(int(keypoints.size())),
                            &level.descriptors[size_t(i) * ORB::kBytes], ORB::kBytes);
            keypoints.push_back(level.keypoints[i]);
        }
    }
}

}  // namespace aqorb
}  // namespace cv
