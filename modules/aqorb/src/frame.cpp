// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "frame.hpp"
#include "input.hpp"
#include "plan.hpp"
#include "threshold.hpp"

namespace cv
{
namespace aqorb
{

using namespace stages;

Tables::Tables(const Parameters& parameters)
    : patch(circularPatch(parameters.patchSize)),
      strengthPatch(patch.halfWidths, std::max(1, parameters.patchSize / 2 / 5)),
      tests(descriptorPattern(parameters.patchSize, parameters.WTA_K), parameters.WTA_K)
{
    // Other values have no quotas. Detection throws for them.
    if (parameters.nlevels == 1 || parameters.scaleFactor > 1)
        quotas = levelQuotas(parameters.nfeatures, parameters.scaleFactor, parameters.nlevels);
}

Frame::Frame(const Parameters& parameters_, const Tables& tables_, Workspace& workspace_)
    : parameters(parameters_),
      tables(tables_),
      workspace(workspace_),
      levels(workspace_.levels),
      threads(TaskQueue::threadsInUse()),
      areGiven(false),
      withDescriptors(true)
{
}

Frame::~Frame()
{
    // An exception may have left tasks in the queue that no worker has seen.
    workspace.queue.clear();
}

void Frame::put(Kind kind, int level, int part)
{
    // With one thread a level is described while its rows are in the cache. With several, what is to be described is left
    // for when there is nothing else to do.
    const int first = kind == DESCRIBE && threads == 1 ? 0 : int(kind) + 1;
    const Task task = {kind, level, part};
    workspace.queue.put((first << 20) - level, task);
}

void Frame::runTasks()
{
    if (workspace.scratches.size() < size_t(threads))
        workspace.scratches.resize(size_t(threads));
    workspace.queue.run(threads, *this);
}

void Frame::run(const Task& task, int worker)
{
    WorkerScratch& scratch = workspace.scratches[worker];
    switch (task.kind)
    {
    case MEASURE:
        return measure();
    case MAKE:
        return make(task.level);
    case SEARCH:
        return search(task.level, task.part, scratch);
    case ORDER:
        return order(task.level, scratch);
    case SELECT:
        return select(task.level, scratch);
    default:
        return describe(task.level, task.part, scratch);
    }
}

void Frame::detect(bool withDescriptors_)
{
    withDescriptors = withDescriptors_;
    parameters.checkTogether(parameters.nlevels);
    workspace.layOutLevels(parameters.nlevels, parameters.firstLevel, parameters.scaleFactor,
                           shortestSide(parameters));
    if (workspace.levelCount == 0)
        return;
    planLevels();
    put(MEASURE, 0);
    put(MAKE, 0);
    runTasks();
}

void Frame::planLevels()
{
    const int count = workspace.levelCount, border = parameters.edgeThreshold;
    const bool isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    DetectionRules rules;
    rules.thresholds.ini = rules.thresholds.min = 0;  // to be measured
    rules.cellSize = parameters.cellSize;
    rules.rankByHarris = parameters.scoreType == ORB::HARRIS_SCORE;
    rules.count = &workspace.keptCount;
    rules.strengthPatch = &tables.strengthPatch;
    workspace.regions.clear();
    double pixels = 0;
    for (int i = 0; i < count; i++)
    {
        const Size size = levels[i].level.image.size();
        workspace.regions.push_back(Size(size.width - 2 * border, size.height - 2 * border));
        pixels += double(size.width) * size.height;
    }
    if (isRanked)
        areaQuotas(parameters.nfeatures, workspace.regions, workspace.areaQuotas);
    const std::vector<int>& quotas = isRanked ? workspace.areaQuotas : tables.quotas;
    workspace.keptCount.begin(parameters.nfeatures, pixels);
    // Several threads share about four bands each.
    const double pixelsOfBand = threads == 1 ? pixels : pixels / (4 * threads);
    for (int i = 0; i < count; i++)
    {
        LevelWork& work = levels[i];
        // Levels too small for a keypoint leave their quotas to the next finer one.
        const int added = i < count - 1 ? 0 : std::accumulate(quotas.begin() + count, quotas.end(), 0);
        work.selection = planLevel(parameters, work.level, quotas[i], added);
        const int bands = cvCeil(double(work.level.image.total()) / pixelsOfBand);
        work.bandsLeft = work.detection.begin(work.level, work.selection.order.root, rules, bands);
        work.inputsOfSearch = 2;
        work.inputsOfSelection = i == count - 1 ? 1 : 2;
    }
}

// Finds the thresholds of the image.
void Frame::measure()
{
    CV_TRACE_REGION("measure");
    const Level& input = workspace.input;
    const Thresholds thresholds =
        parameters.adaptiveThreshold
            ? adaptiveThresholds(varianceOverMean(input.image, input.mask), parameters.fastThreshold,
                                 parameters.minThresholdRatio)
            : fixedThresholds(parameters.fastThreshold, parameters.minThresholdRatio);
    for (int i = 0; i < workspace.levelCount; i++)
        levels[i].detection.setThresholds(thresholds);
    for (int i = workspace.levelCount - 1; i >= 0; i--)
        searchWhenReady(i);
}

// Makes the pixels of a level.
void Frame::make(int level)
{
    CV_TRACE_REGION("make");
    workspace.makeLevel(level, parameters.firstLevel);
    const bool isLast = level == workspace.levelCount - 1;
    const bool isMasked = !areGiven && !workspace.input.mask.empty();
    // The next level is made from this mask as it is, so masks are completed at the end.
    if (!isMasked && !areGiven)
        planOrder(parameters, Mat(), levels[level].selection);
    if (!isLast)
        put(MAKE, level + 1);
    else if (isMasked)
        completeMasks();
    if (areGiven)
        putRanges(level, 0);
    else if (!isMasked)
        searchWhenReady(level);
}

// Clears the pixels of masks that have no usable position in the image, and goes on with all levels.
void Frame::completeMasks()
{
    for (int i = 0; i < workspace.levelCount; i++)
    {
        Level& masked = levels[i].level;
        if (!masked.isInput)
            maskPositions(workspace.input.mask, rulesOf(i).position, masked.mask, workspace.maskColumns);
        planOrder(parameters, masked.mask, levels[i].selection);
    }
    for (int i = workspace.levelCount - 1; i >= 0; i--)
        searchWhenReady(i);
}

void Frame::searchWhenReady(int level)
{
    LevelWork& work = levels[level];
    if (CV_XADD(&work.inputsOfSearch, -1) != 1)
        return;
    // A level without a quota is not searched unless selection asks for its corners.
    if (work.selection.quota == 0)
        return selectWhenReady(level);
    for (int i = 0, bands = work.bandsLeft; i < bands; i++)
        put(SEARCH, level, i);
}

// Finds the corners of a band.
void Frame::search(int level, int band, WorkerScratch& scratch)
{
    CV_TRACE_REGION("search");
    LevelWork& work = levels[level];
    work.detection.searchBand(band, scratch.detection);
    if (CV_XADD(&work.bandsLeft, -1) == 1)
        put(ORDER, level);
}

// Puts the corners of a level in the order in which they are chosen.
void Frame::order(int level, WorkerScratch& scratch)
{
    CV_TRACE_REGION("order");
    levels[level].detection.order(levels[level].selection.order, scratch.detection);
    selectWhenReady(level);
}

void Frame::selectWhenReady(int level)
{
    if (CV_XADD(&levels[level].inputsOfSelection, -1) == 1)
        put(SELECT, level);
}

// Chooses the features of a level.
void Frame::select(int level, WorkerScratch& scratch)
{
    CV_TRACE_REGION("select");
    FeatureSelector& selector = workspace.selector;
    if (level == workspace.levelCount - 1)
    {
        selector.begin(
            workspace.input.image.size(), parameters.octaveSuppressionInUse(),
            parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION ? 1 : parameters.nlevels);
        for (int i = 0; i <= level; i++)
            selector.addLevel(levels[i].selection);
    }
    LevelWork& work = levels[level];
    if (selector.wantsOf(level) > 0)
        selector.offer(work.detection.sequence(work.selection.order, scratch.detection));
    collect(level, 0, scratch);
    if (level > 0)
        return selectWhenReady(level - 1);
    fillUp(scratch);
}

// Chooses more features if the quotas of the levels did not yield as many as are wanted.
void Frame::fillUp(WorkerScratch& scratch)
{
    CV_TRACE_FUNCTION();
    FeatureSelector& selector = workspace.selector;
    CornerRequest request;
    while (selector.wants(request))
    {
        LevelWork& work = levels[request.level];
        LevelDetection& detection = work.detection;
        if (request.set == SEQUENCE_CORNERS)
        {
            selector.offer(detection.sequence(work.selection.order, scratch.detection));
        }
        else
        {
            detection.list(request.set, scratch.detection, scratch.corners);
            selector.offer(scratch.corners);
        }
    }
    for (int i = 0; i < workspace.levelCount; i++)
        collect(i, 1, scratch);
}

// Makes a batch of the features of a level that have been chosen since the batch before.
void Frame::collect(int level, int index, WorkerScratch& scratch)
{
    LevelWork& work = levels[level];
    FeatureBatch& batch = work.batches[index];
    const size_t first = index == 0 ? 0 : work.batches[0].points.size();
    workspace.selector.chosen(level, first, scratch.corners);
    const size_t count = scratch.corners.size();
    batch.points.resize(count);
    batch.keypoints.resize(count);
    batch.order.resize(count);
    const bool isRanked = parameters.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION;
    for (size_t i = 0; i < count; i++)
    {
        const RankedCorner& corner = scratch.corners[i];
        const FeaturePoint point = {corner.x, corner.y, 0};
        batch.points[i] = point;
        batch.keypoints[i] =
            KeyPoint(Point2f(), parameters.patchSize * work.level.scale, -1, corner.response, level);
        batch.order[i] = isRanked ? ~unsignedOrderOf(corner.response) : 0;
    }
    putRanges(level, index);
}

// At least so many features that a task is worth while, and so many tasks that no thread waits long for another one.
size_t Frame::featuresOfRange() const
{
    const size_t LEAST = 64;
    return threads == 1 ? size_t(INT_MAX) : std::max(size_t(parameters.nfeatures) / (4 * threads), LEAST);
}

void Frame::putRanges(int level, int index)
{
    FeatureBatch& batch = levels[level].batches[index];
    if (withDescriptors)
        batch.descriptors.resize(batch.points.size() * DESCRIPTOR_BYTES);
    const size_t most = featuresOfRange(), parts = (batch.points.size() + most - 1) / most;
    for (size_t i = 0; i < parts; i++)
        put(DESCRIBE, level, int(2 * i) + index);
}

DescriptionRules Frame::rulesOf(int level) const
{
    const Level& described = levels[level].level;
    const PositionMap position = {workspace.input.image.size(), described.image.size(), described.scale,
                                  parameters.edgeThreshold, parameters.subPixel};
    const DescriptionRules rules = {&workspace.input.mask, position, areGiven ? 0 : &tables.patch,
                                    withDescriptors ? &tables.tests : 0};
    return rules;
}

// Describes a part of the features of a batch.
void Frame::describe(int level, int part, WorkerScratch& scratch)
{
    CV_TRACE_REGION("describe");
    FeatureBatch& batch = levels[level].batches[part % 2];
    const size_t count = batch.points.size(), most = featuresOfRange(), parts = (count + most - 1) / most;
    const size_t index = size_t(part / 2);
    describeFeatures(levels[level].level, rulesOf(level),
                     Range(int(count * index / parts), int(count * (index + 1) / parts)), batch,
                     scratch.description);
}

void Frame::describeGiven(const std::vector<KeyPoint>& given)
{
    areGiven = true;
    const Size imageSize = workspace.input.image.size();
    const int highest = highestOctave(given);
    parameters.checkTogether(std::max(parameters.nlevels, highest > 0 ? 2 : 1));
    const Size smallest =
        levelSize(imageSize, levelScale(highest, parameters.firstLevel, parameters.scaleFactor));
    if (smallest.width < 1 || smallest.height < 1)
        CV_Error_(Error::StsOutOfRange,
                  ("keypoints: got octave %d, whose level would have no pixels; an octave of a "
                   "level of at least 1 x 1 pixels is accepted (SIFT packs more than the octave "
                   "into the field: unpack it first)",
                   highest));

    std::vector<KeyPoint>& inside = workspace.given;
    describableKeypoints(given, imageSize, parameters.edgeThreshold, inside);
    workspace.layOutLevels(inside.empty() ? 0 : highestOctave(inside) + 1, parameters.firstLevel,
                           parameters.scaleFactor, 1);
    std::vector<GivenFeature>& features = workspace.givenFeatures;
    features.clear();
    for (size_t i = 0; i < inside.size(); i++)
    {
        const KeyPoint& keypoint = inside[i];
        const float inverseScale = 1.f / levels[keypoint.octave].level.scale;
        const GivenFeature feature = {
            {cvRound(keypoint.pt.x * inverseScale), cvRound(keypoint.pt.y * inverseScale), keypoint.angle},
            keypoint.octave,
            unsigned(i)};
        features.push_back(feature);
    }
    std::sort(features.begin(), features.end(),
              [](const GivenFeature& a, const GivenFeature& b)
              { return a.octave != b.octave ? a.octave < b.octave : InRasterOrder()(a.point, b.point); });
    size_t next = 0;
    for (int i = 0; i < workspace.levelCount; i++)
    {
        FeatureBatch& batch = levels[i].batches[0];
        batch.points.clear();
        batch.keypoints.clear();
        batch.order.clear();
        for (; next < features.size() && features[next].octave == i; next++)
        {
            batch.points.push_back(features[next].point);
            batch.keypoints.push_back(inside[features[next].index]);
            batch.order.push_back(features[next].index);
        }
        levels[i].batches[1].points.clear();
    }
    if (workspace.levelCount == 0)
        return;
    put(MAKE, 0);
    runTasks();
}

size_t Frame::count() const
{
    size_t sum = 0;
    for (int i = 0; i < workspace.levelCount; i++)
        sum += levels[i].batches[0].points.size() + levels[i].batches[1].points.size();
    return sum;
}

void Frame::output(std::vector<KeyPoint>& keypoints, Mat& descriptors) const
{
    CV_TRACE_FUNCTION();
    keypoints.resize(count());
    int next = 0;
    for (int level = 0; level < workspace.levelCount; level++)
    {
        const FeatureBatch& first = levels[level].batches[0];
        const FeatureBatch& second = levels[level].batches[1];
        // The number of each feature in raster order tells apart those that the order does not.
        std::vector<unsigned>& rasterOrder = workspace.rasterOrder;
        rasterOrder.clear();
        const unsigned inFirst = unsigned(first.points.size()),
                       count = inFirst + unsigned(second.points.size());
        for (unsigned i = 0, j = inFirst; i < inFirst || j < count;)
        {
            const bool isFirst =
                j == count || (i < inFirst && InRasterOrder()(first.points[i], second.points[j - inFirst]));
            rasterOrder.push_back(isFirst ? i++ : j++);
        }
        std::vector<uint64>& numbers = workspace.numbers;
        numbers.resize(count);
        for (unsigned i = 0; i < count; i++)
        {
            const unsigned index = rasterOrder[i];
            numbers[i] = index < inFirst ? first.order[index] : second.order[index - inFirst];
        }
        sortIndices(numbers, workspace.sorting, workspace.places);
        for (unsigned i = 0; i < count; i++, next++)
        {
            const unsigned place = rasterOrder[workspace.places[i]];
            const FeatureBatch& batch = place < inFirst ? first : second;
            const size_t index = place < inFirst ? place : place - inFirst;
            keypoints[next] = batch.keypoints[index];
            if (!descriptors.empty())
                std::memcpy(descriptors.ptr(next), &batch.descriptors[index * DESCRIPTOR_BYTES],
                            DESCRIPTOR_BYTES);
        }
    }
}

}  // namespace aqorb
}  // namespace cv
