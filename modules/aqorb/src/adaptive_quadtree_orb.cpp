// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "parameters.hpp"

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

// A pixel of a level at which a keypoint lies.
struct LevelPixel
{
    int level;
    DescriptorPoint point;
};

// Detects and ranks the corners of the pyramid's levels for selection.
class PyramidCorners : public CornerSource
{
public:
    PyramidCorners(const Parameters& parameters_, const std::vector<Level>& pyramid_, Thresholds thresholds_)
        : parameters(parameters_), pyramid(pyramid_), thresholds(thresholds_), found(pyramid_.size())
    {
    }
    Rect region(int level) const
    {
        const int border = parameters.edgeThreshold;
        const Size size = pyramid[level].image.size();
        return Rect(border, border, size.width - 2 * border, size.height - 2 * border);
    }
    void corners(int level, CornerSet set, std::vector<RankedCorner>& ranked) CV_OVERRIDE
    {
        LevelCorners& level_corners = found[level];
        switch (set)
        {
        case KEPT_CORNERS:
            // Harris responses of neighbours hardly differ: unsuppressed, a strong corner is taken thrice.
            findCorners(pyramid[level], region(level), thresholds, parameters.cellSize,
                        isHarris(), level_corners);
            rank(level, level_corners.kept, ranked);
            break;
        case SUPPRESSED_CORNERS: rank(level, level_corners.suppressed, ranked); break;
        case CELL_REJECTS:
        {
            std::vector<Corner> rejects;
            findCellRejects(pyramid[level], region(level), thresholds, parameters.cellSize, rejects);
            rank(level, rejects, ranked);
            break;
        }
        }
    }

private:
    bool isHarris() const { return parameters.scoreType == ORB::HARRIS_SCORE; }

    void rank(int level, const std::vector<Corner>& unranked, std::vector<RankedCorner>& ranked) const
    {
        if (isHarris())
        {
            harrisResponses(pyramid[level].image, unranked, ranked);
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
    const std::vector<Level>& pyramid;
    const Thresholds thresholds;
    std::vector<LevelCorners> found;
};

bool inRasterOrder(const RankedCorner& a, const RankedCorner& b)
{
    return a.y != b.y ? a.y < b.y : a.x < b.x;
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
    void setScoreType(ORB::ScoreType value) CV_OVERRIDE { set(&Parameters::scoreType, value); }
    ORB::ScoreType getScoreType() const CV_OVERRIDE { return p.scoreType; }
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

    void detect(const Mat& image, const Mat& mask, std::vector<Level>& pyramid, std::vector<KeyPoint>& keypoints,
                std::vector<LevelPixel>& pixels) const;
    void locate(const Mat& image, const std::vector<KeyPoint>& provided, std::vector<Level>& pyramid,
                std::vector<KeyPoint>& keypoints, std::vector<LevelPixel>& pixels) const;
    void describe(const std::vector<Level>& pyramid, const std::vector<LevelPixel>& pixels, Mat& descriptors) const;

    Parameters p;
};

Ptr<AdaptiveQuadtreeORB> AdaptiveQuadtreeORB::create(int nfeatures, float scaleFactor, int nlevels, int edgeThreshold,
                                                     int firstLevel, int WTA_K, ORB::ScoreType scoreType, int patchSize,
                                                     int fastThreshold)
{
    Parameters parameters;
    parameters.nfeatures = nfeatures;
    parameters.scaleFactor = scaleFactor;
    parameters.nlevels = nlevels;
    parameters.edgeThreshold = edgeThreshold;
    parameters.firstLevel = firstLevel;
    parameters.WTA_K = WTA_K;
    parameters.scoreType = scoreType;
    parameters.patchSize = patchSize;
    parameters.fastThreshold = fastThreshold;
    return makePtr<AdaptiveQuadtreeORBImpl>(parameters);
}

void AdaptiveQuadtreeORBImpl::detectAndCompute(InputArray image_, InputArray mask_, std::vector<KeyPoint>& keypoints,
                                               OutputArray descriptors_, bool useProvidedKeypoints)
{
    CV_TRACE_FUNCTION();
    const bool withDescriptors = descriptors_.needed();
    if (useProvidedKeypoints && !withDescriptors)
        return;  // as cv::ORB

    std::vector<KeyPoint> found;
    std::vector<LevelPixel> pixels;
    Mat descriptors;
    if (!image_.empty())
    {
        const Mat image = grayImage(image_);
        std::vector<Level> pyramid;
        if (useProvidedKeypoints)
            locate(image, keypoints, pyramid, found, pixels);
        else
            detect(image, checkedMask(mask_, image.size()), pyramid, found, pixels);
        if (withDescriptors)
            describe(pyramid, pixels, descriptors);
    }
    keypoints.swap(found);
    if (withDescriptors)
    {
        if (descriptors.empty())
            descriptors_.release();
        else
            descriptors.copyTo(descriptors_);
    }
}

// The keypoints of an image, and the pixels they were found at.
void AdaptiveQuadtreeORBImpl::detect(const Mat& image, const Mat& mask, std::vector<Level>& pyramid,
                                     std::vector<KeyPoint>& keypoints, std::vector<LevelPixel>& pixels) const
{
    p.checkTogether(p.nlevels);
    const Thresholds thresholds =
        p.adaptiveThreshold
            ? adaptiveThresholds(varianceOverMean(image, mask), p.fastThreshold, p.minThresholdRatio)
            : fixedThresholds(p.fastThreshold, p.minThresholdRatio);

    const int FAST_RADIUS = 3;
    const int minSide = 2 * std::max(p.edgeThreshold, FAST_RADIUS) + 1;
    buildPyramid(image, mask, p.nlevels, p.firstLevel, p.scaleFactor, minSide, pyramid);
    const int levels = int(pyramid.size());

    std::vector<PositionMap> positions(levels);
    for (int i = 0; i < levels; i++)
    {
        const PositionMap position = {image.size(), pyramid[i].image.size(), pyramid[i].scale, p.edgeThreshold,
                                      p.subPixel};
        positions[i] = position;
        if (!mask.empty() && i != p.firstLevel)
            maskPositions(mask, position, pyramid[i].mask);
    }

    PyramidCorners source(p, pyramid, thresholds);
    const std::vector<int> quotas = levelQuotas(p.nfeatures, p.scaleFactor, p.nlevels);
    std::vector<SelectionLevel> selectionLevels(levels);
    for (int i = 0; i < levels; i++)
    {
        const SelectionLevel level = {pyramid[i].image.size(), pyramid[i].scale, source.region(i),
                                      p.maxDepth >= 0 ? p.maxDepth : quadtreeDepth(quotas[i]), quotas[i]};
        selectionLevels[i] = level;
    }
    std::vector<std::vector<RankedCorner> > chosen;
    selectFeatures(selectionLevels, image.size(), p.octaveSuppression, source, chosen);

    const std::vector<int> patch = circularPatch(p.patchSize);
    for (int i = 0; i < levels; i++)
    {
        const Level& level = pyramid[i];
        std::sort(chosen[i].begin(), chosen[i].end(), inRasterOrder);
        std::vector<DescriptorPoint> points(chosen[i].size());
        for (size_t j = 0; j < points.size(); j++)
        {
            points[j].x = chosen[i][j].x;
            points[j].y = chosen[i][j].y;
        }
        orientations(level.image, patch, points.data(), points.size());
        for (size_t j = 0; j < points.size(); j++)
        {
            const DescriptorPoint& point = points[j];
            Point2f pt = positions[i](point.x, point.y);
            if (p.subPixel)
            {
                const Point2d offset = subPixelOffset(level.image, point.x, point.y);
                const Point2f refined = positions[i](point.x, point.y, offset.x, offset.y);
                if (mask.empty() || mask.at<uchar>(cvRound(refined.y), cvRound(refined.x)))
                    pt = refined;
            }
            keypoints.push_back(KeyPoint(pt, p.patchSize * level.scale, point.angle, chosen[i][j].response, i));
            const LevelPixel pixel = {i, point};
            pixels.push_back(pixel);
        }
    }
}

// What compute does with given keypoints, as cv::ORB: drops those near the border, orders the others
// by level and finds their pixels.
void AdaptiveQuadtreeORBImpl::locate(const Mat& image, const std::vector<KeyPoint>& provided,
                                     std::vector<Level>& pyramid, std::vector<KeyPoint>& keypoints,
                                     std::vector<LevelPixel>& pixels) const
{
    int maxOctave = 0;
    bool sorted = true;
    for (size_t i = 0; i < provided.size(); i++)
    {
        const int octave = provided[i].octave;
        if (octave < 0)
            CV_Error_(Error::StsOutOfRange, ("keypoints: got octave %d; >= 0 is accepted (SIFT packs more than the "
                                             "octave into the field: unpack it first)", octave));
        maxOctave = std::max(maxOctave, octave);
        sorted = sorted && (i == 0 || octave >= provided[i - 1].octave);
    }
    p.checkTogether(std::max(p.nlevels, maxOctave == 0 ? 1 : maxOctave));
    const Size smallest = levelSize(image.size(), levelScale(maxOctave, p.firstLevel, p.scaleFactor));
    if (maxOctave > 0 && (smallest.width < 1 || smallest.height < 1))
        CV_Error_(Error::StsOutOfRange, ("keypoints: got octave %d, whose level would have no pixels; an octave of a "
                                         "level of at least 1 x 1 pixels is accepted (SIFT packs more than the octave "
                                         "into the field: unpack it first)", maxOctave));

    const Rect inside(p.edgeThreshold, p.edgeThreshold, image.cols - 2 * p.edgeThreshold,
                      image.rows - 2 * p.edgeThreshold);
    for (size_t i = 0; i < provided.size(); i++)
    {
        const Point2f pt = provided[i].pt;
        if (pt.x >= inside.x && pt.y >= inside.y && pt.x < inside.x + inside.width && pt.y < inside.y + inside.height)
            keypoints.push_back(provided[i]);
    }
    if (keypoints.empty())
        return;
    if (!sorted)
    {
        struct ByOctave
        {
            static bool less(const KeyPoint& a, const KeyPoint& b) { return a.octave < b.octave; }
        };
        std::stable_sort(keypoints.begin(), keypoints.end(), ByOctave::less);
    }
    buildPyramid(image, Mat(), keypoints.back().octave + 1, p.firstLevel, p.scaleFactor, 1, pyramid);
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const KeyPoint& keypoint = keypoints[i];
        const float inverseScale = 1.f / pyramid[keypoint.octave].scale;
        const DescriptorPoint point = {cvRound(keypoint.pt.x * inverseScale), cvRound(keypoint.pt.y * inverseScale),
                                       keypoint.angle};
        const LevelPixel pixel = {keypoint.octave, point};
        pixels.push_back(pixel);
    }
}

// The pixels are ordered by level.
void AdaptiveQuadtreeORBImpl::describe(const std::vector<Level>& pyramid, const std::vector<LevelPixel>& pixels,
                                       Mat& descriptors) const
{
    if (pixels.empty())
        return;
    const std::vector<Point> pattern = descriptorPattern(p.patchSize, p.WTA_K);
    descriptors.create(int(pixels.size()), kBytes, CV_8UC1);
    Mat blurred;
    std::vector<DescriptorPoint> points;
    for (size_t first = 0, end; first < pixels.size(); first = end)
    {
        const int level = pixels[first].level;
        points.clear();
        for (end = first; end < pixels.size() && pixels[end].level == level; end++)
            points.push_back(pixels[end].point);
        approximateBlur(pyramid[level].image, blurred);
        computeDescriptors(pyramid[level].image, blurred, &points[0], points.size(), pattern, p.WTA_K,
                           descriptors.ptr(int(first)), descriptors.step);
    }
}

}  // namespace aqorb
}  // namespace cv
