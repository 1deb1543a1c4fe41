// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "errors.hpp"
#include "images.hpp"
#include "keypoints.hpp"
#include "parameter_table.hpp"
#include "threads.hpp"

#include <algorithm>
#include <cstdint>

namespace aqorb_python
{

namespace
{

typedef Detector::Library Library;

KeyPointTupleObject toObject(const std::vector<cv::KeyPoint>& keypoints)
{
    return {toTuple(keypoints)};
}

KeyPointsObject toObject(KeyPoints&& keypoints)
{
    return {toPython(std::move(keypoints))};
}

// None where there are no rows, as in cv2.
OptionalArrayObject toObject(const cv::Mat& descriptors)
{
    if (descriptors.empty())
        return {py::none()};
    return {toArray(descriptors)};
}

// cv2's optional array for the output. Here the output is returned only.
void checkOutput(const OptionalArrayObject& descriptors)
{
    if (!descriptors.object.is_none())
        throwTypeError("descriptors", brief(descriptors.object), "None, as the descriptors are returned");
}

// The mask of an image of a collection.
cv::Mat maskOf(const std::vector<Pixels>& masks, size_t index)
{
    return masks.empty() ? cv::Mat() : masks[index].mat;
}

//! What is found in an image.
struct Features
{
    Features(const cv::Ptr<Library>& library, const OptionalArrayObject& image,
             const OptionalArrayObject& mask)
    {
        const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
        withoutGil([&] { library->detectAndCompute(pixels.mat, maskPixels.mat, keypoints, descriptors); });
    }
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

//! The features of a collection in arrays, one for each field.
class FeatureArrays
{
public:
    //! @param counts the number of features of each image
    FeatureArrays(const std::vector<size_t>& counts, int descriptorSize)
        : offsets(py::ssize_t(counts.size() + 1))
    {
        size_t sum = 0;
        std::int64_t* const ends = offsets.mutable_data();
        for (size_t i = 0; i < counts.size(); sum += counts[i++])
            ends[i] = std::int64_t(sum);
        ends[counts.size()] = std::int64_t(sum);
        for (py::array_t<float>* array : {&x, &y, &size, &angle, &response})
            *array = py::array_t<float>(py::ssize_t(sum));
        octave = py::array_t<std::int32_t>(py::ssize_t(sum));
        descriptors = py::array_t<uchar>({py::ssize_t(sum), py::ssize_t(descriptorSize)});
        to = {x.mutable_data(),        y.mutable_data(),      size.mutable_data(),       angle.mutable_data(),
              response.mutable_data(), octave.mutable_data(), descriptors.mutable_data()};
    }
    //! Adds the next image. It touches no Python object.
    void add(const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& rows)
    {
        for (const cv::KeyPoint& keypoint : keypoints)
        {
            *to.x++ = keypoint.pt.x;
            *to.y++ = keypoint.pt.y;
            *to.size++ = keypoint.size;
            *to.angle++ = keypoint.angle;
            *to.response++ = keypoint.response;
            *to.octave++ = keypoint.octave;
        }
        to.descriptors = std::copy(rows.data, rows.data + rows.total(), to.descriptors);
    }
    py::object toPython() const
    {
        return py::module_::import("aqorb").attr("FeatureBatch")(x, y, size, angle, response, octave,
                                                                 descriptors, offsets);
    }

private:
    py::array_t<float> x, y, size, angle, response;
    py::array_t<std::int32_t> octave;
    py::array_t<uchar> descriptors;
    py::array_t<std::int64_t> offsets;
    struct
    {
        float *x, *y, *size, *angle, *response;
        std::int32_t* octave;
        uchar* descriptors;
    } to;  // where the next feature goes
};

}  // namespace

cv::Ptr<Library> Detector::copyOf(const Library& other)
{
    const cv::Ptr<Library> copy = Library::create();
#define AQORB_COPY(property, ...) copy->set##property(other.get##property());
    AQORB_PARAMETERS(AQORB_COPY)
#undef AQORB_COPY
    return copy;
}

KeyPointTupleObject detect(const Detector& self, const ImageObject& image, const OptionalArrayObject& mask)
{
    importKeyPoint();
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object), maskPixels = toMask(mask.object);
    std::vector<cv::KeyPoint> keypoints;
    withoutGil([&] { library->detect(pixels.mat, keypoints, maskPixels.mat); });
    return toObject(keypoints);
}

std::vector<KeyPointTupleObject> detectImages(const Detector& self, const ImagesObject& images,
                                              const MasksObject& masks)
{
    importKeyPoint();
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object),
                              maskPixels = toMasks(masks.object, pixels.size());
    std::vector<std::vector<cv::KeyPoint>> keypoints(pixels.size());
    forEachImage(pixels.size(),
                 [&](size_t i) { library->detect(pixels[i].mat, keypoints[i], maskOf(maskPixels, i)); });
    std::vector<KeyPointTupleObject> result;
    for (size_t i = 0; i < keypoints.size(); i++)
        result.push_back(toObject(keypoints[i]));
    return result;
}

std::pair<KeyPointsObject, OptionalArrayObject> compute(const Detector& self, const ImageObject& image,
                                                        const KeyPointsObject& keypoints,
                                                        const OptionalArrayObject& output)
{
    checkOutput(output);
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object);
    KeyPoints computed = toKeyPoints(keypoints.object);
    cv::Mat descriptors;
    withoutGil([&] { library->compute(pixels.mat, computed.points, descriptors); });
    return std::make_pair(toObject(std::move(computed)), toObject(descriptors));
}

std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>>
computeImages(const Detector& self, const ImagesObject& images, const KeyPointListsObject& keypoints,
              const OptionalArrayObject& output)
{
    checkOutput(output);
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object);
    std::vector<KeyPoints> computed = toKeyPointLists(keypoints.object, pixels.size());
    std::vector<cv::Mat> descriptors(pixels.size());
    forEachImage(pixels.size(),
                 [&](size_t i) { library->compute(pixels[i].mat, computed[i].points, descriptors[i]); });
    std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>> result;
    for (size_t i = 0; i < pixels.size(); i++)
    {
        result.first.push_back(toObject(std::move(computed[i])));
        result.second.push_back(toObject(descriptors[i]));
    }
    return result;
}

std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndCompute(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask,
                 const OptionalArrayObject& output, const BoolObject& useProvidedKeypoints)
{
    checkOutput(output);
    if (toNumber(useProvidedKeypoints, "useProvidedKeypoints"))
        CV_Error(cv::Error::StsBadArg,
                 "useProvidedKeypoints must be False, got True: the method compute takes keypoints");
    importKeyPoint();
    const Features found(self.share(), image, mask);
    return std::make_pair(toObject(found.keypoints), toObject(found.descriptors));
}

std::pair<ArrayObject, ArrayObject> detectAndComputeArrays(const Detector& self,
                                                           const OptionalArrayObject& image,
                                                           const OptionalArrayObject& mask)
{
    Features found(self.share(), image, mask);
    if (found.descriptors.empty())
        found.descriptors.create(0, self.share()->descriptorSize(), CV_8UC1);
    const ArrayObject points = {toArray(std::move(found.keypoints))}, rows = {toArray(found.descriptors)};
    return std::make_pair(points, rows);
}

FeatureBatchObject detectAndComputeBatch(const Detector& self, const ImageListObject& images,
                                         const MasksObject& masks)
{
    const cv::Ptr<Library> library = self.share();
    const std::vector<Pixels> pixels = toImages(images.object),
                              maskPixels = toMasks(masks.object, pixels.size());
    std::vector<std::vector<cv::KeyPoint>> keypoints(pixels.size());
    std::vector<cv::Mat> descriptors(pixels.size());
    forEachImage(
        pixels.size(), [&](size_t i)
        { library->detectAndCompute(pixels[i].mat, maskOf(maskPixels, i), keypoints[i], descriptors[i]); });
    std::vector<size_t> counts;
    for (const std::vector<cv::KeyPoint>& ofImage : keypoints)
        counts.push_back(ofImage.size());
    FeatureArrays arrays(counts, library->descriptorSize());
    whileOthersRun(
        [&]
        {
            for (size_t i = 0; i < keypoints.size(); i++)
            {
                arrays.add(keypoints[i], descriptors[i]);
                // Their memory is needed no more, and there may be many images.
                std::vector<cv::KeyPoint>().swap(keypoints[i]);
                descriptors[i].release();
            }
        });
    return {arrays.toPython()};
}

ArrayTupleObject buildPyramid(const Detector& self, const OptionalArrayObject& image)
{
    const cv::Ptr<Library> library = self.share();
    const Pixels pixels = toImage(image.object);
    std::vector<cv::Mat> levels;
    withoutGil([&] { library->buildPyramid(pixels.mat, levels); });
    py::tuple arrays(levels.size());
    for (size_t i = 0; i < levels.size(); i++)
        arrays[i] = toArray(levels[i]);
    return {arrays};
}

void releaseMemory(const Detector& self)
{
    const cv::Ptr<Library> library = self.share();
    withoutGil([&] { library->releaseMemory(); });
}

}  // namespace aqorb_python
