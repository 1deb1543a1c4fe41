# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
# SPDX-License-Identifier: Apache-2.0

# The functions of OpenCV and of the module that the page would call, for platforms/js/build_js.py --config.
white_list = makeWhiteList([
    {'': ['add', 'randn', 'setRNGSeed'], 'Algorithm': []},
    {'': ['GaussianBlur', 'cvtColor', 'getPerspectiveTransform', 'getRotationMatrix2D', 'resize', 'warpAffine',
          'warpPerspective']},
    {'Feature2D': ['detectAndCompute'],
     'ORB': ['create', 'setEdgeThreshold', 'setFastThreshold', 'setFirstLevel', 'setMaxFeatures', 'setNLevels',
             'setPatchSize', 'setScaleFactor', 'setScoreType', 'setWTA_K'],
     'DescriptorMatcher': ['match'], 'BFMatcher': ['create']},
    {'': ['findHomography']},
    {'': ['aqorb_distributionOccupancy', 'aqorb_distributionUniformity', 'aqorb_matchArrays'],
     'aqorb_AdaptiveQuadtreeORB': ['create', 'setAdaptiveThreshold', 'setCellSize', 'setMaxDepth',
                                   'setMinThresholdRatio', 'setOctaveSuppression', 'setRankRadius', 'setSelectionType',
                                   'setStrengthWeight', 'setSubPixel']},
])
