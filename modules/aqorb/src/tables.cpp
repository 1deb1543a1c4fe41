// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "tables.hpp"

#include "plan.hpp"

namespace cv
{
namespace aqorb
{

using namespace stages;

Tables::Tables(const Parameters& parameters)
    : patch(circularPatch(parameters.patchSize)),
      strengthPatch(patch.halfWidths, std::max(1, parameters.patchSize / 2 / 5)),
      tests(descriptorPattern(parameters.patchSize, parameters.WTA_K), parameters.WTA_K)
{
    // Other values have no quotas. Detection throws for them.
    if (parameters.nlevels == 1 || parameters.scaleFactor > 1)
        quotas = levelQuotas(parameters.nfeatures, parameters.scaleFactor, parameters.nlevels);
}

}  // namespace aqorb
}  // namespace cv
