// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "frame.hpp"
#include "input.hpp"
#include "parameters.hpp"
#include "pool.hpp"

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
                          OutputArray descriptors, bool useProvidedKeypoints) CV_OVERRIDE
    {
        CV_TRACE_FUNCTION();
        process(image, mask, keypoints, descriptors, useProvidedKeypoints, 0);
    }
    void detectAndComputeWithPyramid(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                                     OutputArray descriptors, OutputArrayOfArrays levels) CV_OVERRIDE
    {
        CV_TRACE_FUNCTION();
        checkLevelsOutput(levels);
        process(image, mask, keypoints, descriptors, false, &levels);
    }
    void releaseMemory() CV_OVERRIDE { workspaces.clear(); }

private:
    void process(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints, OutputArray descriptors,
                 bool useProvidedKeypoints, const _OutputArray* levels);
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

    Parameters parameters;
    Tables tables;
    Pool<Workspace> workspaces;
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

// Makes the levels of the pyramid but the first ones, which have been made.
static void completePyramid(const Parameters& parameters, int made, Workspace& workspace)
{
    workspace.layOutLevels(parameters.nlevels, parameters.firstLevel, parameters.scaleFactor, 1);
    for (int i = made; i < workspace.levelCount; i++)
        workspace.makeLevel(i, parameters.firstLevel);
    // The caller's pixels may lie in the memory of a level that is given up when the levels are given.
    if (parameters.firstLevel < workspace.levelCount)
    {
        Mat& input = workspace.levels[parameters.firstLevel].level.image;
        input = input.clone();
    }
}

static void giveLevels(const Workspace& workspace, const _OutputArray& levels)
{
    createLevels(levels, workspace.levelCount);
    for (int i = 0; i < workspace.levelCount; i++)
    {
        const Mat& image = workspace.levels[i].level.image;
        if (levels.isUMatVector())
        {
            // A new UMat, because the caller may share the old one.
            UMat copy;
            image.copyTo(copy);
            levels.getUMatRef(i) = copy;
        }
        else
        {
            levels.getMatRef(i) = image;
        }
    }
}

void AdaptiveQuadtreeORBImpl::buildPyramid(InputArray image_, OutputArrayOfArrays levels_) const
{
    CV_TRACE_FUNCTION();
    checkLevelsOutput(levels_);
    const UMat held = heldUMat(image_);
    Workspace workspace;
    workspace.givesLevels = true;
    if (!image_.empty())
    {
        parameters.checkTogether(parameters.nlevels);
        workspace.input.image = grayImage(image_);
        checkPyramidInput(workspace.input.image.size());
        completePyramid(parameters, 0, workspace);
    }
    giveLevels(workspace, levels_);
}

void AdaptiveQuadtreeORBImpl::process(InputArray image_, InputArray mask_, std::vector<KeyPoint>& keypoints,
                                      OutputArray descriptors_, bool useProvidedKeypoints,
                                      const _OutputArray* levels)
{
    const bool withDescriptors = descriptors_.needed();
    if (useProvidedKeypoints && !withDescriptors)
        return;  // as cv::ORB
    if (withDescriptors)
        checkDescriptorsOutput(descriptors_);
    if (image_.empty())
    {
        if (withDescriptors)
            releaseDescriptors(descriptors_);
        if (levels)
            createLevels(*levels, 0);
        keypoints.clear();
        return;
    }

    const UMat heldImage = heldUMat(image_), heldMask = heldUMat(mask_);
    checkImage(image_);
    const Size size = image_.size();
    checkPyramidInput(size);
    const Pool<Workspace>::Lease lease(workspaces, size_t(size.area()));
    Workspace& workspace = *lease;
    Level input;
    input.image = grayImage(image_, &workspace.gray);
    if (!useProvidedKeypoints)
        input.mask = checkedMask(mask_, size);
    const InputScope scope(workspace, input);
    workspace.givesLevels = levels != 0;
    Frame frame(parameters, tables, workspace);
    if (useProvidedKeypoints)
        frame.describeGiven(keypoints);
    else
        frame.detect(withDescriptors);
    const size_t count = frame.count();
    const int levelsInUse = workspace.levelCount;
    if (levels)
        completePyramid(parameters, levelsInUse, workspace);

    // The outputs are written when the image has been read, because they may share its memory.
    Mat descriptors;
    if (withDescriptors && count > 0)
        descriptors = createDescriptors(descriptors_, int(count));
    else if (withDescriptors)
        releaseDescriptors(descriptors_);
    if (levels)
        giveLevels(workspace, *levels);
    workspace.levelCount = levelsInUse;
    frame.output(keypoints, descriptors);
}

}  // namespace aqorb
}  // namespace cv
