// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PARAMETERS_HPP
#define OPENCV_AQORB_PARAMETERS_HPP

#include <opencv2/aqorb.hpp>

namespace cv
{
namespace aqorb
{

//! The number behind an enumeration. It need not be an enumerator, because a caller in Python can pass any number.
template <typename Enumeration> int numberOf(const Enumeration& value)
{
    // Reading a value that is not an enumerator would be undefined behaviour, so the bytes are copied.
    int number = 0;
    static_assert(sizeof(value) == sizeof(number), "the enumeration must be of the size of an int");
    std::memcpy(&number, &value, sizeof(number));
    return number;
}

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
    int selectionType;  //!< of AdaptiveQuadtreeORB::SelectionType
    double strengthWeight, rankRadius;
    double octaveSuppression;
    bool subPixel;

    //! The distance that octaveSuppression stands for.
    double octaveSuppressionInUse() const;

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
