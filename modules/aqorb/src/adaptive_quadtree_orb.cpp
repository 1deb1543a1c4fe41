// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "parameters.hpp"
#include "pyramid_corners.hpp"
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

// What follows from the parameters alone.
struct Tables
{
    explicit Tables(const Parameters& p)
        : patch(circularPatch(p.patchSize)), tests(descriptorPattern(p.patchSize, p.WTA_K), p.WTA_K)
    {
        if (p.nlevels == 1 || p.scaleFactor > 1)  // else detection is refused
            quotas = levelQuotas(p.nfeatures, p.scaleFactor, p.nlevels);
    }
    OrientationPatch patch;
    DescriptorTests tests;
    std::vector<int> quotas;  // by level
};

// Calls body(0) .. body(count - 1), several at once.
template <typename Body> void inParallel(size_t count, const Body& body)
{
    parallel_for_(
        Range(0, int(count)),
        [&body](const Range& range)  // no more than a pointer, or a copy would be allocated
        {
            for (int i = range.start; i < range.end; i++)
                body(size_t(i));
        },
        double(count));
}

// By counting: the rows are many, and have few corners each.
void sortInRasterOrder(std::vector<RankedCorner>& corners, int rows, std::vector<size_t>& starts,
                       std::vector<RankedCorner>& sorted)
{
    starts.assign(size_t(rows) + 1, 0);
    for (size_t i = 0; i < corners.size(); i++)
        starts[corners[i].y + 1]++;
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    sorted.resize(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
        sorted[starts[corners[i].y]++] = corners[i];
    size_t begin = 0;
    for (int y = 0; y < rows; begin = starts[y++])  // now the end of row y
    {
        if (starts[y] - begin > 1)
            std::sort(sorted.begin() + begin, sorted.begin() + starts[y], InRasterOrder());
    }
    corners.swap(sorted);
}

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
    explicit AdaptiveQuadtreeORBImpl(const Parameters& parameters) : p(checked(parameters)), tables(p) {}

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
    void read(const FileNode& node) CV_OVERRIDE
    {
        Parameters changed = p;
        changed.read(node);
        use(changed);
    }

    void buildPyramid(InputArray image, OutputArrayOfArrays levels) const CV_OVERRIDE;

    void detectAndCompute(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                          OutputArray descriptors, bool useProvidedKeypoints) CV_OVERRIDE;

private:
    static const Parameters& checked(const Parameters& parameters)
    {
        parameters.check();
        return parameters;
    }
    template <typename T> void set(T Parameters::*field, T value)
    {
        Parameters changed = p;
        changed.*field = value;
        use(checked(changed));
    }
    void use(const Parameters& changed)
    {
        Tables ofChanged(changed);
        p = changed;
        std::swap(tables, ofChanged);
    }

    void chooseCorners(const Mat& image, const Mat& mask, Workspace& workspace) const;
    void locate(const Mat& image, const std::vector<KeyPoint>& provided, Workspace& workspace) const;
    Rect regionOf(Size level) const
    {
        const int border = p.edgeThreshold;
        return Rect(border, border, level.width - 2 * border, level.height - 2 * border);
    }
    PositionMap positionsOf(const Level& level, Size imageSize) const
    {
        const PositionMap map = {imageSize, level.image.size(), level.scale, p.edgeThreshold, p.subPixel};
        return map;
    }
    static void layOutStripes(Workspace& workspace);
    void refine(Workspace& workspace, const Stripe& stripe, Size imageSize, const Mat& mask) const;
    void describe(Workspace& workspace, const Stripe& stripe, Mat& descriptors) const;

    Parameters p;
    Tables tables;
    Pool<Workspace> workspaces;
    mutable Pool<TaskScratch> scratches;
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

    const Mat image = grayImage(image_),
              mask = useProvidedKeypoints ? Mat() : checkedMask(mask_, image.size());
    const Pool<Workspace>::Lease lease(workspaces);
    Workspace& workspace = *lease;
    if (useProvidedKeypoints)
        locate(image, keypoints, workspace);
    else
        chooseCorners(image, mask, workspace);

    const size_t count = workspace.keypoints.size();
    Mat descriptors;
    if (withDescriptors && count > 0)
    {
        descriptors_.create(int(count), kBytes, CV_8UC1);
        descriptors = descriptors_.getMat();
    }
    else if (withDescriptors)
    {
        descriptors_.release();
    }
    layOutStripes(workspace);
    inParallel(workspace.stripes.size(),
               [&](size_t i)
               {
                   CV_TRACE_REGION("stripe");
                   if (!useProvidedKeypoints)
                       refine(workspace, workspace.stripes[i], image.size(), mask);
                   if (!descriptors.empty())
                       describe(workspace, workspace.stripes[i], descriptors);
               });
    keypoints = workspace.keypoints;
}

// Finds the corners that become features.
void AdaptiveQuadtreeORBImpl::chooseCorners(const Mat& image, const Mat& mask, Workspace& workspace) const
{
    p.checkTogether(p.nlevels);
    const Thresholds thresholds =
        p.adaptiveThreshold
            ? adaptiveThresholds(varianceOverMean(image, mask), p.fastThreshold, p.minThresholdRatio)
            : fixedThresholds(p.fastThreshold, p.minThresholdRatio);

    const int FAST_RADIUS = 3;
    const int minSide = int(std::min(2 * std::max<int64>(p.edgeThreshold, FAST_RADIUS) + 1, int64(INT_MAX)));
    std::vector<Level>& pyramid = workspace.pyramid;
    layOutPyramid(image, mask, p.nlevels, p.firstLevel, p.scaleFactor, minSide, pyramid);
    const size_t levels = pyramid.size();
    workspace.resize(levels);

    std::vector<SelectionLevel>& selectionLevels = workspace.selectionLevels;
    selectionLevels.resize(levels);
    for (size_t i = 0; i < levels; i++)
    {
        const Size size = pyramid[i].image.size();
        const int quota = tables.quotas[i], depth = p.maxDepth >= 0 ? p.maxDepth : quadtreeDepth(quota);
        const SelectionLevel level = {size, pyramid[i].scale, regionOf(size), depth, quota};
        selectionLevels[i] = level;
    }
    // Levels too small for a keypoint leave their quota to the next finer one.
    if (levels > 0)
        selectionLevels.back().quota =
            std::accumulate(tables.quotas.begin() + (levels - 1), tables.quotas.end(), 0);

    PyramidCorners source(p, thresholds, workspace, scratches);
    // The image itself is searched while the other levels are made of it.
    const size_t ofImage = source.layOutBands(true), bands = source.layOutBands(false);
    inParallel(1 + ofImage,
               [&](size_t i)
               {
                   if (i > 0)
                       return source.search(i - 1);
                   fillPyramid(image, mask, p.firstLevel, pyramid, workspace.resizing);
                   for (size_t j = 0; j < levels && !mask.empty(); j++)
                   {
                       if (!pyramid[j].isInput)
                           maskPositions(mask, positionsOf(pyramid[j], image.size()), pyramid[j].mask);
                   }
               });
    // The corners of the image, of which there are most, are ranked while those of other levels are searched for.
    inParallel(bands,
               [&](size_t i)
               {
                   if (i < ofImage)
                       source.rank(i);
                   else
                       source.search(i);
               });
    inParallel(levels,
               [&](size_t i)
               {
                   if (selectionLevels[i].quota > 0)
                       source.prepare(int(i));
               });

    workspace.selector.select(selectionLevels, image.size(), p.octaveSuppression, source, workspace.chosen);
    workspace.firsts.assign(1, 0);
    for (size_t i = 0; i < levels; i++)
    {
        std::vector<RankedCorner>& corners = workspace.chosen[i];
        std::vector<DescriptorPoint>& points = workspace.points[i];
        sortInRasterOrder(corners, pyramid[i].image.rows, workspace.rowStarts, workspace.sorted);
        points.resize(corners.size());
        for (size_t j = 0; j < corners.size(); j++)
        {
            points[j].x = corners[j].x;
            points[j].y = corners[j].y;
        }
        workspace.firsts.push_back(workspace.firsts[i] + corners.size());
    }
    workspace.keypoints.resize(workspace.firsts[levels]);
}

// Stripes of about as many features, so that no thread waits for one level's.
void AdaptiveQuadtreeORBImpl::layOutStripes(Workspace& workspace)
{
    // No more and no smaller: neighbouring stripes both blur the rows between them.
    const size_t STRIPES = 8, MIN_FEATURES = 64;
    const size_t most = std::max(workspace.keypoints.size() / STRIPES, MIN_FEATURES);
    workspace.stripes.clear();
    for (int level = 0; level < int(workspace.pyramid.size()); level++)
    {
        const size_t count = workspace.points[level].size(), stripes = (count + most - 1) / most;
        for (size_t i = 0; i < stripes; i++)
        {
            const Stripe stripe = {level, count * i / stripes, count * (i + 1) / stripes};
            workspace.stripes.push_back(stripe);
        }
    }
}

// The features at the chosen corners of a stripe: their direction and their position in the image.
void AdaptiveQuadtreeORBImpl::refine(Workspace& workspace, const Stripe& stripe, Size imageSize,
                                     const Mat& mask) const
{
    CV_TRACE_FUNCTION();
    const Level& level = workspace.pyramid[stripe.level];
    DescriptorPoint* points = workspace.points[stripe.level].data();
    orientations(level.image, tables.patch, points + stripe.begin, stripe.end - stripe.begin);
    const PositionMap position = positionsOf(level, imageSize);
    for (size_t i = stripe.begin; i < stripe.end; i++)
    {
        const DescriptorPoint& point = points[i];
        const Point2d offset = p.subPixel ? subPixelOffset(level.image, point.x, point.y) : Point2d();
        Point2f pt = position(point.x, point.y, offset.x, offset.y);
        if (p.subPixel && !mask.empty() && !mask.at<uchar>(cvRound(pt.y), cvRound(pt.x)))
            pt = position(point.x, point.y);
        workspace.keypoints[workspace.firsts[stripe.level] + i] =
            KeyPoint(pt, p.patchSize * level.scale, point.angle, workspace.chosen[stripe.level][i].response,
                     stripe.level);
    }
}

// The descriptors of the features of a stripe.
void AdaptiveQuadtreeORBImpl::describe(Workspace& workspace, const Stripe& stripe, Mat& descriptors) const
{
    const Mat& level = workspace.pyramid[stripe.level].image;
    const DescriptorPoint* points = workspace.points[stripe.level].data();
    const Pool<TaskScratch>::Lease lent(scratches);
    TaskScratch& scratch = *lent;
    const int reach = tables.tests.reach, side = 2 * reach + 1;
    scratch.blurRegion.begin(level.size());
    for (size_t i = stripe.begin; i < stripe.end; i++)
        scratch.blurRegion.add(Rect(points[i].x - reach, points[i].y - reach, side, side));
    if (scratch.blurred.size() < level.total())
        scratch.blurred.resize(level.total());
    Mat blurred(level.size(), CV_16UC1, scratch.blurred.data());
    approximateBlur(level, scratch.blurRegion, blurred, scratch.blur);
    computeDescriptors(level, blurred, points + stripe.begin, stripe.end - stripe.begin, tables.tests,
                       descriptors.ptr(int(workspace.firsts[stripe.level] + stripe.begin)), descriptors.step);
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
        // Where to sample would be anywhere.
        if (!std::isfinite(provided[i].angle))
            CV_Error_(Error::StsOutOfRange,
                      ("keypoints: got angle %g; a finite angle is accepted", provided[i].angle));
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
    layOutPyramid(image, Mat(), levels, p.firstLevel, p.scaleFactor, 1, workspace.pyramid);
    fillPyramid(image, Mat(), p.firstLevel, workspace.pyramid, workspace.resizing);
    workspace.resize(levels);
    for (int i = 0; i < levels; i++)
        workspace.points[i].clear();
    for (size_t i = 0; i < inside.size(); i++)
    {
        const KeyPoint& keypoint = inside[i];
        const float inverseScale = 1.f / workspace.pyramid[keypoint.octave].scale;
        const DescriptorPoint point = {cvRound(keypoint.pt.x * inverseScale),
                                       cvRound(keypoint.pt.y * inverseScale), keypoint.angle};
        workspace.points[keypoint.octave].push_back(point);
    }
    workspace.firsts.assign(1, 0);
    for (int i = 0; i < levels; i++)
        workspace.firsts.push_back(workspace.firsts[i] + workspace.points[i].size());
    workspace.keypoints.swap(inside);
}

}  // namespace aqorb
}  // namespace cv
