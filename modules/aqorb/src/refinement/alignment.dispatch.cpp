// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Pyramids and windows of patches, and their alignment on several threads.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "common/images.hpp"
#include "refinement/alignment.hpp"

#include "refinement/alignment.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, BASELINE on x86-64.
#include "refinement/alignment.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

namespace
{

const int MAX_LEVELS = 5;  // a pixel of the last level has 16 x 16 pixels of the image
// Side of a window: MAX_PATCH_REACH pixels on both sides of the position, and a margin for interpolation.
const int WINDOW_SIDE = 2 * MAX_PATCH_REACH + 4;

int levelOf(double spacing)
{
    int level = 0;
    while (level < MAX_LEVELS - 1 && spacing >= (2 << level))
        level++;
    return level;
}

// Position on the level whose pixels have this size.
Point2d positionOn(double size, const Point2f& center)
{
    return Point2d((center.x + 0.5) / size - 0.5, (center.y + 0.5) / size - 0.5);
}

// First pixel of the window around a position of a level.
Point windowOrigin(const Point2d& position)
{
    return Point(std::max(cvFloor(position.x) - MAX_PATCH_REACH - 1, 0),
                 std::max(cvFloor(position.y) - MAX_PATCH_REACH - 1, 0));
}

// Halves an image: means of 2 x 2 pixels. The last column or row counts twice if their number is odd. cv::resize would
// use other threads even under a SingleThreadScope.
Mat halfOf(const Mat& image)
{
    Mat half((image.rows + 1) / 2, (image.cols + 1) / 2, CV_8UC1);
    const int pairs = image.cols / 2;
    for (int y = 0; y < half.rows; y++)
    {
        const uchar* const upper = image.ptr(2 * y);
        const uchar* const lower = image.ptr(std::min(2 * y + 1, image.rows - 1));
        uchar* const out = half.ptr(y);
        for (int x = 0; x < pairs; x++)
            out[x] = uchar((upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1] + 2) >> 2);
        if (pairs < half.cols)
            out[pairs] = uchar((upper[2 * pairs] + lower[2 * pairs] + 1) >> 1);
    }
    return half;
}

}  // namespace

PatchPyramid::PatchPyramid(InputArray input, const char* name, bool isNeeded)
{
    if (input.empty() && isNeeded)
        CV_Error_(Error::StsBadArg, ("%s must have pixels, as there are matches", name));
    if (input.empty())
        return;
    checkImage(input, name);
    checkPyramidInput(input.size(), name);
    retained = retainUMat(input);
    image = input.getMat();
    levels.push_back(image.channels() == 1 && image.step <= size_t(MAX_WINDOW_STEP) ? image : Mat());
}

bool PatchPyramid::hasLevel(int level) const
{
    return size_t(level) < levels.size() && !levels[size_t(level)].empty();
}

int PatchPyramid::prepare(const std::vector<PatchLocation>& patches)
{
    int highest = 0;
    double pixels = 0;  // pixels that single patches would convert
    for (const PatchLocation& patch : patches)
    {
        const int level = levelOf(patch.spacing);
        highest = std::max(highest, level);
        if (!hasLevel(level))
            pixels += std::min(double(WINDOW_SIDE << level) * (WINDOW_SIDE << level), double(image.total()));
    }
    if (pixels < double(image.total()) || patches.empty())
        return int(levels.size());
    if (levels[0].empty())
        levels[0] = image.channels() == 1 ? image.clone() : grayImage(image);
    return highest + 1;
}

void PatchPyramid::makeLevels(int count)
{
    while (int(levels.size()) < count)
        levels.push_back(halfOf(levels.back()));
}

int PatchPyramid::findWindow(const PatchLocation& patch, LevelWindow& window, Mat& space) const
{
    const double MAX_SPACING = 1 << 16, MARGIN = 0.01;  // far beyond any patch; absorbs rounding
    if (!(patch.spacing > 0 && patch.spacing < MAX_SPACING))
        return 0;
    const int level = levelOf(patch.spacing), size = 1 << level;
    const Point2d p = positionOn(size, patch.center);
    const double right = double(image.cols) / size - 1, bottom = double(image.rows) / size - 1;
    if (!(p.x > 0 && p.y > 0 && p.x < right && p.y < bottom))
        return 0;
    const Point origin = windowOrigin(p);
    window.x = float(p.x - origin.x);
    window.y = float(p.y - origin.y);
    window.left = float(std::max(p.x - MAX_PATCH_REACH, MARGIN) - origin.x);
    window.top = float(std::max(p.y - MAX_PATCH_REACH, MARGIN) - origin.y);
    window.right = float(std::min(p.x + MAX_PATCH_REACH, right - MARGIN) - origin.x);
    window.bottom = float(std::min(p.y + MAX_PATCH_REACH, bottom - MARGIN) - origin.y);
    if (hasLevel(level))
    {
        const Mat& pixels = levels[size_t(level)];
        window.origin = pixels.ptr(origin.y) + origin.x;
        window.step = int(pixels.step);
        return size;
    }
    const Rect wanted(origin.x * size, origin.y * size, WINDOW_SIDE * size, WINDOW_SIDE * size);
    const Mat part = image(wanted & Rect(Point(), image.size()));
    space = image.channels() == 1 ? part.clone() : grayImage(part);
    for (int i = 0; i < level; i++)
        space = halfOf(space);
    window.origin = space.ptr();
    window.step = int(space.step);
    return size;
}

static void alignPatches(const LevelPatches* patches, int count, LevelAlignment* alignments)
{
    CV_TRACE_FUNCTION();
    CV_CPU_DISPATCH(alignByLanes, (patches, count, alignments), CV_CPU_DISPATCH_MODES_ALL);
}

PatchAligner::PatchAligner(InputArray image1, InputArray image2, bool areNeeded)
    : pyramids{{image1, "image1", areNeeded}, {image2, "image2", areNeeded}}
{
}

//! An alignment that began at `start`, on a level whose pixels have this size, in pixels of the image.
static PatchAlignment onImage(const LevelAlignment& found, double size, const Point2f& start)
{
    const Point origin = windowOrigin(positionOn(size, start));
    const Point2f center(float((origin.x + double(found.x) + 0.5) * size - 0.5),
                         float((origin.y + double(found.y) + 0.5) * size - 0.5));
    const float CALIBRATION = 3.5f;  // on photographs at least 68 % of the errors are smaller
    const float deviation = found.variance >= 0 ? CALIBRATION * std::sqrt(found.variance) * float(size)
                                                : std::numeric_limits<float>::infinity();
    return {center,
            Matx22d(found.map[0] * size, found.map[1] * size, found.map[2] * size, found.map[3] * size),
            found.correlation, deviation};
}

// Aligns pairs on one thread.
static void alignSome(const PatchPyramid& first, const PatchPyramid& second, const PatchPair* pairs,
                      size_t count, PatchAlignment* alignments)
{
    std::vector<LevelPatches> patches;
    std::vector<size_t> indices;
    std::vector<int> sizes;
    std::vector<Mat> spaces;
    for (size_t i = 0; i < count; i++)
    {
        const PatchPair& pair = pairs[i];
        alignments[i] = {pair.second.center, pair.map, NOT_ALIGNED, std::numeric_limits<float>::infinity()};
        LevelPatches wanted;
        Mat space[2];
        const int firstSize = first.findWindow(pair.first, wanted.first, space[0]),
                  secondSize = second.findWindow(pair.second, wanted.second, space[1]);
        if (firstSize == 0 || secondSize == 0)
            continue;
        wanted.spacing = float(pair.first.spacing / firstSize);
        for (int k = 0; k < 4; k++)
            wanted.map[k] = float(pair.map.val[k] / secondSize);
        patches.push_back(wanted);
        indices.push_back(i);
        sizes.push_back(secondSize);
        spaces.insert(spaces.end(), space, space + 2);
    }
    std::vector<LevelAlignment> found(patches.size());
    alignPatches(patches.data(), int(patches.size()), found.data());
    for (size_t k = 0; k < found.size(); k++)
        if (found[k].correlation != NOT_ALIGNED)
            alignments[indices[k]] = onImage(found[k], sizes[k], pairs[indices[k]].second.center);
}

std::vector<PatchAlignment> PatchAligner::align(const std::vector<PatchPair>& pairs, bool isReversed)
{
    PatchPyramid &first = pyramids[isReversed], &second = pyramids[!isReversed];
    const int threads = threadsAllowed();
    std::vector<PatchLocation> locations[2];
    for (const PatchPair& pair : pairs)
    {
        locations[0].push_back(pair.first);
        locations[1].push_back(pair.second);
    }
    const int counts[] = {first.prepare(locations[0]), second.prepare(locations[1])};
    forEach(2, threads, [&](size_t i, int) { (i == 0 ? first : second).makeLevels(counts[i]); });

    // Each thread takes some pairs at a time.
    const size_t CHUNK = 64;
    std::vector<PatchAlignment> alignments(pairs.size());
    forEach((pairs.size() + CHUNK - 1) / CHUNK, threads,
            [&](size_t chunk, int)
            {
                const size_t begin = chunk * CHUNK, count = std::min(CHUNK, pairs.size() - begin);
                alignSome(first, second, &pairs[begin], count, &alignments[begin]);
            });
    return alignments;
}

}  // namespace aqorb
}  // namespace cv
