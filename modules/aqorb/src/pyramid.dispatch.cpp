// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "pyramid.hpp"

#include "pyramid.simd.hpp"
#include "pyramid.simd_declarations.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
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
        CV_Error_(
            Error::StsOutOfRange,
            ("scaleFactor, firstLevel: a level of an image of %d x %d pixels would be %g x %g pixels; at "
             "most %d a side are accepted",
             imageSize.width, imageSize.height, width, height, MAX_LEVEL_SIDE));
    return Size(cvRound(width), cvRound(height));
}

// Takes what is too much from the finest levels, which have the most to give up.
static void takeExcess(int64 excess, std::vector<int>& quotas)
{
    for (size_t level = 0; excess > 0; level++)
    {
        const int taken = int(std::min<int64>(excess, quotas[level]));
        quotas[level] -= taken;
        excess -= taken;
    }
}

std::vector<int> levelQuotas(int nfeatures, double scaleFactor, int nlevels)
{
    const float factor = float(1.0 / scaleFactor);
    float desired = factor == 1  // rounded to a float, where scaleFactor is hardly more than 1
                        ? float(nfeatures) / nlevels
                        : nfeatures * (1 - factor) / (1 - float(std::pow(double(factor), double(nlevels))));
    const float LARGEST_INT = 2147483520.f;  // the largest int that a float can hold
    std::vector<int> quotas(nlevels);
    int64 sum = 0;
    for (int level = 0; level < nlevels - 1; level++)
    {
        quotas[level] = cvRound(std::min(desired, LARGEST_INT));
        sum += quotas[level];
        desired *= factor;
    }
    quotas[nlevels - 1] = int(std::max<int64>(nfeatures - sum, 0));
    // The rounding of cv::ORB can ask for more than nfeatures.
    takeExcess(sum + quotas[nlevels - 1] - nfeatures, quotas);
    return quotas;
}

namespace
{
// The two source pixels from which INTER_LINEAR_EXACT makes a pixel.
struct Taps
{
    int first, second;
    int secondWeight;  // in 1/256

    // The first and the last one whose weight is not 0.
    int firstUsed() const { return secondWeight < 256 ? first : second; }
    int lastUsed() const { return secondWeight > 0 ? second : first; }
};
}  // namespace

struct ResizeTables
{
    ResizeTables() : byKernel(false) {}

    Size source, destination;
    bool byKernel;  // whether the kernel can do it; else there are no tables
    AlignedVector<ResizeBlock> blocks;
    AlignedVector<short> rows;
    std::vector<int> bases, upper, lower;
    std::vector<short> lowerWeight;
    std::vector<Taps> columnTaps, rowTaps;  // work space
    std::vector<uchar> mask;                // of the level
};

// The taps by destination pixel along one axis, in OpenCV's own arithmetic, as every rounding counts.
static void linearTaps(int sourceLength, int length, std::vector<Taps>& taps)
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

// Makes the tables of the horizontal pass. False: pixels of a group come from too many source pixels for the kernel.
static bool resizeBlocks(int sourceWidth, const Taps* taps, int width, ResizeTables& tables)
{
    const int GROUP = ResizeBlock::GROUP, GROUPS = ResizeBlock::GROUPS, BYTES = ResizeBlock::BYTES;
    if (sourceWidth < BYTES)
        return false;
    const int blocks = (width + ResizeBlock::PIXELS - 1) / ResizeBlock::PIXELS;
    tables.blocks.resize(blocks);
    tables.bases.resize(blocks * GROUPS);
    tables.rows.resize(2 * blocks * ResizeBlock::PIXELS);
    for (int i = 0; i < blocks * GROUPS; i++)
    {
        ResizeBlock& block = tables.blocks[i / GROUPS];
        const int group = i % GROUPS;
        const int base = std::min(taps[std::min(i * GROUP, width - 1)].first, sourceWidth - BYTES);
        tables.bases[i] = base;
        for (int j = 0; j < GROUP; j++)
        {
            const Taps& tap = taps[std::min(i * GROUP + j, width - 1)];
            if (tap.second - base >= BYTES)
                return false;
            const int weight = tap.secondWeight;
            const bool isOne = weight == 0 || weight == 256;
            block.pairs[group][2 * j] = uchar(tap.firstUsed() - base);
            block.pairs[group][2 * j + 1] = uchar(tap.lastUsed() - base);
            block.weights[group][2 * j] = uchar(isOne ? 255 : 256 - weight);
            block.weights[group][2 * j + 1] = uchar(isOne ? 1 : weight);
        }
    }
    return true;
}

static bool resizeByKernel(const Resize& resize, int begin, int end)
{
    CV_CPU_DISPATCH(resizeRows, (resize, begin, end), CV_CPU_DISPATCH_MODES_ALL);
}

static void updateTables(ResizeTables& tables, Size source, Size destination)
{
    if (tables.source == source && tables.destination == destination)
        return;
    tables.source = tables.destination = Size();  // they stay invalid if memory runs out below
    std::vector<Taps>&columns = tables.columnTaps, &rows = tables.rowTaps;
    linearTaps(source.width, destination.width, columns);
    linearTaps(source.height, destination.height, rows);
    tables.byKernel = resizeBlocks(source.width, columns.data(), destination.width, tables);
    tables.upper.resize(rows.size());
    tables.lower.resize(rows.size());
    tables.lowerWeight.resize(rows.size());
    for (size_t y = 0; y < rows.size(); y++)
    {
        tables.upper[y] = rows[y].first;
        tables.lower[y] = rows[y].second;
        tables.lowerWeight[y] = short(rows[y].secondWeight);
    }
    tables.source = source;
    tables.destination = destination;
}

static void resizeExact(const Mat& source, Mat& destination, ResizeTables& tables)
{
    CV_TRACE_FUNCTION();
    updateTables(tables, source.size(), destination.size());
    if (tables.byKernel)
    {
        Resize resize;
        resize.source = source.ptr();
        resize.sourceStep = ptrdiff_t(source.step);
        resize.destination = destination.ptr();
        resize.destinationStep = ptrdiff_t(destination.step);
        resize.width = destination.cols;
        resize.blocks = tables.blocks.data();
        resize.bases = tables.bases.data();
        resize.upper = tables.upper.data();
        resize.lower = tables.lower.data();
        resize.lowerWeight = tables.lowerWeight.data();
        resize.rows[0] = tables.rows.data();
        resize.rows[1] = tables.rows.data() + tables.rows.size() / 2;
        if (resizeByKernel(resize, 0, destination.rows))
            return;
    }
    cv::resize(source, destination, destination.size(), 0, 0, INTER_LINEAR_EXACT);
}

// A pixel is usable if all pixels that it is made from are.
static Mat resizeMask(const Mat& mask, Size size, ResizeTables& tables)
{
    std::vector<Taps>&columns = tables.columnTaps, &rows = tables.rowTaps;
    linearTaps(mask.cols, size.width, columns);
    linearTaps(mask.rows, size.height, rows);
    if (tables.mask.size() < size_t(size.area()))
        tables.mask.resize(size.area());
    Mat resized(size, CV_8UC1, tables.mask.data());
    for (int y = 0; y < size.height; y++)
    {
        const uchar* upper = mask.ptr(rows[y].firstUsed());
        const uchar* lower = mask.ptr(rows[y].lastUsed());
        uchar* out = resized.ptr(y);
        for (int x = 0; x < size.width; x++)
        {
            const int left = columns[x].firstUsed(), right = columns[x].lastUsed();
            out[x] = upper[left] && upper[right] && lower[left] && lower[right] ? 255 : 0;
        }
    }
    return resized;
}

void areaQuotas(int nfeatures, const std::vector<Size>& regions, std::vector<int>& quotas)
{
    double whole = 0;
    for (size_t level = 0; level < regions.size(); level++)
        whole += double(regions[level].width) * regions[level].height;
    quotas.assign(regions.size(), 0);
    int64 rest = nfeatures;
    for (size_t level = 1; level < regions.size(); level++)
    {
        const double area = double(regions[level].width) * regions[level].height;
        quotas[level] = cvRound(nfeatures * area / whole);
        rest -= quotas[level];
    }
    if (!regions.empty())
        quotas[0] = int(std::max<int64>(rest, 0));
    takeExcess(-rest, quotas);  // where many levels round up
}

bool layOutLevel(const Level& input, int index, int firstLevel, double scaleFactor, int minSide, Level& level,
                 AlignedVector<uchar>* memory)
{
    const float scale = levelScale(index, firstLevel, scaleFactor);
    const Size size = levelSize(input.image.size(), scale);
    if (std::min(size.width, size.height) < minSide)
        return false;
    level.scale = scale;
    level.isInput = index == firstLevel;
    level.mask.release();
    if (level.isInput)
    {
        level.image = input.image;
        level.mask = input.mask;
    }
    else if (memory)
    {
        // Rows begin where cache lines do, so that vectors cross as few of them as possible.
        const size_t step = alignSize(size_t(size.width), CACHE_LINE), bytes = step * size.height;
        if (memory->size() < bytes)
        {
            memory->reserve(bytes);
            memory->resize(bytes);
        }
        level.image = Mat(size, CV_8UC1, memory->data(), step);
    }
    else
    {
        level.image.create(size, CV_8UC1);
    }
    return true;
}

bool isMadeFromInput(int index, int firstLevel)
{
    return index <= firstLevel + 1;
}

void fillLevel(const Level& source, Level& level, Ptr<ResizeTables>& tables)
{
    CV_TRACE_FUNCTION();
    if (!tables)
        tables = makePtr<ResizeTables>();
    resizeExact(source.image, level.image, *tables);
    if (!source.mask.empty())
        level.mask = resizeMask(source.mask, level.image.size(), *tables);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
