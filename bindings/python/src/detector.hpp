// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The detector of the Python package, and its methods for images.

#ifndef AQORB_PYTHON_DETECTOR_HPP
#define AQORB_PYTHON_DETECTOR_HPP

#include "arguments.hpp"

#include <opencv2/aqorb.hpp>

#include <utility>
#include <vector>

namespace aqorb_python
{

//! The library's detector, which several threads of Python may share. All methods are called with the GIL.
class Detector
{
public:
    typedef cv::aqorb::AdaptiveQuadtreeORB Library;

    explicit Detector(const cv::Ptr<Library>& library_) : library(library_) {}

    //! For calls without the GIL. No later change of a parameter reaches what this returns.
    cv::Ptr<Library> share() const { return library; }
    const Library& get() const { return *library; }
    //! For setters. The library forbids them during other calls, so that these keep the detector they have.
    Library& change();

private:
    cv::Ptr<Library> library;
};

KeyPointTupleObject detect(const Detector& self, const ImageObject& image, const OptionalArrayObject& mask);
std::vector<KeyPointTupleObject> detectImages(const Detector& self, const ImagesObject& images,
                                              const MasksObject& masks);
std::pair<KeyPointsObject, OptionalArrayObject> compute(const Detector& self, const ImageObject& image,
                                                        const KeyPointsObject& keypoints);
std::pair<std::vector<KeyPointsObject>, std::vector<OptionalArrayObject>>
computeImages(const Detector& self, const ImagesObject& images, const KeyPointListsObject& keypoints);
std::pair<KeyPointTupleObject, OptionalArrayObject>
detectAndCompute(const Detector& self, const OptionalArrayObject& image, const OptionalArrayObject& mask);
std::pair<ArrayObject, ArrayObject> detectAndComputeArrays(const Detector& self,
                                                           const OptionalArrayObject& image,
                                                           const OptionalArrayObject& mask);
ArrayTupleObject buildPyramid(const Detector& self, const OptionalArrayObject& image);
void releaseMemory(const Detector& self);

}  // namespace aqorb_python

#endif
