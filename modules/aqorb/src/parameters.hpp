// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PARAMETERS_HPP
#define OPENCV_AQORB_PARAMETERS_HPP

#include <opencv2/aqorb/features.hpp>

namespace cv
{
namespace aqorb
{

//! The number behind a score type. It need not be an enumerator, because a caller in Python can pass any number.
int numberOf(const ORB::ScoreType& scoreType);

//! The parameters of AdaptiveQuadtreeORB, as documented there.
struct Parameters
{
    Parameters();

    int nfeatures;
    double scaleFactor;
    int nlevels, edgeThreshold, firstLevel, WTA_K;
    int scoreType;  //!< of ORB::ScoreType
    int patchSize, fastThreshold;

    bool adaptiveThreshold;
    double minThresholdRatio;
    int cellSize, maxDepth;
    double octaveSuppression;
    bool subPixel;

    //! Throws if a value is invalid whatever the others are.
    void check() const;
    //! Throws if values are invalid in combination, for a pyramid of so many levels.
    void checkTogether(int levelsInUse) const;

    void write(FileStorage& fs) const;
    //! A parameter whose key is missing keeps its value. Throws for an invalid value and then changes nothing.
    void read(const FileNode& node);
};

}  // namespace aqorb
}  // namespace cv

#endif
