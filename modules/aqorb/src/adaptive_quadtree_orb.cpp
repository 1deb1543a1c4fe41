// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "descriptor.hpp"
#include "input.hpp"
#include "orientation.hpp"
#include "parameters.hpp"
#include "pool.hpp"
#include "position.hpp"
#include "threshold.hpp"
#include "workspace.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

using namespace stages;

String AdaptiveQuadtreeORB::getDefaultName() const
{
    return Feature2D::getDefaultName() + ".AdaptiveQuadtreeORB";
}

namespace
{

// What follows from the parameters alone.
struct Tables
{
    explicit Tables(const Parameters& parameters)
        : patch(circularPatch(parameters.patchSize)),
          strengthPatch(patch.halfWidths, std::max(1, parameters.patchSize / 2 / 3)),
          tests(descriptorPattern(parameters.patchSize, parameters.WTA_K), parameters.WTA_K)
    {
        // Other values have no quotas. Detection throws for them.
        if (parameters.nlevels == 1 || parameters.scaleFactor > 1)
            quotas = levelQuotas(parameters.nfeatures, parameters.scaleFactor, parameters.nlevels);
    }
    OrientationPatch patch;
    OrientationPatch strengthPatch;  // the same with fewer rows
    DescriptorTests tests;
    std::vector<int> quotas;  // by level, of BALANCED_SELECTION
};

// Calls body(0) .. body(count - 1), several at once.
template <typename Body> void inParallel(size_t count, const Body& body)
{
    // The function captures one pointer only, because std::function would allocate memory for more.
    parallel_for_(
        Range(0, int(count)),
        [&body](const Range& range)
        {
            for (int i = range.start; i < range.end; i++)
                body(size_t(i));
        },
        double(count));
}

}  // namespace

class AdaptiveQuadtreeORBImpl CV_FINAL : public AdaptiveQuadtreeORB
{
public:
    explicit AdaptiveQuadtreeORBImpl(const Parameters& parameters_)
        : parameters(checked(parameters_)), tables(parameters)
    {
    }

    void setMaxFeatures(int value) CV_OVERRIDE { set(&Parameters::nfeatures, value); }
    int getMaxFeatures() const CV_OVERRIDE { return parameters.nfeatures; }
    void setScaleFactor(double value) CV_OVERRIDE { set(&Parameters::scaleFactor, value); }
    double getScaleFactor() const CV_OVERRIDE { return parameters.scaleFactor; }
    void setNLevels(int value) CV_OVERRIDE { set(&Parameters::nlevels, value); }
    int getNLevels() const CV_OVERRIDE { return parameters.nlevels; }
    void setEdgeThreshold(int value) CV_OVERRIDE { set(&Parameters::edgeThreshold, value); }
    int getEdgeThreshold() const CV_OVERRIDE { return parameters.edgeThreshold; }
    void setFirstLevel(int value) CV_OVERRIDE { set(&Parameters::firstLevel, value); }
    int getFirstLevel() const CV_OVERRIDE { return parameters.firstLevel; }
    void setWTA_K(int value) CV_OVERRIDE { set(&Parameters::WTA_K, value); }
    int getWTA_K() const CV_OVERRIDE { return parameters.WTA_K; }
    void setScoreType(ORB::ScoreType value) CV_OVERRIDE { set(&Parameters::scoreType, numberOf(value)); }
    ORB::ScoreType getScoreType() const CV_OVERRIDE { return ORB::ScoreType(parameters.scoreType); }
    void setPatchSize(int value) CV_OVERRIDE { set(&Parameters::patchSize, value); }
    int getPatchSize() const CV_OVERRIDE { return parameters.patchSize; }
    void setFastThreshold(int value) CV_OVERRIDE { set(&Parameters::fastThreshold, value); }
    int getFastThreshold() const CV_OVERRIDE { return parameters.fastThreshold; }

    void setAdaptiveThreshold(bool value) CV_OVERRIDE { set(&Parameters::adaptiveThreshold, value); }
    bool getAdaptiveThreshold() const CV_OVERRIDE { return parameters.adaptiveThreshold; }
    void setMinThresholdRatio(double value) CV_OVERRIDE { set(&Parameters::minThresholdRatio, value); }
    double getMinThresholdRatio() const CV_OVERRIDE { return parameters.minThresholdRatio; }
    void setCellSize(int value) CV_OVERRIDE { set(&Parameters::cellSize, value); }
    int getCellSize() const CV_OVERRIDE { return parameters.cellSize; }
    void setMaxDepth(int value) CV_OVERRIDE { set(&Parameters::maxDepth, value); }
    int getMaxDepth() const CV_OVERRIDE { return parameters.maxDepth; }
    void setSelectionType(SelectionType value) CV_OVERRIDE
    {
        set(&Parameters::selectionType, numberOf(value));
    }
    SelectionType getSelectionType() const CV_OVERRIDE { return SelectionType(parameters.selectionType); }
    void setStrengthWeight(double value) CV_OVERRIDE { set(&Parameters::strengthWeight, value); }
    double getStrengthWeight() const CV_OVERRIDE { return parameters.strengthWeight; }
    void setRankRadius(double value) CV_OVERRIDE { set(&Parameters::rankRadius, value); }
    double getRankRadius() const CV_OVERRIDE { return parameters.rankRadius; }
    void setOctaveSuppression(double value) CV_OVERRIDE { set(&Parameters::octaveSuppression, value); }
    double getOctaveSuppression() const CV_OVERRIDE { return parameters.octaveSuppression; }
    void setSubPixel(bool value) CV_OVERRIDE { set(&Parameters::subPixel, value); }
    bool getSubPixel() const CV_OVERRIDE { return parameters.subPixel; }

    int descriptorSize() const CV_OVERRIDE { return kBytes; }
    int descriptorType() const CV_OVERRIDE { return CV_8U; }
    int defaultNorm() const CV_OVERRIDE { return parameters.WTA_K == 2 ? NORM_HAMMING : NORM_HAMMING2; }
    bool empty() const CV_OVERRIDE { return false; }

    using Feature2D::read;
    using Feature2D::write;
    void write(FileStorage& fs) const CV_OVERRIDE
    {
        writeFormat(fs);
        fs << "name" << getDefaultName();
        parameters.write(fs);
    }
    void read(const FileNode& node) CV_OVERRIDE
    {
        Parameters changed = parameters;
        changed.read(node);
        use(changed);
    }

    void buildPyramid(InputArray image, OutputArrayOfArrays levels) const CV_OVERRIDE;

    void detectAndCompute(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                          OutputArray descriptors, bool useProvidedKeypoints) CV_OVERRIDE;

private:
    static const Parameters& checked(const Parameters& unchecked)
    {
        unchecked.check();
        return unchecked;
    }
    template <typename T> void set(T Parameters::*field, T value)
    {
        Parameters changed = parameters;
        changed.*field = value;
        use(checked(changed));
    }
    void use(const Parameters& changed)
    {
        Tables ofChanged(changed);
        parameters = changed;
        std::swap(tables, ofChanged);
    }

    // The steps of a call, in this order. If keypoints are given, takeKeypoints replaces the first two.
    void detectCorners(Workspace& workspace) const;
    void selectFeatures(Workspace& workspace) const;
    void takeKeypoints(const std::vector<KeyPoint>& given, Workspace& workspace) const;
    void computeKeypoints(Workspace& workspace, const FeatureRange& range) const;
    void describe(Workspace& workspace, const FeatureRange& range, Mat& descriptors) const;

    PositionMap positionsOf(const Level& level, Size imageSize) const
    {
        const PositionMap map = {imageSize, level.image.size(), level.scale, parameters.edgeThreshold,
                                 parameters.subPixel};
        return map;
    }

    Parameters parameters;
    Tables tables;
    Pool<Workspace> workspaces;
    mutable Pool<DetectionScratch> detectionScratches;
    mutable Pool<DescriptionScratch> descriptionScratches;
};

Ptr<AdaptiveQuadtreeORB> AdaptiveQuadtreeORB::create(int nfeatures, float scaleFactor, int nlevels,
                                                     int edgeThreshold, int firstLevel, int WTA_K,
                                                     ORB::ScoreType scoreType, int patchSize,
                                                     int fastThreshold)
{
    Parameters parameters;
    parameters.nfeatures = nfeatures;
    parameters.scaleFactor = scaleFactor;
    parameters.nlevels = nlevels;
    parameters.edgeThreshold = edgeThreshold;
    parameters.firstLevel = firstLevel;
    parameters.WTA_K = WTA_K;
    parameters.scoreType = numberOf(scoreType);
    parameters.patchSize = patchSize;
    parameters.fastThreshold = fastThreshold;
    return makePtr<AdaptiveQuadtreeORBImpl>(parameters);
}

void AdaptiveQuadtreeORBImpl::buildPyramid(InputArray image_, OutputArrayOfArrays levels_) const
{
    CV_TRACE_FUNCTION();
    checkLevelsOutput(levels_);
    const UMat held = heldUMat(image_);
    Workspace workspace;  // not from the pool, as its images become the caller's
    if (!image_.empty())
    {
        parameters.checkTogether(parameters.nlevels);
        workspace.input.image = grayImage(image_);
        checkPyramidInput(workspace.input.image.size());
        workspace.layOutLevels(parameters.nlevels, parameters.firstLevel, parameters.scaleFactor, 1);
        workspace.fillLevels(parameters.firstLevel);
        // The caller's pixels may lie in the memory of a level that is given up below.
        if (parameters.firstLevel < workspace.levelCount)
        {
            Mat& first = workspace.levels[parameters.firstLevel].level.image;
            first = first.clone();
        }
    }
    createLevels(levels_, workspace.levelCount);
    for (int i = 0; i < workspace.levelCount; i++)
    {
        const Level& level = workspace.levels[i].level;
        if (levels_.isUMatVector())
        {
            // A new UMat, because the caller may share the old one.
            UMat copy;
            level.image.copyTo(copy);
            levels_.getUMatRef(i) = copy;
        }
        else
        {
            levels_.getMatRef(i) = level.image;
        }
    }
}

void AdaptiveQuadtreeORBImpl::detectAndCompute(InputArray image_, InputArray mask_,
                                               std::vector<KeyPoint>& keypoints, OutputArray descriptors_,
                                               bool useProvidedKeypoints)
{
    CV_TRACE_FUNCTION();
    const bool withDescriptors = descriptors_.needed();
    if (useProvidedKeypoints && !withDescriptors)
        return;  // as cv::ORB
    if (withDescriptors)
        checkDescriptorsOutput(descriptors_);
    if (image_.empty())
    {
        if (withDescriptors)
            releaseDescriptors(descriptors_);
        keypoints.clear();
        return;
    }

    const UMat heldImage = heldUMat(image_), heldMask = heldUMat(mask_);
    // The image may lie in memory that the output gives up for a larger one.
    const Mat heldDescriptors = descriptors_.isMat() ? descriptors_.getMat() : Mat();
    const UMat heldUDescriptors = heldUMat(descriptors_);
    Level input;
    input.image = grayImage(image_);
    if (descriptors_.isVector())
        input.image = input.image.clone();
    checkPyramidInput(input.image.size());
    if (!useProvidedKeypoints)
        input.mask = checkedMask(mask_, input.image.size());
    const Pool<Workspace>::Lease lease(workspaces);
    Workspace& workspace = *lease;
    const InputScope scope(workspace, input);
    if (useProvidedKeypoints)
    {
        takeKeypoints(keypoints, workspace);
    }
    else
    {
        detectCorners(workspace);
        selectFeatures(workspace);
    }

    const size_t count = workspace.keypoints.size();
    Mat output, descriptors;
    if (withDescriptors && count > 0)
    {
        output = createDescriptors(descriptors_, int(count));
        // Where the output lies in the image or the mask, it must not be written before both have been read.
        const bool isRead = shareMemory(output, input.image) || shareMemory(output, input.mask);
        descriptors = isRead ? Mat(output.size(), output.type()) : output;
    }
    else if (withDescriptors)
    {
        releaseDescriptors(descriptors_);
    }
    workspace.layOutRanges();
    inParallel(workspace.ranges.size(),
               [&](size_t i)
               {
                   CV_TRACE_REGION("range of features");
                   if (!useProvidedKeypoints)
                       computeKeypoints(workspace, workspace.ranges[i]);
                   if (!descriptors.empty())
                       describe(workspace, workspace.ranges[i], descriptors);
               });
    if (descriptors.data != output.data)
        descriptors.copyTo(output);
    keypoints = workspace.keypoints;
}

// Finds and ranks the corners of all levels.
void AdaptiveQuadtreeORBImpl::detectCorners(Workspace& workspace) const
{
    const Mat &image = workspace.input.image, &mask = workspace.input.mask;
    parameters.checkTogether(parameters.nlevels);
    DetectionRules rules;
    rules.thresholds = parameters.adaptiveThreshold
                           ? adaptiveThresholds(varianceOverMean(image, mask), parameters.fastThreshold,
                                                parameters.minThresholdRatio)
                           : fixedThresholds(parameters.fastThreshold, parameters.minThresholdRatio);
    rules.cellSize = parameters.cellSize;
    rules.rankByHarris = parameters.scoreType == ORB::HARRIS_SCORE;
    const bool isRanked = parameters.selectionType == RANKED_SELECTION;
    rules.strengthPatch = isRanked ? &tables.strengthPatch : 0;

    const int FAST_RADIUS = 3, border = parameters.edgeThreshold;
    const int minSide = int(std::min(2 * std::max<int64>(border, FAST_RADIUS) + 1, int64(INT_MAX)));
    workspace.layOutLevels(parameters.nlevels, parameters.firstLevel, parameters.scaleFactor, minSide);
    const int count = workspace.levelCount;
    std::vector<LevelWork>& levels = workspace.levels;
    const std::vector<int> quotas = isRanked
                                        ? areaQuotas(parameters.nfeatures, parameters.scaleFactor, count)
                                        : tables.quotas;
    for (int i = 0; i < count; i++)
    {
        // Levels too small for a keypoint leave their quotas to the next finer one.
        const int quota = quotas[i], added = i < count - 1 ? 0
                                                           : std::accumulate(quotas.begin() + count,
                                                                             quotas.end(), 0);
        SelectionLevel& selection = levels[i].selection;
        selection.size = levels[i].level.image.size();
        selection.scale = levels[i].level.scale;
        selection.quota = quota + added;
        OrderRule& order = selection.order;
        order.root = Rect(border, border, selection.size.width - 2 * border, selection.size.height - 2 * border);
        order.depth = parameters.maxDepth >= 0 ? parameters.maxDepth : quadtreeDepth(quota);
        order.isRanked = isRanked;
        levels[i].detection.begin(levels[i].level, order.root, rules);
    }

    const size_t bandsOfInput = workspace.layOutBands(), bands = workspace.bands.size();
    const auto search = [&](size_t i)
    {
        const Pool<DetectionScratch>::Lease scratch(detectionScratches);
        const LevelBand& band = workspace.bands[i];
        levels[band.level].detection.searchBand(band.band, *scratch);
    };
    // The image itself is searched while the other levels are made from it.
    inParallel(1 + bandsOfInput,
               [&](size_t i)
               {
                   if (i > 0)
                       return search(i - 1);
                   workspace.fillLevels(parameters.firstLevel);
                   for (int j = 0; j < count && !mask.empty(); j++)
                   {
                       Level& level = levels[j].level;
                       if (!level.isInput)
                           maskPositions(mask, positionsOf(level, image.size()), level.mask);
                   }
               });
    for (int i = 0; i < count && isRanked; i++)
    {
        OrderRule& order = levels[i].selection.order;
        const Mat& levelMask = levels[i].level.mask;
        const Size size = order.root.size();
        const double usable =
            levelMask.empty() ? 1 : countNonZero(levelMask(order.root)) / (double(size.width) * size.height);
        const RankRule rule = {size, usable, std::max(levels[i].selection.quota, 1), parameters.rankRadius,
                               parameters.strengthWeight};
        order.rank = rule;
        order.depth = parameters.maxDepth >= 0 ? std::min(parameters.maxDepth, maxRankedDepth(size))
                                               : rankedDepth(size, usable, rule.quota);
    }
    // The corners of the image, which has most of them, are ranked while the other levels are searched.
    inParallel(bands,
               [&](size_t i)
               {
                   const LevelBand& band = workspace.bands[i];
                   if (i < bandsOfInput)
                       levels[band.level].detection.rankBand(band.band);
                   else
                       search(i);
               });
    inParallel(size_t(count),
               [&](size_t i)
               {
                   if (levels[i].selection.quota == 0)
                       return;
                   const Pool<DetectionScratch>::Lease scratch(detectionScratches);
                   levels[i].detection.order(levels[i].selection.order, *scratch);
               });
}

// Chooses the corners that become features, and gives selection what it asks for.
void AdaptiveQuadtreeORBImpl::selectFeatures(Workspace& workspace) const
{
    CV_TRACE_FUNCTION();
    FeatureSelector& selector = workspace.selector;
    selector.begin(workspace.input.image.size(), parameters.octaveSuppressionInUse(),
                   parameters.selectionType == RANKED_SELECTION ? 1 : parameters.nlevels);
    for (int i = 0; i < workspace.levelCount; i++)
        selector.addLevel(workspace.levels[i].selection);

    const Pool<DetectionScratch>::Lease scratch(detectionScratches);
    CornerRequest request;
    while (selector.wants(request))
    {
        LevelWork& work = workspace.levels[request.level];
        LevelDetection& detection = work.detection;
        if (request.set == SEQUENCE_CORNERS)
        {
            PointSequence& sequence = detection.sequence(work.selection.order, *scratch);
            selector.offer(sequence, detection.corners());
        }
        else
        {
            detection.list(request.set, workspace.corners);
            selector.offer(workspace.corners);
        }
    }

    size_t count = 0;
    for (int i = 0; i < workspace.levelCount; i++)
    {
        LevelWork& work = workspace.levels[i];
        selector.chosen(i, work.chosen);
        work.points.resize(work.chosen.size());
        for (size_t j = 0; j < work.chosen.size(); j++)
        {
            work.points[j].x = work.chosen[j].x;
            work.points[j].y = work.chosen[j].y;
        }
        work.first = count;
        count += work.chosen.size();
    }
    workspace.keypoints.resize(count);
}

// Takes given keypoints as cv::ORB::compute does: drops those near the border, orders the others by level and finds
// their pixels.
void AdaptiveQuadtreeORBImpl::takeKeypoints(const std::vector<KeyPoint>& given, Workspace& workspace) const
{
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

    std::vector<KeyPoint> inside = describableKeypoints(given, imageSize, parameters.edgeThreshold);
    const int levels = inside.empty() ? 0 : inside.back().octave + 1;
    workspace.layOutLevels(levels, parameters.firstLevel, parameters.scaleFactor, 1);
    workspace.fillLevels(parameters.firstLevel);
    for (int i = 0; i < levels; i++)
        workspace.levels[i].points.clear();
    for (size_t i = 0; i < inside.size(); i++)
    {
        const KeyPoint& keypoint = inside[i];
        LevelWork& work = workspace.levels[keypoint.octave];
        const float inverseScale = 1.f / work.level.scale;
        const FeaturePoint point = {cvRound(keypoint.pt.x * inverseScale),
                                    cvRound(keypoint.pt.y * inverseScale), keypoint.angle};
        if (work.points.empty())
            work.first = i;
        work.points.push_back(point);
    }
    workspace.keypoints.swap(inside);
}

// Makes keypoints of the chosen corners of a range: computes their directions and their positions in the image.
void AdaptiveQuadtreeORBImpl::computeKeypoints(Workspace& workspace, const FeatureRange& range) const
{
    CV_TRACE_FUNCTION();
    LevelWork& work = workspace.levels[range.level];
    const Mat &image = work.level.image, &mask = workspace.input.mask;
    orientations(image, tables.patch, work.points.data() + range.begin, range.end - range.begin);
    const PositionMap position = positionsOf(work.level, workspace.input.image.size());
    for (size_t i = range.begin; i < range.end; i++)
    {
        const FeaturePoint& point = work.points[i];
        const Point2d offset = parameters.subPixel ? subPixelOffset(image, point.x, point.y) : Point2d();
        Point2f pt = position(point.x, point.y, offset.x, offset.y);
        if (parameters.subPixel && !mask.empty() && !isUsable(mask, pt))
            usablePosition(mask, position, point.x, point.y, pt);
        workspace.keypoints[work.first + i] = KeyPoint(pt, parameters.patchSize * work.level.scale,
                                                       point.angle, work.chosen[i].response, range.level);
    }
}

// Computes the descriptors of the features of a range.
void AdaptiveQuadtreeORBImpl::describe(Workspace& workspace, const FeatureRange& range,
                                       Mat& descriptors) const
{
    const LevelWork& work = workspace.levels[range.level];
    const Mat& level = work.level.image;
    const Pool<DescriptionScratch>::Lease lease(descriptionScratches);
    DescriptionScratch& scratch = *lease;
    const int reach = tables.tests.reach, side = 2 * reach + 1;
    scratch.blurRegion.begin(level.size());
    for (size_t i = range.begin; i < range.end; i++)
        scratch.blurRegion.add(Rect(work.points[i].x - reach, work.points[i].y - reach, side, side));
    if (scratch.blurred.size() < level.total())
        scratch.blurred.resize(level.total());
    Mat blurred(level.size(), CV_16UC1, scratch.blurred.data());
    approximateBlur(level, scratch.blurRegion, blurred, scratch.blur);
    computeDescriptors(level, blurred, work.points.data() + range.begin, range.end - range.begin,
                       tables.tests, descriptors.ptr(int(work.first + range.begin)), descriptors.step);
}

}  // namespace aqorb
}  // namespace cv
