// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "frame.hpp"
#include "image_loop.hpp"
#include "input.hpp"
#include "parameters.hpp"
#include "pool.hpp"

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

String AdaptiveQuadtreeORB::getDefaultName() const
{
    return Feature2D::getDefaultName() + ".AdaptiveQuadtreeORB";
}

// The setter and the getter of a row of the table of parameters.
#define AQORB_PROPERTY(property, type, name, ...) \
    void set##property(type value) CV_OVERRIDE    \
    {                                             \
        set(&Parameters::name, stored(value));    \
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
        checkMatsOutput(levels, "levels");
        process(image, mask, keypoints, descriptors, false, &levels);
    }
    // Of Feature2D. Those for one image are its own.
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
    void process(InputArray image, InputArray mask, std::vector<KeyPoint>& keypoints, OutputArray descriptors,
                 bool useProvidedKeypoints, const _OutputArray* levels);
    template <typename T> void set(T Parameters::*field, T value)
    {
        Parameters changed = parameters;
        changed.*field = value;
        changed.check();
        use(changed);
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
#define AQORB_ARGUMENT(property, type, name, ...) parameters.name = stored<type>(name);
    AQORB_PARAMETERS_OF_ORB(AQORB_ARGUMENT)
#undef AQORB_ARGUMENT
    parameters.check();
    parameters.checkTogether(nlevels);
    return makePtr<AdaptiveQuadtreeORBImpl>(parameters);
}

// Makes the levels of the pyramid that have not been made yet.
static void completeLevels(const Parameters& parameters, Levels& levels)
{
    for (int i = levels.size(), count = levels.layOut(parameters.nlevels, 1); i < count; i++)
        levels.make(i);
    // The caller's pixels may lie in the memory of a level that is given up when the levels are given.
    if (parameters.firstLevel < levels.size())
    {
        Mat& input = levels[parameters.firstLevel].image;
        input = input.clone();
    }
}

static void giveLevels(const Levels& levels, const _OutputArray& output)
{
    std::vector<Mat> images(size_t(levels.size()));
    for (int i = 0; i < levels.size(); i++)
        images[i] = levels[i].image;
    giveMats(images, output, "levels");
}

// Processes the images of a collection side by side, each on one thread, or a single one on all of them.
template <typename Process> static void forEachImage(size_t count, const Process& process)
{
    ImageLoop loop(count);
    const int threads = int(std::min(size_t(TaskQueue::threadsAllowed()), count));
    if (threads <= 1)
    {
        loop.work(process);
    }
    else
    {
        parallel_for_(
            Range(0, threads),
            [&](const Range&)
            {
                const SingleThreadScope scope;
                loop.work(process);
            },
            threads);
    }
    loop.check();
}

void AdaptiveQuadtreeORBImpl::buildPyramid(InputArray image_, OutputArrayOfArrays levels_) const
{
    CV_TRACE_FUNCTION();
    checkMatsOutput(levels_, "levels");
    const UMat held = heldUMat(image_);
    Levels levels;
    if (!image_.empty())
    {
        parameters.checkTogether(parameters.nlevels);
        Level input;
        input.image = grayImage(image_);
        checkPyramidInput(input.image.size());
        levels.reset(input, parameters.firstLevel, parameters.scaleFactor, true);
        completeLevels(parameters, levels);
    }
    giveLevels(levels, levels_);
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
            giveMats(std::vector<Mat>(), *levels, "levels");
        keypoints.clear();
        return;
    }

    const UMat heldImage = heldUMat(image_), heldMask = heldUMat(mask_);
    checkImage(image_);
    const Size size = image_.size();
    checkPyramidInput(size);
    const Pool<Workspace>::Lease lease(workspaces, size_t(size.width) * size.height);
    Workspace& workspace = *lease;
    Level input;
    input.image = grayImage(image_, &workspace.gray);
    if (!useProvidedKeypoints)
        input.mask = checkedMask(mask_, size);
    Frame frame(parameters, tables, workspace);
    workspace.levels.reset(input, parameters.firstLevel, parameters.scaleFactor, levels != 0);
    if (useProvidedKeypoints)
        frame.describeGiven(keypoints);
    else
        frame.detect(withDescriptors);
    const size_t count = frame.count();
    if (levels)
        completeLevels(parameters, workspace.levels);

    // The outputs are written when the image has been read, because they may share its memory.
    Mat descriptors;
    if (withDescriptors && count > 0)
        descriptors = createDescriptors(descriptors_, int(count));
    else if (withDescriptors)
        releaseDescriptors(descriptors_);
    if (levels)
        giveLevels(workspace.levels, *levels);
    frame.output(keypoints, descriptors);
}

void AdaptiveQuadtreeORBImpl::detect(InputArrayOfArrays images_,
                                     std::vector<std::vector<KeyPoint>>& keypoints, InputArrayOfArrays masks_)
{
    detectAndComputeBatch(images_, masks_, keypoints, noArray());
}

// The outputs are given at the end, so that an error leaves them unchanged and no image is lost that shares their memory.
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
    giveMats(descriptors, descriptors_, "descriptors");
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
                     const _OutputArray ofImage = withDescriptors ? descriptors[i] : _OutputArray();
                     process(collection.images[i], collection.mask(i), found[i], ofImage, false, 0);
                 });
    if (withDescriptors)
        giveMats(descriptors, descriptors_, "descriptors");
    keypoints.swap(found);
}

}  // namespace aqorb
}  // namespace cv
