// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_PARAMETER_TABLE_HPP
#define OPENCV_AQORB_PARAMETER_TABLE_HPP

// Table of all parameters of AdaptiveQuadtreeORB. It generates the checks, setters, getters, read, write, tests and the
// Python classes. Each row is
//
//   X(property, type, name, key, default, range, text)
//
// property  as in set<property> and get<property>
// type      of the property, named as in namespace cv::aqorb
// name      as an argument of create and in messages
// key       in a file
// range     a ValidRange of parameters.hpp
// text      description for Python. CMake reads it, too: no quotes
//
// The order of the rows is their order in a file.

// clang-format off

//! Parameters of cv::ORB, in the order of create's arguments.
#define AQORB_PARAMETERS_OF_ORB(X) \
    X(MaxFeatures, int, nfeatures, nfeatures, 500, atLeast(0), \
      "the number of keypoints to find") \
    X(ScaleFactor, double, scaleFactor, scaleFactor, 1.2f, positive(), \
      "the ratio of the sizes of two neighbouring levels of the pyramid") \
    X(NLevels, int, nlevels, nlevels, 8, between(1, 65536), \
      "the number of levels of the pyramid") \
    X(EdgeThreshold, int, edgeThreshold, edgeThreshold, 16, atLeast(0), \
      "the width, in pixels of each level, of the border without keypoints") \
    X(FirstLevel, int, firstLevel, firstLevel, 0, atLeast(0), \
      "the level of the pyramid that is the image itself (lower levels are larger)") \
    X(WTA_K, int, WTA_K, wta_k, 2, between(2, 4), \
      "the number of points compared for each element of a descriptor, 2, 3 or 4") \
    X(ScoreType, ORB::ScoreType, scoreType, scoreType, 0, oneOf("HARRIS_SCORE (0) or FAST_SCORE (1)"), \
      "the score in a response, cv2.ORB_HARRIS_SCORE (0) or cv2.ORB_FAST_SCORE (1)") \
    X(PatchSize, int, patchSize, patchSize, 31, between(2, 16384), \
      "the diameter, in pixels of a level, of the patch of a descriptor") \
    X(FastThreshold, int, fastThreshold, fastThreshold, 20, any(), \
      "the scale of the adaptive FAST threshold, or the FAST threshold itself without AdaptiveThreshold")

#define AQORB_OWN_PARAMETERS(X) \
    X(AdaptiveThreshold, bool, adaptiveThreshold, adaptiveThreshold, true, any(), \
      "whether the FAST threshold adapts to the image") \
    X(MinThresholdRatio, double, minThresholdRatio, minThresholdRatio, 4, finiteAtLeast(1), \
      "the ratio of the FAST threshold to the lower threshold in cells without a corner, at least 1") \
    X(SelectionType, AdaptiveQuadtreeORB::SelectionType, selectionType, selectionType, 0, \
      oneOf("RANKED_SELECTION (0) or QUADTREE_SELECTION (1)"), \
      "the rule that selects corners, RANKED_SELECTION (0) or QUADTREE_SELECTION (1), the paper's") \
    X(StrengthWeight, double, strengthWeight, strengthWeight, 0.05, between(0, 1000), \
      "the weight of a corner's strength, 0 (an even distribution) to 1000 (strength alone)") \
    X(RankRadius, double, rankRadius, rankRadius, 1, between(0, 16), \
      "the radius of the disc that counts for a corner's rank, 0 to 16, in mean distances of features") \
    X(OctaveSuppression, double, octaveSuppression, octaveSuppression, -1, finiteAtLeast(0).orMinusOne(), \
      "the distance to keypoints of neighbouring levels, in pixels, or -1 for the selection type's default") \
    X(SubPixel, bool, subPixel, subPixel, true, any(), \
      "whether positions are refined to a fraction of a pixel")

// clang-format on

#define AQORB_PARAMETERS(X) AQORB_PARAMETERS_OF_ORB(X) AQORB_OWN_PARAMETERS(X)

#endif
