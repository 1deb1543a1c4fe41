// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "blur.hpp"
#include "descriptor.hpp"
#include "orb_pattern.hpp"
#include "patch.hpp"
#include "sine_cosine.hpp"

#include "descriptor.simd.hpp"
#include "descriptor.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

std::vector<Point> descriptorPattern(int patchSize, int WTA_K)
{
    const int POINTS = 512, TUPLES = 128;
    std::vector<Point> points(POINTS);
    if (patchSize == 31)
    {
        for (int i = 0; i < POINTS; i++)
            points[i] = Point(LEARNED_POINTS[i][0], LEARNED_POINTS[i][1]);
    }
    else
    {
        RNG rng(0x34985739);  // the seed of cv::ORB
        for (int i = 0; i < POINTS; i++)
        {
            points[i].x = rng.uniform(-patchSize / 2, patchSize / 2 + 1);
            points[i].y = rng.uniform(-patchSize / 2, patchSize / 2 + 1);
        }
    }
    if (WTA_K == 2)
        return points;

    // Tuples of distinct points are drawn from the 512.
    RNG rng(0x12345678);  // the seed of cv::ORB
    std::vector<Point> tuples;
    tuples.reserve(TUPLES * WTA_K);
    for (int i = 0; i < TUPLES; i++)
    {
        const size_t first = tuples.size();
        while (tuples.size() < first + WTA_K)
        {
            const Point point = points[rng.uniform(0, POINTS)];
            if (std::find(tuples.begin() + first, tuples.end(), point) == tuples.end())
                tuples.push_back(point);
        }
    }
    return tuples;
}

static bool isInside(const Mat& image, Point p)
{
    return p.x >= 0 && p.y >= 0 && p.x < image.cols && p.y < image.rows;
}

// The value at a pixel around the level. cv::ORB blurs the level, but not the reflected pixels around it.
static int reflectedPixel(const Mat& image, Point p)
{
    return image.at<uchar>(borderInterpolate(p.y, image.rows, BORDER_REFLECT_101),
                           borderInterpolate(p.x, image.cols, BORDER_REFLECT_101));
}

namespace
{

// The blurred level around one keypoint. Wherever the approximate blur does not determine a value, it is computed exactly.
class BlurredPatch
{
public:
    BlurredPatch(const Mat& image_, const BlurredRows& blurred_, int x_, int y_)
        : image(image_), blurred(blurred_), x(x_), y(y_)
    {
    }
    bool less(Point a, Point b) const
    {
        const Point pa(x + a.x, y + a.y), pb(x + b.x, y + b.y);
        if (!isInside(image, pa) || !isInside(image, pb))
            return valueAt(pa) < valueAt(pb);
        const int va = approximateAt(pa), vb = approximateAt(pb);
        if (roundUp(va) < roundDown(vb))
            return true;
        if (roundDown(va) >= roundUp(vb))
            return false;
        return valueAt(pa) < valueAt(pb);
    }
    int value(Point offset) const { return valueAt(Point(x + offset.x, y + offset.y)); }

private:
    // The highest and the lowest value that the exact blur can have.
    static int roundUp(int approximate) { return (approximate + BLUR_SHORTFALL + 128) >> 8; }
    static int roundDown(int approximate) { return (approximate - BLUR_EXCESS + 127) >> 8; }

    int valueAt(Point p) const
    {
        if (!isInside(image, p))
            return reflectedPixel(image, p);
        const int approximate = approximateAt(p);
        const int highest = roundUp(approximate);
        return highest == roundDown(approximate) ? highest : exactBlur(image, p.x, p.y);
    }

    int approximateAt(Point p) const { return blurred.row(p.y)[p.x]; }

    const Mat& image;
    const BlurredRows& blurred;
    int x, y;
};

}  // namespace

// The index of the brightest point. Ties are broken as in cv::ORB.
static int brightest(const int* v, int WTA_K)
{
    if (WTA_K == 3)
        return v[2] > v[1] ? (v[2] > v[0] ? 2 : 0) : (v[1] > v[0] ? 1 : 0);
    const int u = v[1] > v[0] ? 1 : 0, w = v[3] > v[2] ? 3 : 2;
    return v[u] > v[w] ? u : w;
}

static Point rotate(Point p, float a, float b)
{
    return Point(cvRound(p.x * a - p.y * b), cvRound(p.x * b + p.y * a));
}

// The descriptor for any WTA_K at any place, without the kernel.
static void computePlainly(const BlurredPatch& patch, float a, float b, const std::vector<Point>& pattern,
                           int WTA_K, uchar* descriptor)
{
    const int bitsOfTest = WTA_K == 2 ? 1 : 2;
    const Point* p = &pattern[0];
    for (int i = 0; i < DESCRIPTOR_BYTES; i++)
    {
        int byte = 0;
        for (int bit = 0; bit < 8; bit += bitsOfTest, p += WTA_K)
        {
            if (WTA_K == 2)
            {
                byte |= int(patch.less(rotate(p[0], a, b), rotate(p[1], a, b))) << bit;
                continue;
            }
            int values[4];
            for (int k = 0; k < WTA_K; k++)
                values[k] = patch.value(rotate(p[k], a, b));
            byte |= brightest(values, WTA_K) << bit;
        }
        descriptor[i] = uchar(byte);
    }
}

static void decidePairs(const ushort* center, ptrdiff_t step, float a, float b, const PairTests& tests,
                        uchar* descriptor, uint64* open)
{
    CV_CPU_DISPATCH(comparePairs, (center, step, a, b, tests, descriptor, open), CV_CPU_DISPATCH_MODES_ALL);
}

// How far from the keypoint the descriptor may read, in any direction.
static int reachOf(const std::vector<Point>& pattern)
{
    int64 squared = 0;
    for (size_t i = 0; i < pattern.size(); i++)
        squared = std::max(squared, int64(pattern[i].x) * pattern[i].x + int64(pattern[i].y) * pattern[i].y);
    return cvCeil(std::sqrt(double(squared))) + 1;
}

// Copies the blurred patch of the given radius around a pixel near the border. Outside of the image it gets the
// reflected pixels unblurred, as cv::ORB does not blur those.
static void copyBlurredPatch(const Mat& image, const BlurredRows& blurred, int x, int y, int radius,
                             ushort* patch)
{
    const int side = 2 * radius + 1;
    const Rect rect(x - radius, y - radius, side, side), inside = rect & Rect(Point(), image.size());
    const Point end = inside.br();
    const Rect outside[] = {Rect(rect.x, rect.y, side, inside.y - rect.y),
                            Rect(rect.x, inside.y, inside.x - rect.x, inside.height),
                            Rect(end.x, inside.y, rect.x + side - end.x, inside.height),
                            Rect(rect.x, end.y, side, rect.y + side - end.y)};
    for (const Rect& part : outside)
    {
        if (part.empty())
            continue;
        PatchBuffer reflected(size_t(part.area()));
        copyReflected(image, part, reflected.data());
        const uchar* source = reflected.data();
        for (int row = part.y; row < part.y + part.height; row++)
        {
            ushort* out = patch + (row - rect.y) * side + (part.x - rect.x);
            for (int i = 0; i < part.width; i++)
                out[i] = ushort(*source++ << 8);
        }
    }
    for (int row = inside.y; row < end.y; row++)
    {
        const ushort* source = blurred.row(row) + inside.x;
        std::copy(source, source + inside.width, patch + (row - rect.y) * side + (inside.x - rect.x));
    }
}

DescriptorTests::DescriptorTests(const std::vector<Point>& pattern_, int WTA_K_)
    : pattern(pattern_), WTA_K(WTA_K_), reach(reachOf(pattern_))
{
    for (int x = 0; x <= reach; x++)
        halfHeights.push_back(cvFloor(std::sqrt(double(reach) * reach - double(x) * x)));
    const int MAX_REACH = 64;  // a larger patch at the border would be expensive to copy
    if (WTA_K != 2 || reach > MAX_REACH)
        return;
    pairs.resize(1);
    for (int i = 0; i < PairTests::COUNT; i++)
    {
        for (int k = 0; k < 2; k++)
        {
            pairs[0].x[k][i] = float(pattern[2 * i + k].x);
            pairs[0].y[k][i] = float(pattern[2 * i + k].y);
        }
    }
}

namespace
{

// The tests of some descriptors that the approximate blur leaves open. They are decided many at a time and without a
// branch on their number or on their outcome: the processor would guess it wrong, and wait for each exact value.
class OpenTests
{
public:
    OpenTests(const Mat& image_, const std::vector<Point>& pattern_)
        : image(image_), pattern(pattern_), placeCount(0), count(0)
    {
    }
    //! @param bits one for each test: whether it is open
    //! @param descriptor gets the results at some later time; its bits of open tests must be 0
    void add(const FeaturePoint& point, float cosine, float sine, const uint64* bits, uchar* descriptor)
    {
        const Place place = {point.x, point.y, cosine, sine, descriptor};
        places[placeCount] = place;
        for (int i = 0; i < PairTests::COUNT; i += 64)
        {
            uint64 left = bits[i / 64];
            do
            {
                for (int k = 0; k < 2; k++)  // there are seldom more, and often less
                {
                    const uint64 LAST = uint64(1) << 63;  // so that there is one
                    tests[count] = ushort(placeCount * PairTests::COUNT + i + trailingZeros(left | LAST));
                    count += left != 0;
                    left &= left - 1;
                }
            } while (left);
        }
        if (++placeCount == PLACES)
            decide();
    }
    void decide()
    {
        for (int i = 0; i < count; i++)
        {
            const Place& place = places[tests[i] / PairTests::COUNT];
            const int test = tests[i] % PairTests::COUNT;
            const int less = valueAt(place, pattern[2 * test]) < valueAt(place, pattern[2 * test + 1]);
            place.descriptor[test / 8] |= uchar(less << (test % 8));
        }
        placeCount = 0;
        count = 0;
    }

private:
    struct Place
    {
        int x, y;
        float cosine, sine;
        uchar* descriptor;
    };
    enum
    {
        PLACES = 32
    };
    int valueAt(const Place& place, Point point) const
    {
        const Point p = Point(place.x, place.y) + rotate(point, place.cosine, place.sine);
        return isInside(image, p) ? exactBlur(image, p.x, p.y) : reflectedPixel(image, p);
    }

    const Mat& image;
    const std::vector<Point>& pattern;
    int placeCount, count;
    Place places[PLACES];
    ushort tests[PLACES * PairTests::COUNT + 1];  // the place and the test; one more may be written
};

}  // namespace

void computeDescriptors(const Mat& image, const BlurredRows& blurred, const FeaturePoint* points,
                        size_t count, const DescriptorTests& tests, uchar* descriptors, size_t step)
{
    CV_TRACE_FUNCTION();
    const int reach = tests.reach;
    const Rect inside(reach, reach, image.cols - 2 * reach, image.rows - 2 * reach);
    AutoBuffer<ushort, 2048> copy;
    OpenTests openTests(image, tests.pattern);
    for (size_t i = 0; i < count; i++)
    {
        const int x = points[i].x, y = points[i].y;
        uchar* descriptor = descriptors + i * step;
        const float angle = points[i].angle * float(CV_PI / 180.f);
        float a, b;
        sineAndCosine(angle, b, a);
        if (tests.pairs.empty())
        {
            computePlainly(BlurredPatch(image, blurred, x, y), a, b, tests.pattern, tests.WTA_K, descriptor);
            continue;
        }
        const ushort* center;
        ptrdiff_t centerStep;
        if (inside.contains(Point(x, y)))
        {
            center = blurred.row(y) + x;
            centerStep = blurred.step;
        }
        else
        {
            centerStep = 2 * reach + 1;
            copy.allocate(size_t(centerStep) * centerStep);
            copyBlurredPatch(image, blurred, x, y, reach, copy.data());
            center = copy.data() + reach * centerStep + reach;
        }
        uint64 open[PairTests::COUNT / 64];
        decidePairs(center, centerStep, a, b, tests.pairs[0], descriptor, open);
        openTests.add(points[i], a, b, open, descriptor);
    }
    openTests.decide();
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
