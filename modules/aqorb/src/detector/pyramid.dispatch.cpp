// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Resizes each level from the level before, as cv::resize with INTER_LINEAR_EXACT does.

#include "precomp.hpp"

#include "common/for_each.hpp"
#include "detector/pyramid.hpp"
#include "detector/types.hpp"

#include "detector/pyramid.simd.hpp"
// Generated: CV_CPU_DISPATCH_MODES_ALL=AVX512_SKX, AVX2, SSE4_1, BASELINE on x86-64.
#include "detector/pyramid.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{

float levelScale(int level, int firstLevel, double scaleFactor)
{
    return float(std::pow(scaleFactor, double(level - firstLevel)));
}

Size levelSize(Size imageSize, float scale)
{
    const float inverse = 1.f / scale;
    const float width = imageSize.width * inverse, height = imageSize.height * inverse;
    const float limit = float(MAX_LEVEL_SIDE);
    if (!(width <= limit && height <= limit))
        CV_Error_(Error::StsOutOfRange, ("scaleFactor and firstLevel must give levels of at most %d pixels a "
                                         "side, got %g x %g for an image of %d x %d",
                                         MAX_LEVEL_SIDE, width, height, imageSize.width, imageSize.height));
    return Size(cvRound(width), cvRound(height));
}

// First and last source pixel with a weight other than 0.
static int firstUsed(const ResizeTaps& taps)
{
    return taps.secondWeight < 256 ? taps.first : taps.second;
}
static int lastUsed(const ResizeTaps& taps)
{
    return taps.secondWeight > 0 ? taps.second : taps.first;
}

struct ResizeTables
{
    Size source, destination;
    std::vector<ResizeTaps> columnTaps, rowTaps;
    bool byKernel = false;  // whether the kernel can do this resize; without it there are no blocks
    AlignedVector<ResizeBlock> blocks;
    std::vector<int> bases;
    AlignedVector<short> rows;
};

// Computes the taps of the destination pixels along one axis, in OpenCV's arithmetic: each rounding counts.
static void linearTaps(int sourceLength, int length, std::vector<ResizeTaps>& taps)
{
    taps.resize(length);
    const double scale = 1.0 / (double(length) / sourceLength);
    for (int i = 0; i < length; i++)
    {
        const double center = scale * (i + 0.5) - 0.5;
        const int first = cvFloor(center);
        const bool between = first >= 0 && first < sourceLength - 1;
        taps[i].first = std::min(std::max(first, 0), sourceLength - 1);
        taps[i].second = between ? first + 1 : taps[i].first;
        taps[i].secondWeight = between ? cvRound((center - first) * 256) : 0;
    }
}

// Makes the tables of the horizontal pass. Returns false if a group needs more source pixels than the kernel loads.
static bool resizeBlocks(int sourceWidth, const ResizeTaps* taps, int width, ResizeTables& tables)
{
    const int GROUP = ResizeBlock::GROUP, GROUPS = ResizeBlock::GROUPS, BYTES = ResizeBlock::BYTES;
    if (sourceWidth < BYTES)
        return false;
    const int blocks = (width + ResizeBlock::PIXELS - 1) / ResizeBlock::PIXELS;
    tables.blocks.resize(blocks);
    tables.bases.resize(blocks * GROUPS);
    for (int i = 0; i < blocks * GROUPS; i++)
    {
        ResizeBlock& block = tables.blocks[i / GROUPS];
        const int group = i % GROUPS;
        const int base = std::min(taps[std::min(i * GROUP, width - 1)].first, sourceWidth - BYTES);
        tables.bases[i] = base;
        for (int j = 0; j < GROUP; j++)
        {
            const ResizeTaps& tap = taps[std::min(i * GROUP + j, width - 1)];
            if (tap.second - base >= BYTES)
                return false;
            const int weight = tap.secondWeight;
            const bool isOne = weight == 0 || weight == 256;
            block.pairs[group][2 * j] = uchar(firstUsed(tap) - base);
            block.pairs[group][2 * j + 1] = uchar(lastUsed(tap) - base);
            block.weights[group][2 * j] = uchar(isOne ? 255 : 256 - weight);
            block.weights[group][2 * j + 1] = uchar(isOne ? 1 : weight);
        }
    }
    return true;
}

static bool resizeByKernel(const Resize& resize)
{
    CV_CPU_DISPATCH(resizeRows, (resize), CV_CPU_DISPATCH_MODES_ALL);
}

// Resizes without the kernel. cv::resize gives the same pixels but ignores SingleThreadScope.
static void resizePlainly(const Mat& source, const ResizeTables& tables, const Range& rows, Mat& destination)
{
    for (int y = rows.start; y < rows.end; y++)
    {
        const ResizeTaps& row = tables.rowTaps[y];
        const uchar *upper = source.ptr(row.first), *lower = source.ptr(row.second);
        uchar* const out = destination.ptr(y);
        for (int x = 0; x < destination.cols; x++)
        {
            const ResizeTaps& column = tables.columnTaps[x];
            const auto between = [&](const uchar* p) {
                return p[column.first] * (256 - column.secondWeight) + p[column.second] * column.secondWeight;
            };
            const int sum = between(upper) * (256 - row.secondWeight) + between(lower) * row.secondWeight;
            out[x] = uchar((sum + (1 << 15)) >> 16);
        }
    }
}

static void updateTables(ResizeTables& tables, Size source, Size destination)
{
    if (tables.source == source && tables.destination == destination)
        return;
    tables.source = tables.destination = Size();  // marks the tables invalid in case memory runs out below
    linearTaps(source.width, destination.width, tables.columnTaps);
    linearTaps(source.height, destination.height, tables.rowTaps);
    tables.byKernel = resizeBlocks(source.width, tables.columnTaps.data(), destination.width, tables);
    tables.source = source;
    tables.destination = destination;
}

void resizeExact(const Mat& source, Mat& destination, Ptr<ResizeTables>& kept, int threads)
{
    CV_TRACE_FUNCTION();
    if (!kept)
        kept = makePtr<ResizeTables>();
    ResizeTables& tables = *kept;
    updateTables(tables, source.size(), destination.size());
    // Smallest band of rows for a thread. Writing memory that another thread has read is slow, so small bands pay.
    const int MIN_ROWS = 64;
    const int bands = std::max(std::min(threads, destination.rows / MIN_ROWS), 1);
    const size_t pixels = tables.byKernel ? tables.blocks.size() * ResizeBlock::PIXELS : 0;
    const size_t bandSize = 2 * pixels + ResizeBlock::PIXELS;
    short* const rows = growTo(tables.rows, bands * bandSize);
    forEach(size_t(bands), threads,
            [&](size_t i, int)
            {
                const int top = int(i * destination.rows / bands),
                          end = int((i + 1) * destination.rows / bands);
                Resize resize;
                resize.source = source.ptr();
                resize.sourceStep = ptrdiff_t(source.step);
                resize.destination = destination.ptr(top);
                resize.destinationStep = ptrdiff_t(destination.step);
                resize.width = destination.cols;
                resize.height = end - top;
                resize.blocks = tables.blocks.data();
                resize.bases = tables.bases.data();
                resize.rowTaps = &tables.rowTaps[top];
                resize.rows[0] = rows + i * bandSize;
                resize.rows[1] = resize.rows[0] + pixels;
                if (!tables.byKernel || !resizeByKernel(resize))
                    resizePlainly(source, tables, Range(top, end), destination);
            });
}

// Resizes a mask by the tables of its image. A pixel is usable if all its source pixels are.
static void resizeMask(const Mat& mask, const ResizeTables& tables, Mat& resized)
{
    std::vector<int> left, right;
    for (const ResizeTaps& taps : tables.columnTaps)
    {
        left.push_back(firstUsed(taps));
        right.push_back(lastUsed(taps));
    }
    const int *const lefts = left.data(), *const rights = right.data();
    std::vector<uchar> bothRows(mask.cols);  // whether both source pixels of a column are usable
    uchar* const both = bothRows.data();
    const int sourceWidth = mask.cols, width = resized.cols, AT_ONCE = 64;
    for (int y = 0; y < resized.rows; y++)
    {
        const uchar* upper = mask.ptr(firstUsed(tables.rowTaps[y]));
        const uchar* lower = mask.ptr(lastUsed(tables.rowTaps[y]));
        for (int x = 0; x < sourceWidth; x++)
            both[x] = std::min(upper[x], lower[x]) > 0 ? 255 : 0;
        uchar* out = resized.ptr(y);
        // Most runs of pixels are usable or masked as a whole.
        for (int begin = 0, end; begin < width; begin = end)
        {
            end = std::min(begin + AT_ONCE, width);
            const uchar* const used = both + lefts[begin];
            const size_t count = size_t(rights[end - 1] + 1 - lefts[begin]);
            if (!std::memchr(used, 0, count))
                std::memset(out + begin, 255, size_t(end - begin));
            else if (!std::memchr(used, 255, count))
                std::memset(out + begin, 0, size_t(end - begin));
            else
                for (int x = begin; x < end; x++)
                    out[x] = both[lefts[x]] & both[rights[x]];
        }
    }
}

static void rejectMemory(const Size& imageSize, const PyramidRule& rule, double pixels)
{
    CV_Error_(
        Error::StsNoMem,
        ("scaleFactor and firstLevel must give levels that fit the memory, with at most 2^30 pixels in the "
         "enlarged levels, got %g and %d, which give %.0f pixels for an image of %d x %d",
         rule.scaleFactor, rule.firstLevel, pixels, imageSize.width, imageSize.height));
}

// Allocates the levels.
static std::vector<Level> layOut(const Level& input, const PyramidRule& rule, PyramidSpace& space)
{
    const Size imageSize = input.image.size();
    const double MAX_ENLARGED_PIXELS = 1 << 30;  // protects against a mistyped scaleFactor or firstLevel
    double pixels = 0;
    std::vector<Level> levels;
    for (int i = 0; i < rule.levels; i++)
    {
        Level level;
        level.scale = levelScale(i, rule.firstLevel, rule.scaleFactor);
        const Size size = levelSize(imageSize, level.scale);
        if (std::min(size.width, size.height) < rule.shortestSide)
            break;
        if (space.levels.size() <= size_t(i))
            space.levels.resize(size_t(i) + 1);
        level.isInput = i == rule.firstLevel;
        if (level.isInput)
        {
            level.image = input.image;
            level.mask = input.mask;
        }
        pixels += level.isInput ? 0 : double(size.width) * size.height;
        if (i < rule.firstLevel && pixels > MAX_ENLARGED_PIXELS)
            rejectMemory(imageSize, rule, pixels);
        try
        {
            // Rows begin at cache lines, so few vectors cross one.
            const size_t step = alignSize(size_t(size.width), CACHE_LINE), rows = size_t(size.height);
            PyramidSpace::LevelSpace& levelSpace = space.levels[i];
            if (!level.isInput)
                level.image = Mat(size, CV_8UC1, growTo(levelSpace.pixels, step * rows), step);
            if (!level.isInput && !input.mask.empty())
                level.mask = Mat(size, CV_8UC1, growTo(levelSpace.mask, step * rows), step);
        }
        catch (const std::exception&)
        {
            rejectMemory(imageSize, rule, pixels);
        }
        levels.push_back(level);
    }
    return levels;
}

std::vector<Level> makePyramid(const Level& input, const PyramidRule& rule, int threads, PyramidSpace& space)
{
    CV_TRACE_FUNCTION();
    std::vector<Level> levels = layOut(input, rule, space);
    for (int i = 0; i < int(levels.size()); i++)
    {
        if (levels[i].isInput)
            continue;
        // As in cv::ORB, all enlarged levels and the first reduced level come from the image.
        const Level& source = i <= rule.firstLevel + 1 ? input : levels[i - 1];
        Ptr<ResizeTables>& tables = space.levels[i].resizing;
        resizeExact(source.image, levels[i].image, tables, threads);
        if (!source.mask.empty())
            resizeMask(source.mask, *tables, levels[i].mask);
    }
    return levels;
}

}  // namespace aqorb
}  // namespace cv
