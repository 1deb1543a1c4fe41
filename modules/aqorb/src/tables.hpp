// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TABLES_HPP
#define OPENCV_AQORB_TABLES_HPP

#include "descriptor.hpp"
#include "measures.hpp"
#include "parameters.hpp"

namespace cv
{
namespace aqorb
{

//! What follows from the parameters alone.
struct Tables
{
    explicit Tables(const Parameters& parameters)
        : patch(circularPatch(parameters.patchSize)),
          strengthPatch(patch.halfWidths, std::max(1, parameters.patchSize / 2 / 5)),
          tests(descriptorPattern(parameters.patchSize, parameters.WTA_K), parameters.WTA_K)
    {
    }

    OrientationPatch patch;
    OrientationPatch strengthPatch;  //!< the same with fewer rows
    DescriptorTests tests;
};

}  // namespace aqorb
}  // namespace cv

#endif
