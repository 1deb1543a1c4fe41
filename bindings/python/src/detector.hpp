// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The detector of the Python package with its methods, and the module's functions.

#ifndef AQORB_PYTHON_DETECTOR_HPP
#define AQORB_PYTHON_DETECTOR_HPP

#include "arguments.hpp"
#include "shared.hpp"

#include <opencv2/aqorb.hpp>

#include <string>
#include <utility>
#include <vector>

namespace aqorb_python
{

//! The library's detector, which several threads of Python may share.
class Detector
{
public:
    typedef cv::aqorb::AdaptiveQuadtreeORB Library;

    explicit Detector(const cv::Ptr<Library>& library_) : library(library_) {}

    //! For calls, which keep the parameters that they begin with.
    cv::Ptr<Library> share() const { return library.share(); }
    //! For setters: calls change(detector), with a copy if a call is under way.
    template <typename Change> void change(const Change& change) { library.change(&copyOf, change); }

private:
    static cv::Ptr<Library> copyOf(const Library& other);

    Shared<Library> library;
};

KeyPointTupleObject detect(const Detector& self, const ImageObject& image, const OptionalArrayObject& mask);
std::vector<KeyPointTupleObject> detectImages(const Detector& self, const ImagesObject& images,
                                              const MasksObject& masks);
std::pair<KeyPointsObject, OptionalArrayObject> compute(const Detector& self, const ImageObject& image,
                                                        const KeyPointsObject& keypoints,
                                                        const OptionalArrayObject& output);
std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>>
computeImages(const Detector& self, const ImagesObject& images, const KeyPointListsObject& keypoints,
              const OptionalArrayObject& output);
std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndCompute(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask,
                 const OptionalArrayObject& output, const BoolObject& useProvidedKeypoints);
std::pair<ArrayObject, ArrayObject> detectAndComputeArrays(const Detector& self,
                                                           const OptionalArrayObject& image,
                                                           const OptionalArrayObject& mask);
FeatureBatchObject detectAndComputeBatch(const Detector& self, const ImageListObject& images,
                                         const MasksObject& masks);
ArrayTupleObject buildPyramid(const Detector& self, const OptionalArrayObject& image);
void releaseMemory(const Detector& self);

// Its parameters in files and in cv2's storages.

//! All parameters as the text of a file of the name, by which a detector is copied and pickled, too.
std::string toText(const Detector& self, const std::string& name = ".yml");
Detector fromText(const std::string& text);

void writeFile(const Detector& self, const FileNameObject& fileName);
void readFile(Detector& self, const FileNameObject& fileName);

void writeStorage(const Detector& self, const FileStorageObject& storage, const std::string& name);
void readNode(Detector& self, const FileNodeObject& node);

// The functions of the module that need no detector.

KeyPointsObject retainUniform(const KeyPointsObject& keypoints, const SizeObject& imageSize,
                              const IntObject& npoints);
double distributionUniformity(const KeyPointsObject& keypoints, const SizeObject& imageSize);
double distributionOccupancy(const KeyPointsObject& keypoints, const SizeObject& imageSize,
                             const SizeObject& grid);
double adaptiveFastThreshold(const OptionalArrayObject& image, const OptionalArrayObject& mask);
ArrayObject keypointsToArray(const KeyPointsObject& keypoints);
KeyPointTupleObject keypointsFromArray(const KeyPointsObject& keypoints);

}  // namespace aqorb_python

#endif
