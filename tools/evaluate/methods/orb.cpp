// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

// Traditional ORB, the paper's column A.
cv::Ptr<Method> makeOrb()
{
    return cv::makePtr<Feature2DMethod>([](int n) { return cv::ORB::create(n); });
}
