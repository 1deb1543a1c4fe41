// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "parameters.hpp"
#include "workspace.hpp"

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

// Detects and ranks the corners of the pyramid's levels for selection.
class PyramidCorners : public CornerSource
{
public:
    PyramidCorners(const Parameters& parameters_, Thresholds thresholds_, Workspace& workspace_,
                   Pool<LevelScratch>& scratches_)
        : parameters(parameters_), thresholds(thresholds_), workspace(workspace_), scratches(scratches_)
    {
        workspace.ready.assign(workspace.pyramid.size(), uchar(0));
    }
    // Finds the corners of a level that will be asked for; several levels may be prepared at once.
    void prepare(int level)
    {
        LevelCorners& found = workspace.corners[level];
        const SelectionLevel& root = workspace.selectionLevels[level];
        const Pool<LevelScratch>::Lease lent(scratches);
        LevelScratch& scratch = *lent;
        // Harris responses of neighbours hardly differ: unsuppressed, a strong corner is taken thrice.
        findCorners(workspace.pyramid[level], root.root, thresholds, parameters.cellSize, isHarris(), found,
                    scratch.corners);
        rank(level, found.kept, scratch.ranked);
        leafPoints(scratch.ranked, root.root, root.depth, scratch.leaves, scratch.points);
        workspace.sequences[level].begin(scratch.points, root.depth);
        workspace.ready[level] = 1;
    }
    BalancedSequence& sequence(int level) CV_OVERRIDE
    {
        if (!workspace.ready[level])
            prepare(level);
        return workspace.sequences[level];
    }
    void corners(int level, CornerSet set, std::vector<RankedCorner>& ranked) CV_OVERRIDE
    {
        if (set == CELL_REJECTS)
        {
            std::vector<Corner> rejects;
            findCellRejects(workspace.pyramid[level], workspace.selectionLevels[level].root, thresholds,
                            parameters.cellSize, rejects);
            rank(level, rejects, ranked);
            return;
        }
        const LevelCorners& found = workspace.corners[level];
        rank(level, set == KEPT_CORNERS ? found.kept : found.suppressed, ranked);
    }

private:
    bool isHarris() const { return parameters.scoreType == ORB::HARRIS_SCORE; }

    void rank(int level, const std::vector<Corner>& unranked, std::vector<RankedCorner>& ranked) const
    {
        if (isHarris())
        {
            harrisResponses(workspace.pyramid[level].image, unranked, ranked);
            return;
        }
        ranked.resize(unranked.size());
        for (size_t i = 0; i < unranked.size(); i++)
        {
            const RankedCorner corner = {unranked[i].x, unranked[i].y, float(unranked[i].score)};
            ranked[i] = corner;
        }
    }

    const Parameters& parameters;
    const Thresholds thresholds;
    Workspace& workspace;
    Pool<LevelScratch>& scratches;
};

//! Whether a point, rounded, is a pixel. Points far away are not rounded: what comes of that depends on the CPU.
bool isOnPixel(const Point2f& pt, const Size& size)
{
    const float width = float(size.width), height = float(size.height);
    return pt.x > -1 && pt.y > -1 && pt.x < width && pt.y < height && Rect(Point(), size).contains(Point(pt));
}

bool hasLowerOctave(const KeyPoint& a, const KeyPoint& b)
{
    return a.octave < b.octave;
}

}  // namespace

class AdaptiveQuadtreeORBImpl CV_FINAL : public AdaptiveQuadtreeORB
{
public:
    explicit AdaptiveQuadtreeORBImpl(const Parameters& parameters) : p(parameters) { p.check(); }

    void setMaxFeatures(int value) CV_OVERRIDE { set(&Parameters::nfeatures, value); }
    int getMaxFeatures() const CV_OVERRIDE { return p.nfeatures; }
    void setScaleFactor(double value) CV_OVERRIDE { set(&Parameters::scaleFactor, value); }
    double getScaleFactor() const CV_OVERRIDE { return p.scaleFactor; }
    void setNLevels(int value) CV_OVERRIDE { set(&Parameters::nlevels, value); }
    int getNLevels() const CV_OVERRIDE { return p.nlevels; }
    void setEdgeThreshold(int value) CV_OVERRIDE { set(&Parameters::edgeThreshold, value); }
    int getEdgeThreshold() const CV_OVERRIDE { return p.edgeThreshold; }
    void setFirstLevel(int value) CV_OVERRIDE { set(&Parameters::firstLevel, value); }
    int getFirstLevel() const CV_OVERRIDE { return p.firstLevel; }
    void setWTA_K(int value) CV_OVERRIDE { set(&Parameters::WTA_K, value); }
    int getWTA_K() const CV_OVERRIDE { return p.WTA_K; }
    void setScoreType(ORB::ScoreType value) CV_OVERRIDE { set(&Parameters::scoreType, numberOf(value)); }
    ORB::ScoreType getScoreType() const CV_OVERRIDE { return ORB::ScoreType(p.scoreType); }
    void setPatchSize(int value) CV_OVERRIDE { set(&Parameters::patchSize, value); }
    int getPatchSize() const CV_OVERRIDE { return p.patchSize; }
    void setFastThreshold(int value) CV_OVERRIDE { set(&Parameters::fastThreshold, value); }
    int getFastThreshold() const CV_OVERRIDE { return p.fastThreshold; }

    void setAdaptiveThreshold(bool value) CV_OVERRIDE { set(&Parameters::adaptiveThreshold, value); }
    bool getAdaptiveThreshold() const CV_OVERRIDE { return p.adaptiveThreshold; }
    void setMinThresholdRatio(double value) CV_OVERRIDE { set(&Parameters::minThresholdRatio, value); }
    double getMinThresholdRatio() const CV_OVERRIDE { return p.minThresholdRatio; }
    void setCellSize(int value) CV_OVERRIDE { set(&Parameters::cellSize, value); }
    int getCellSize() const CV_OVERRIDE { return p.cellSize; }
    void setMaxDepth(int value) CV_OVERRIDE { set(&Parameters::maxDepth, value); }
    int getMaxDepth() const CV_OVERRIDE { return p.maxDepth; }
    void setOctaveSuppression(double value) CV_OVERRIDE { set(&Parameters::octaveSuppression, value); }
    double getOctaveSuppression() const CV_OVERRIDE { return p.octaveSuppression; }
    void setSubPixel(bool value) CV_OVERRIDE { set(&Parameters::subPixel, value); }
    bool getSubPixel() const CV_OVERRIDE { return p.subPixel; }

    int descriptorSize() const CV_OVERRIDE { return kBytes; }
    int descriptorType() const CV_OVERRIDE { return CV_8U; }
    int defaultNorm() const CV_OVERRIDE { return p.WTA_K == 2 ? NORM_HAMMING : NORM_HAMMING2; }
    bool empty() const CV_OVERRIDE { return false; }

    using Feature2D::read;
    using Feature2D::write;
    void write(FileStorage& fs) const CV_OVERRIDE
    {
        writeFormat(fs);
        fs << "name" << getDefaultName();
        p.write(fs);
    }
    void read(const FileNode& node) CV_OVERRIDE { p.read(node); }

    void buildPyramid(InputArray image, OutputArrayOfArrays levels) const CV_OVERRIDE;

    void detectAndCompute(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                          OutputArray descriptors, bool useProvidedKeypoints) CV_OVERRIDE;

private:
    template <typename T> void set(T Parameters::*field, T value)
    {
        Parameters changed = p;
        changed.*field = value;
        changed.check();
        p = changed;
    }

    void find(const Mat& image, const Mat& mask, Workspace& workspace) const;
    void locate(const Mat& image, const std::vector<KeyPoint>& provided, Workspace& workspace) const;
    Rect regionOf(Size level) const
    {
        const int border = p.edgeThreshold;
        return Rect(border, border, level.width - 2 * border, level.height - 2 * border);
    }
    void refine(const std::vector<RankedCorner>& corners, const Level& level, int octave,
                const PositionMap& position, const Mat& mask, LevelFeatures& features) const;

    Parameters p;
    Pool<Workspace> workspaces;
    mutable Pool<LevelScratch> scratches;
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

void AdaptiveQuadtreeORBImpl::buildPyramid(InputArray image_, OutputArrayOfArrays levels) const
{
    CV_TRACE_FUNCTION();
    std::vector<Level> pyramid;
    if (!image_.empty())
    {
        p.checkTogether(p.nlevels);
        stages::buildPyramid(grayImage(image_), Mat(), p.nlevels, p.firstLevel, p.scaleFactor, 1, pyramid);
    }
    levels.create(int(pyramid.size()), 1, CV_8UC1);
    for (int i = 0; i < int(pyramid.size()); i++)
        levels.getMatRef(i) = pyramid[i].isInput ? pyramid[i].image.clone() : pyramid[i].image;
}

void AdaptiveQuadtreeORBImpl::detectAndCompute(InputArray image_, InputArray mask_,
                                               std::vector<KeyPoint>& keypoints, OutputArray descriptors_,
                                               bool useProvidedKeypoints)
{
    CV_TRACE_FUNCTION();
    const bool withDescriptors = descriptors_.needed();
    if (useProvidedKeypoints && !withDescriptors)
        return;  // as cv::ORB
    if (image_.empty())
    {
        keypoints.clear();
        if (withDescriptors)
            descriptors_.release();
        return;
    }

    const Mat image = grayImage(image_);
    const Pool<Workspace>::Lease lease(workspaces);
    Workspace& workspace = *lease;
    if (useProvidedKeypoints)
        locate(image, keypoints, workspace);
    else
        find(image, checkedMask(mask_, image.size()), workspace);

    const int levels = int(workspace.pyramid.size());
    std::vector<size_t> firsts(levels + 1, 0);  // of each level's features among all
    for (int i = 0; i < levels; i++)
        firsts[i + 1] = firsts[i] + workspace.features[i].points.size();
    Mat descriptors;
    if (withDescriptors && firsts[levels] > 0)
    {
        descriptors_.create(int(firsts[levels]), kBytes, CV_8UC1);
        descriptors = descriptors_.getMat();
        const std::vector<Point> pattern = descriptorPattern(p.patchSize, p.WTA_K);
        const int reach = descriptorReach(pattern);
        parallel_for_(
            Range(0, levels),
            [&](const Range& range)
            {
                for (int i = range.start; i < range.end; i++)
                {
                    const Mat& level = workspace.pyramid[i].image;
                    const std::vector<DescriptorPoint>& points = workspace.features[i].points;
                    if (points.empty())
                        continue;
                    const Pool<LevelScratch>::Lease lent(scratches);
                    LevelScratch& scratch = *lent;
                    scratch.blurRegion.begin(level.size());
                    for (size_t j = 0; j < points.size(); j++)
                        scratch.blurRegion.add(
                            Rect(points[j].x - reach, points[j].y - reach, 2 * reach + 1, 2 * reach + 1));
                    if (scratch.blurred.size() < level.total())
                        scratch.blurred.resize(level.total());
                    Mat blurred(level.size(), CV_16UC1, scratch.blurred.data());
                    approximateBlur(level, scratch.blurRegion, blurred, scratch.blur);
                    computeDescriptors(level, blurred, points.data(), points.size(), pattern, p.WTA_K,
                                       descriptors.ptr(int(firsts[i])), descriptors.step);
                }
            },
            levels);
    }
    else if (withDescriptors)
    {
        descriptors_.release();
    }
    keypoints.resize(firsts[levels]);
    for (int i = 0; i < levels; i++)
    {
        const std::vector<KeyPoint>& found = workspace.features[i].keypoints;
        std::copy(found.begin(), found.end(), keypoints.begin() + firsts[i]);
    }
}

// Finds the features of an image.
void AdaptiveQuadtreeORBImpl::find(const Mat& image, const Mat& mask, Workspace& workspace) const
{
    p.checkTogether(p.nlevels);
    const Thresholds thresholds =
        p.adaptiveThreshold
            ? adaptiveThresholds(varianceOverMean(image, mask), p.fastThreshold, p.minThresholdRatio)
            : fixedThresholds(p.fastThreshold, p.minThresholdRatio);

    const int FAST_RADIUS = 3;
    const int minSide = int(std::min(2 * std::max<int64>(p.edgeThreshold, FAST_RADIUS) + 1, int64(INT_MAX)));
    std::vector<Level>& pyramid = workspace.pyramid;
    stages::buildPyramid(image, mask, p.nlevels, p.firstLevel, p.scaleFactor, minSide, pyramid);
    const int levels = int(pyramid.size());
    workspace.resize(levels);

    PyramidCorners source(p, thresholds, workspace, scratches);
    const std::vector<int> quotas = levelQuotas(p.nfeatures, p.scaleFactor, p.nlevels);
    std::vector<PositionMap> positions(levels);
    std::vector<SelectionLevel>& selectionLevels = workspace.selectionLevels;
    selectionLevels.resize(levels);
    for (int i = 0; i < levels; i++)
    {
        const PositionMap position = {image.size(), pyramid[i].image.size(), pyramid[i].scale,
                                      p.edgeThreshold, p.subPixel};
        positions[i] = position;
        if (!mask.empty() && !pyramid[i].isInput)
            maskPositions(mask, position, pyramid[i].mask);
        const SelectionLevel level = {pyramid[i].image.size(), pyramid[i].scale,
                                      regionOf(pyramid[i].image.size()),
                                      p.maxDepth >= 0 ? p.maxDepth : quadtreeDepth(quotas[i]), quotas[i]};
        selectionLevels[i] = level;
    }
    // Levels too small for a keypoint leave their quota to the next finer one.
    if (levels > 0)
        selectionLevels.back().quota = std::accumulate(quotas.begin() + levels - 1, quotas.end(), 0);
    parallel_for_(
        Range(0, levels),
        [&](const Range& range)
        {
            for (int i = range.start; i < range.end; i++)
            {
                if (selectionLevels[i].quota > 0)
                    source.prepare(i);
            }
        },
        levels);

    workspace.selector.select(selectionLevels, image.size(), p.octaveSuppression, source, workspace.chosen);

    parallel_for_(
        Range(0, levels),
        [&](const Range& range)
        {
            for (int i = range.start; i < range.end; i++)
            {
                std::sort(workspace.chosen[i].begin(), workspace.chosen[i].end(), inRasterOrder);
                refine(workspace.chosen[i], pyramid[i], i, positions[i], mask, workspace.features[i]);
            }
        },
        levels);
}

// The features at the corners of a level: their direction and their position in the image.
void AdaptiveQuadtreeORBImpl::refine(const std::vector<RankedCorner>& corners, const Level& level, int octave,
                                     const PositionMap& position, const Mat& mask,
                                     LevelFeatures& features) const
{
    features.keypoints.resize(corners.size());
    features.points.resize(corners.size());
    if (corners.empty())
        return;
    for (size_t i = 0; i < corners.size(); i++)
    {
        features.points[i].x = corners[i].x;
        features.points[i].y = corners[i].y;
    }
    orientations(level.image, circularPatch(p.patchSize), features.points.data(), features.points.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        const DescriptorPoint& point = features.points[i];
        Point2f pt = position(point.x, point.y);
        if (p.subPixel)
        {
            const Point2d offset = subPixelOffset(level.image, point.x, point.y);
            const Point2f refined = position(point.x, point.y, offset.x, offset.y);
            if (mask.empty() || mask.at<uchar>(cvRound(refined.y), cvRound(refined.x)))
                pt = refined;
        }
        features.keypoints[i] =
            KeyPoint(pt, p.patchSize * level.scale, point.angle, corners[i].response, octave);
    }
}

// What compute does with given keypoints, as cv::ORB: drops those near the border, orders the others
// by level and finds their pixels.
void AdaptiveQuadtreeORBImpl::locate(const Mat& image, const std::vector<KeyPoint>& provided,
                                     Workspace& workspace) const
{
    int maxOctave = 0;
    for (size_t i = 0; i < provided.size(); i++)
    {
        const int octave = provided[i].octave;
        if (octave < 0)
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints: got octave %d; >= 0 is accepted (SIFT packs more than the "
                       "octave into the field: unpack it first)",
                       octave));
        maxOctave = std::max(maxOctave, octave);
    }
    p.checkTogether(std::max(p.nlevels, maxOctave > 0 ? 2 : 1));
    const Size smallest = levelSize(image.size(), levelScale(maxOctave, p.firstLevel, p.scaleFactor));
    if (smallest.width < 1 || smallest.height < 1)
        CV_Error_(Error::StsOutOfRange,
                  ("keypoints: got octave %d, whose level would have no pixels; an octave of a "
                   "level of at least 1 x 1 pixels is accepted (SIFT packs more than the octave "
                   "into the field: unpack it first)",
                   maxOctave));

    std::vector<KeyPoint> inside;
    for (size_t i = 0; i < provided.size(); i++)
    {
        if (isOnPixel(provided[i].pt, image.size()))
            inside.push_back(provided[i]);
    }
    const int border = std::min(p.edgeThreshold, std::max(image.cols, image.rows));
    KeyPointsFilter::runByImageBorder(inside, image.size(), border);
    std::stable_sort(inside.begin(), inside.end(), hasLowerOctave);
    const int levels = inside.empty() ? 0 : inside.back().octave + 1;
    stages::buildPyramid(image, Mat(), levels, p.firstLevel, p.scaleFactor, 1, workspace.pyramid);
    workspace.resize(levels);
    for (int i = 0; i < levels; i++)
    {
        workspace.features[i].keypoints.clear();
        workspace.features[i].points.clear();
    }
    for (size_t i = 0; i < inside.size(); i++)
    {
        const KeyPoint& keypoint = inside[i];
        const float inverseScale = 1.f / workspace.pyramid[keypoint.octave].scale;
        const DescriptorPoint point = {cvRound(keypoint.pt.x * inverseScale),
                                       cvRound(keypoint.pt.y * inverseScale), keypoint.angle};
        workspace.features[keypoint.octave].keypoints.push_back(keypoint);
        workspace.features[keypoint.octave].points.push_back(point);
    }
}

}  // namespace aqorb
}  // namespace cv
