// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "frame.hpp"
#include "threshold.hpp"

namespace cv
{
namespace aqorb
{

Frame::Frame(const Parameters& parameters_, const Tables& tables_, Workspace& workspace_)
    : parameters(parameters_),
      tables(tables_),
      workspace(workspace_),
      levels(workspace_.levels),
      work(workspace_.work),
      threads(TaskQueue::threadsInUse()),
      isRanked(parameters_.selectionType == AdaptiveQuadtreeORB::RANKED_SELECTION)
{
}

Frame::~Frame()
{
    // An exception may have left tasks in the queue that no worker has seen.
    workspace.queue.clear();
    levels.release();
}

void Frame::put(Kind kind, int level, int part, const Range& range)
{
    // With one thread a level is described while its rows are in the cache. With several, what is to be described is left
    // for when there is nothing else to do.
    const int first = kind == DESCRIBE && threads == 1 ? 0 : int(kind) + 1;
    workspace.queue.put((first << 20) - level, {kind, level, part, range});
}

void Frame::prepareWork(int count)
{
    levelCount = count;
    while (work.size() < size_t(levelCount))
        work.push_back(LevelWork());
    if (workspace.workers.size() < size_t(threads))
        workspace.workers.resize(size_t(threads));
}

void Frame::run()
{
    put(MAKE, 0);
    workspace.queue.run(threads, *this);
}

void Frame::run(const Task& task, int worker)
{
    WorkerScratch& scratch = workspace.workers[worker];
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
        return describe(task, scratch);
    }
}

void Frame::detect(bool withDescriptors_)
{
    withDescriptors = withDescriptors_;
    parameters.checkTogether(parameters.nlevels);
    prepareWork(levels.layOut(parameters.nlevels, shortestSide(parameters)));
    if (levelCount == 0)
        return;
    plan();
    put(MEASURE, 0);
    run();
}

// Plans the levels, and begins their detection and the selection.
void Frame::plan()
{
    DetectionRules rules;
    rules.corners.thresholds.ini = rules.corners.thresholds.min = 0;  // to be measured
    rules.corners.cellSize = parameters.cellSize;
    rules.useHarris = parameters.scoreType == ORB::HARRIS_SCORE;
    // Harris responses of neighbours hardly differ. Without suppression a strong corner would be chosen three times.
    rules.corners.suppressNear = rules.useHarris;
    rules.strengthPatch = &tables.strengthPatch;
    workspace.regions.clear();
    double pixels = 0;
    for (int i = 0; i < levelCount; i++)
    {
        const Size size = levels[i].image.size();
        workspace.regions.push_back({keypointRegion(parameters, size).size(), levels[i].scale});
        pixels += double(size.width) * size.height;
    }
    if (isRanked)
        rankedQuotas(parameters.nfeatures, workspace.regions, workspace.rankedQuotas);
    const std::vector<int>& quotas = isRanked ? workspace.rankedQuotas : tables.quotas;
    // Where a feature is wanted of so few pixels, corners that the rules pass over will probably be needed.
    const double FEW_PIXELS = 130;
    rules.corners.listPassedOver = pixels < FEW_PIXELS * parameters.nfeatures;
    // Several threads share about four bands each.
    const double pixelsOfBand = threads == 1 ? pixels : pixels / (4 * threads);
    for (int i = 0; i < levelCount; i++)
    {
        LevelWork& ofLevel = work[i];
        // Levels too small for a keypoint leave their quotas to the next finer one.
        const int added =
            i < levelCount - 1 ? 0 : std::accumulate(quotas.begin() + levelCount, quotas.end(), 0);
        ofLevel.plan = planLevel(parameters, levels[i], quotas[i], added);
        const int bands = cvCeil(double(levels[i].image.total()) / pixelsOfBand);
        ofLevel.bandsLeft = ofLevel.detection.reset(levels[i], ofLevel.plan.root, rules, bands);
        ofLevel.inputsOfSearch = 2;
        ofLevel.inputsOfSelection = i == levelCount - 1 ? 1 : 2;
    }
}

// Finds the thresholds of the image.
void Frame::measure()
{
    CV_TRACE_REGION("measure");
    const Level& input = levels.input();
    const double value =
        parameters.adaptiveThreshold ? varianceOverMean(input.image, input.mask) : NEUTRAL_VALUE;
    const Thresholds thresholds =
        fastThresholds(value, parameters.fastThreshold, parameters.minThresholdRatio);
    for (int i = 0; i < levelCount; i++)
        work[i].detection.setThresholds(thresholds);
    for (int i = levelCount - 1; i >= 0; i--)
        searchWhenReady(i);
}

// Makes the pixels of a level.
void Frame::make(int level)
{
    CV_TRACE_REGION("make");
    levels.make(level);
    const bool isLast = level == levelCount - 1, isMasked = !levels.input().mask.empty();
    if (!isLast)
        put(MAKE, level + 1);
    if (areGiven)
        return putRanges(level, BY_QUOTA);
    // The next level is made from this mask as it is, so masks are completed at the end.
    if (isMasked && isLast)
        completeMasks();
    if (isMasked)
        return;
    completePlan(parameters, Mat(), work[level].plan);
    searchWhenReady(level);
}

// Clears the pixels of masks that have no usable position in the image, and goes on with all levels.
void Frame::completeMasks()
{
    for (int i = 0; i < levelCount; i++)
    {
        if (!levels[i].isInput)
            maskPositions(levels.input().mask, rulesOf(i).position, levels[i].mask, workspace.maskColumns);
        completePlan(parameters, levels[i].mask, work[i].plan);
    }
    for (int i = levelCount - 1; i >= 0; i--)
        searchWhenReady(i);
}

void Frame::searchWhenReady(int level)
{
    LevelWork& ofLevel = work[level];
    if (CV_XADD(&ofLevel.inputsOfSearch, -1) != 1)
        return;
    // A level without a quota is not searched unless selection asks for its corners.
    if (ofLevel.plan.quota == 0)
        return selectWhenReady(level);
    for (int i = 0, bands = ofLevel.bandsLeft; i < bands; i++)
        put(SEARCH, level, i);
}

// Finds the corners of a band.
void Frame::search(int level, int band, WorkerScratch& scratch)
{
    CV_TRACE_REGION("search");
    work[level].detection.searchBand(band, scratch.detection);
    if (CV_XADD(&work[level].bandsLeft, -1) == 1)
        put(ORDER, level);
}

// Puts the corners of a level in the order in which they are chosen.
void Frame::order(int level, WorkerScratch& scratch)
{
    CV_TRACE_REGION("order");
    work[level].detection.order(work[level].plan, scratch.detection);
    selectWhenReady(level);
}

void Frame::selectWhenReady(int level)
{
    if (CV_XADD(&work[level].inputsOfSelection, -1) == 1)
        put(SELECT, level);
}

// Chooses the features of a level.
void Frame::select(int level, WorkerScratch& scratch)
{
    CV_TRACE_REGION("select");
    FeatureSelector& selector = workspace.selector;
    if (level == levelCount - 1)
    {
        selector.reset(levels.input().image.size(), levelCount, suppressionRadius(parameters),
                       isRanked ? 1 : parameters.nlevels);
    }
    selector.addLevel(level, work[level].plan);  // finer levels may not be planned yet
    take(level, scratch);
    collect(level, BY_QUOTA, scratch);
    if (level > 0)
        return selectWhenReady(level - 1);
    fillUp(scratch);
}

// Takes corners of a level in their order. Those that are not representatives are put in order if they are needed.
void Frame::take(int level, WorkerScratch& scratch)
{
    FeatureSelector& selector = workspace.selector;
    if (selector.missing() == 0)
        return;
    LevelDetection& detection = work[level].detection;
    selector.take(level, detection.ordered(work[level].plan, scratch.detection));
    if (selector.missing() > 0 && detection.orderOthers(work[level].plan, scratch.detection))
        selector.take(level, detection.ordered(work[level].plan, scratch.detection));
}

// Chooses more features if the quotas of the levels did not yield as many as are wanted: at first along the order of each
// level, from fine to coarse, then those that the rules passed over.
void Frame::fillUp(WorkerScratch& scratch)
{
    CV_TRACE_FUNCTION();
    FeatureSelector& selector = workspace.selector;
    for (int i = 0; i < levelCount; i++)
        take(i, scratch);
    for (CornerSet set : {KEPT_CORNERS, SUPPRESSED_CORNERS, WEAK_CORNERS})
    {
        for (int i = 0; i < levelCount && selector.missing() > 0; i++)
        {
            work[i].detection.list(set, scratch.detection, scratch.corners);
            selector.fill(i, scratch.corners);
        }
    }
    for (int i = 0; i < levelCount; i++)
        collect(i, FILLED, scratch);
}

FeatureList& Frame::listOf(int level, int choice)
{
    return choice == BY_QUOTA ? work[level].features.byQuota : work[level].features.filled;
}

// Lists the features of a level that have been chosen since it was listed before.
void Frame::collect(int level, Choice choice, WorkerScratch& scratch)
{
    FeatureList& list = listOf(level, choice);
    const size_t first = choice == BY_QUOTA ? 0 : listOf(level, BY_QUOTA).points.size();
    workspace.selector.chosen(level, first, scratch.corners);
    list.reset(scratch.corners.size());
    for (const CornerResponse& corner : scratch.corners)
    {
        list.points.push_back({corner.x, corner.y, 0});
        list.keypoints.push_back(
            KeyPoint(Point2f(), parameters.patchSize * levels[level].scale, -1, corner.response, level));
        list.outputKeys.push_back(isRanked ? descendingKey(sortKey(corner.response)) : 0);
    }
    putRanges(level, choice);
}

// Divides a list into ranges with enough features to be worth a task, and so many that no thread waits long for another.
void Frame::putRanges(int level, Choice choice)
{
    FeatureList& list = listOf(level, choice);
    const size_t LEAST = 64, count = list.points.size();
    if (withDescriptors)
        list.descriptors.resize(count * DESCRIPTOR_BYTES);
    const size_t most =
        threads == 1 ? size_t(INT_MAX) : std::max(size_t(parameters.nfeatures) / (4 * threads), LEAST);
    const size_t parts = (count + most - 1) / most;
    for (size_t i = 0; i < parts; i++)
        put(DESCRIBE, level, choice, Range(int(count * i / parts), int(count * (i + 1) / parts)));
}

DescriptionRules Frame::rulesOf(int level) const
{
    const Level &described = levels[level], &input = levels.input();
    const PositionMap position = {input.image.size(), described.image.size(), described.scale,
                                  parameters.edgeThreshold, parameters.subPixel};
    return {&input.mask, position, areGiven ? 0 : &tables.patch, withDescriptors ? &tables.tests : 0};
}

// Describes features of a list.
void Frame::describe(const Task& task, WorkerScratch& scratch)
{
    CV_TRACE_REGION("describe");
    describeFeatures(levels[task.level], rulesOf(task.level), task.range, listOf(task.level, task.part),
                     scratch.description);
}

void Frame::describeGiven(const std::vector<KeyPoint>& given)
{
    areGiven = true;
    takeGiven(given, parameters, levels, workspace.given);
    prepareWork(levels.size());
    for (int i = 0; i < levelCount; i++)
    {
        listGiven(workspace.given, i, listOf(i, BY_QUOTA));
        listOf(i, FILLED).reset(0);
    }
    if (levelCount > 0)
        run();
}

size_t Frame::count() const
{
    size_t sum = 0;
    for (int i = 0; i < levelCount; i++)
        sum += work[i].features.size();
    return sum;
}

void Frame::output(std::vector<KeyPoint>& keypoints, Mat& descriptors) const
{
    CV_TRACE_FUNCTION();
    keypoints.resize(count());
    size_t row = 0;
    for (int i = 0; i < levelCount; i++)
    {
        outputFeatures(work[i].features, workspace.output, keypoints.data() + row, int(row), descriptors);
        row += work[i].features.size();
    }
}

}  // namespace aqorb
}  // namespace cv
