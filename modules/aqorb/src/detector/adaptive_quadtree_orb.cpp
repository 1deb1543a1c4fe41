// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The class AdaptiveQuadtreeORB, and the path of an image through the stages.

#include "precomp.hpp"

#include "detector/arguments.hpp"
#include "common/for_each.hpp"
#include "detector/parameters.hpp"
#include "detector/selection.hpp"
#include "detector/threshold.hpp"
#include "detector/workspace.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

String AdaptiveQuadtreeORB::getDefaultName() const
{
    return Feature2D::getDefaultName() + ".AdaptiveQuadtreeORB";
}

// Setter and getter of one parameter.
#define AQORB_PROPERTY(property, type, name, ...) \
    void set##property(type value) CV_OVERRIDE    \
    {                                             \
        set(&Parameters::name, toStored(value));  \
    }                                             \
    type get##property() const CV_OVERRIDE        \
    {                                             \
        return type(parameters.name);             \
    }

class AdaptiveQuadtreeORBImpl CV_FINAL : public AdaptiveQuadtreeORB
{
public:
    explicit AdaptiveQuadtreeORBImpl(const Parameters& parameters_)
        : parameters(parameters_), tables(parameters)
    {
    }

    AQORB_PARAMETERS(AQORB_PROPERTY)

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
        adopt(changed);
    }

    void buildPyramid(InputArray image, OutputArrayOfArrays levels) const CV_OVERRIDE;
    void detectAndComputeWithPyramid(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                                     OutputArray descriptors, std::vector<Mat>& levels) CV_OVERRIDE
    {
        CV_TRACE_FUNCTION();
        std::vector<Mat> images;  // the input may be in `levels`
        process(image, mask, keypoints, descriptors, false, &images);
        levels.swap(images);
    }
    void detectAndCompute(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints,
                          OutputArray descriptors, bool useProvidedKeypoints) CV_OVERRIDE
    {
        CV_TRACE_FUNCTION();
        process(image, mask, keypoints, descriptors, useProvidedKeypoints);
    }
    // Overloads for collections. Feature2D has the overloads for one image.
    using Feature2D::compute;
    using Feature2D::detect;
    void detect(InputArrayOfArrays images, std::vector<std::vector<KeyPoint>>& keypoints,
                InputArrayOfArrays masks) CV_OVERRIDE;
    void compute(InputArrayOfArrays images, std::vector<std::vector<KeyPoint>>& keypoints,
                 OutputArrayOfArrays descriptors) CV_OVERRIDE;
    void detectAndComputeBatch(InputArrayOfArrays images, InputArrayOfArrays masks,
                               std::vector<std::vector<KeyPoint>>& keypoints,
                               OutputArrayOfArrays descriptors) CV_OVERRIDE;
    void releaseMemory() CV_OVERRIDE { workspaces.clear(); }

private:
    //! @param pyramid if given, receives copies of all levels
    void process(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints, OutputArray descriptors,
                 bool useProvidedKeypoints, std::vector<Mat>* pyramid = 0);
    std::vector<FeatureList> findFeatures(const Level& input, const std::vector<Level>& levels, int threads,
                                          CornerSpace& space) const;
    template <typename T> void set(T Parameters::*field, T value)
    {
        Parameters changed = parameters;
        changed.*field = value;
        changed.check();
        adopt(changed);
    }
    void adopt(const Parameters& changed)
    {
        Tables newTables(changed);
        parameters = changed;
        std::swap(tables, newTables);
    }

    Parameters parameters;
    Tables tables;
    Workspaces workspaces;
};

Ptr<AdaptiveQuadtreeORB> AdaptiveQuadtreeORB::create(int nfeatures, float scaleFactor, int nlevels,
                                                     int edgeThreshold, int firstLevel, int WTA_K,
                                                     ORB::ScoreType scoreType, int patchSize,
                                                     int fastThreshold)
{
    Parameters parameters;
#define AQORB_ARGUMENT(property, type, name, ...) parameters.name = toStored<type>(name);
    AQORB_PARAMETERS_OF_ORB(AQORB_ARGUMENT)
#undef AQORB_ARGUMENT
    parameters.check();
    parameters.checkTogether(nlevels);
    return makePtr<AdaptiveQuadtreeORBImpl>(parameters);
}

static std::vector<Mat> copiesOf(const std::vector<Level>& levels)
{
    std::vector<Mat> images;
    for (const Level& level : levels)
        images.push_back(level.image.clone());
    return images;
}

void AdaptiveQuadtreeORBImpl::buildPyramid(InputArray image_, OutputArrayOfArrays levels_) const
{
    CV_TRACE_FUNCTION();
    checkMatsOutput(levels_, "levels");
    const UMat retained = retainUMat(image_);
    PyramidSpace space;
    std::vector<Level> levels;
    if (!image_.empty())
    {
        parameters.checkTogether(parameters.nlevels);
        Level input;
        input.image = grayImage(image_);
        checkPyramidInput(input.image.size());
        const PyramidRule rule = {parameters.firstLevel, parameters.scaleFactor, parameters.nlevels, 1};
        levels = makePyramid(input, rule, stageThreads(), space);
    }
    assignMats(copiesOf(levels), levels_, "levels");
}

// Thresholds, corners and selection.
std::vector<FeatureList> AdaptiveQuadtreeORBImpl::findFeatures(const Level& input,
                                                               const std::vector<Level>& levels, int threads,
                                                               CornerSpace& space) const
{
    const double contrast =
        parameters.adaptiveThreshold ? varianceOverMean(input.image, input.mask, threads) : NEUTRAL_CONTRAST;
    const Thresholds thresholds =
        fastThresholds(contrast, parameters.fastThreshold, parameters.minThresholdRatio);
    return selectFeatures(parameters, tables.strengthPatch, input.image.size(), levels, thresholds, threads,
                          space);
}

void AdaptiveQuadtreeORBImpl::process(InputArray image_, InputArray mask_, std::vector<KeyPoint>& keypoints,
                                      OutputArray descriptors, bool useProvidedKeypoints,
                                      std::vector<Mat>* pyramid)
try
{
    if (useProvidedKeypoints && !descriptors.needed())
        return;  // as cv::ORB
    if (descriptors.needed())
        checkDescriptorsOutput(descriptors);
    if (image_.empty())
    {
        outputFeatures(std::vector<FeatureList>(), keypoints, descriptors);
        return;
    }

    // Input.
    const UMat retainedImage = retainUMat(image_), retainedMask = retainUMat(mask_);
    checkImage(image_);
    const Size size = image_.size();
    checkPyramidInput(size);
    const Workspaces::Handle handle(workspaces);
    Workspace& space = *handle;
    const int threads = stageThreads();  // read once: another thread may change it
    Level input;
    input.image = grayImage(image_, &space.gray);
    std::vector<FeatureList> features;
    if (useProvidedKeypoints)
        features = groupGivenKeypoints(keypoints, parameters, size);
    else
    {
        input.mask = checkedMask(mask_, size);
        parameters.checkTogether(parameters.nlevels);
    }

    // Pyramid.
    const int shortest = useProvidedKeypoints ? 1 : parameters.shortestSide();
    const PyramidRule rule = {parameters.firstLevel, parameters.scaleFactor,
                              useProvidedKeypoints ? int(features.size()) : parameters.nlevels,
                              pyramid ? 1 : shortest};
    std::vector<Level> levels = makePyramid(input, rule, threads, space.pyramid);
    if (pyramid)
        *pyramid = copiesOf(levels);
    while (!levels.empty() && std::min(levels.back().image.rows, levels.back().image.cols) < shortest)
        levels.pop_back();
    DescriptionRules rules = {
        input.mask, {}, useProvidedKeypoints ? 0 : &tables.patch, descriptors.needed() ? &tables.tests : 0};
    const bool subPixel = selectionMethod(parameters).subPixel;
    for (Level& level : levels)
    {
        rules.positions.push_back(
            {size, level.image.size(), level.scale, parameters.edgeThreshold, subPixel});
        if (!level.isInput && !input.mask.empty())
            maskPositions(input.mask, rules.positions.back(), level.mask);
    }

    if (!useProvidedKeypoints)
        features = findFeatures(input, levels, threads, space.corners);
    describeFeatures(levels, rules, threads, space.descriptions, features);
    outputFeatures(features, keypoints, descriptors);  // last: the output may share the image's memory
}
catch (const std::bad_alloc&)
{
    CV_Error_(Error::StsNoMem,
              ("The memory does not suffice for an image of %d x %d, with scaleFactor %g and firstLevel %d",
               image_.cols(), image_.rows(), parameters.scaleFactor, parameters.firstLevel));
}

// Processes the images of a collection in parallel, each on one thread; a single image gets all threads. An exception
// names the index of its image.
template <typename Process> static void forEachImage(size_t count, const Process& process)
{
    const auto processOne = [&](size_t i, int)
    {
        const std::unique_ptr<SingleThreadScope> alone(count > 1 ? new SingleThreadScope : 0);
        try
        {
            process(i);
        }
        catch (const Exception& thrown)
        {
            throw Exception(thrown.code, format("images[%d]: %s", int(i), thrown.err.c_str()), thrown.func,
                            thrown.file, thrown.line);
        }
    };
    forEach(count, threadsAllowed(), processOne);
}

void AdaptiveQuadtreeORBImpl::detect(InputArrayOfArrays images_,
                                     std::vector<std::vector<KeyPoint>>& keypoints, InputArrayOfArrays masks_)
{
    detectAndComputeBatch(images_, masks_, keypoints, noArray());
}

// Assigns the outputs at the end: an error leaves them unchanged, and images may share their memory.
void AdaptiveQuadtreeORBImpl::compute(InputArrayOfArrays images_,
                                      std::vector<std::vector<KeyPoint>>& keypoints,
                                      OutputArrayOfArrays descriptors_)
{
    CV_TRACE_FUNCTION();
    if (!descriptors_.needed())
        return;  // as cv::ORB
    checkMatsOutput(descriptors_, "descriptors");
    const Collection collection(images_);
    if (keypoints.size() != collection.images.size())
        CV_Error_(Error::StsBadArg, ("keypoints must be one vector for each image, got %d for %d images",
                                     int(keypoints.size()), int(collection.images.size())));
    std::vector<std::vector<KeyPoint>> described = keypoints;
    std::vector<Mat> descriptors(described.size());
    forEachImage(described.size(),
                 [&](size_t i) { compute(collection.images[i], described[i], descriptors[i]); });
    assignMats(descriptors, descriptors_, "descriptors");
    keypoints.swap(described);
}

void AdaptiveQuadtreeORBImpl::detectAndComputeBatch(InputArrayOfArrays images_, InputArrayOfArrays masks_,
                                                    std::vector<std::vector<KeyPoint>>& keypoints,
                                                    OutputArrayOfArrays descriptors_)
{
    CV_TRACE_FUNCTION();
    const bool withDescriptors = descriptors_.needed();
    if (withDescriptors)
        checkMatsOutput(descriptors_, "descriptors");
    const Collection collection(images_, masks_);
    std::vector<std::vector<KeyPoint>> found(collection.images.size());
    std::vector<Mat> descriptors(found.size());
    forEachImage(found.size(),
                 [&](size_t i)
                 {
                     const _OutputArray imageDescriptors = withDescriptors ? descriptors[i] : _OutputArray();
                     process(collection.images[i], collection.mask(i), found[i], imageDescriptors, false);
                 });
    if (withDescriptors)
        assignMats(descriptors, descriptors_, "descriptors");
    keypoints.swap(found);
}

}  // namespace aqorb
}  // namespace cv
