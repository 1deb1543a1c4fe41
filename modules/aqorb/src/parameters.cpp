// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "precomp.hpp"

#include "parameters.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

Parameters::Parameters()
    : nfeatures(500),
      scaleFactor(1.2f),
      nlevels(8),
      edgeThreshold(16),
      firstLevel(0),
      WTA_K(2),
      scoreType(ORB::HARRIS_SCORE),
      patchSize(31),
      fastThreshold(20),
      adaptiveThreshold(true),
      minThresholdRatio(4),
      cellSize(35),
      maxDepth(-1),
      selectionType(AdaptiveQuadtreeORB::RANKED_SELECTION),
      strengthWeight(0.15),
      rankRadius(1),
      octaveSuppression(-1),
      subPixel(true)
{
}

double Parameters::octaveSuppressionInUse() const
{
    if (octaveSuppression >= 0)
        return octaveSuppression;
    return selectionType == AdaptiveQuadtreeORB::BALANCED_SELECTION ? 0.5 : 2;
}

static void reject(const char* name, double value, const char* accepted)
{
    CV_Error_(Error::StsOutOfRange, ("%s: got %.17g; %s is accepted", name, value, accepted));
}

static bool isFinite(double value)
{
    return !cvIsNaN(value) && !cvIsInf(value);
}

void Parameters::check() const
{
    if (nfeatures < 0)
        reject("nfeatures", nfeatures, ">= 0");
    if (!isFinite(scaleFactor) || scaleFactor <= 0)
        reject("scaleFactor", scaleFactor, "a finite value > 0 (> 1 with more than one level)");
    if (nlevels < 1 || nlevels > 65536)
        reject("nlevels", nlevels, "1 to 65536");
    if (edgeThreshold < 0)
        reject("edgeThreshold", edgeThreshold, ">= 0");
    if (firstLevel < 0)
        reject("firstLevel", firstLevel, "0 <= firstLevel < nlevels");
    if (WTA_K < 2 || WTA_K > 4)
        reject("WTA_K", WTA_K, "2, 3 or 4");
    if (scoreType != ORB::HARRIS_SCORE && scoreType != ORB::FAST_SCORE)
        reject("scoreType", scoreType, "ORB::HARRIS_SCORE (0) or ORB::FAST_SCORE (1)");
    if (patchSize < 2 || patchSize > 16384)
        reject("patchSize", patchSize, "2 to 16384");
    if (!isFinite(minThresholdRatio) || minThresholdRatio < 1)
        reject("minThresholdRatio", minThresholdRatio, "a finite value >= 1");
    if (cellSize < 8)
        reject("cellSize", cellSize, ">= 8");
    if (maxDepth < -1 || maxDepth > stages::MAX_QUADTREE_DEPTH)
        reject("maxDepth", maxDepth, "-1 (by the number of features) or 0 to 15");
    if (selectionType != AdaptiveQuadtreeORB::RANKED_SELECTION &&
        selectionType != AdaptiveQuadtreeORB::BALANCED_SELECTION)
        reject("selectionType", selectionType, "RANKED_SELECTION (0) or BALANCED_SELECTION (1)");
    if (!(strengthWeight >= 0 && strengthWeight <= 1000))
        reject("strengthWeight", strengthWeight, "0 to 1000");
    if (!(rankRadius >= 0 && rankRadius <= 16))
        reject("rankRadius", rankRadius, "0 to 16");
    if (!isFinite(octaveSuppression) || (octaveSuppression < 0 && octaveSuppression != -1))
        reject("octaveSuppression", octaveSuppression, "a finite value >= 0, or -1 (by the selection),");
}

void Parameters::checkTogether(int levelsInUse) const
{
    if (levelsInUse > 1 && scaleFactor <= 1)
        reject("scaleFactor", scaleFactor, "> 1 with more than one level");
    if (firstLevel >= nlevels)
        CV_Error_(Error::StsOutOfRange,
                  ("firstLevel: got %d with nlevels %d; 0 <= firstLevel < nlevels is accepted", firstLevel,
                   nlevels));
}

// The first nine keys are those that cv::ORB writes in OpenCV 4.7 and later.
void Parameters::write(FileStorage& fs) const
{
    fs << "nfeatures" << nfeatures;
    fs << "scaleFactor" << scaleFactor;
    fs << "nlevels" << nlevels;
    fs << "edgeThreshold" << edgeThreshold;
    fs << "firstLevel" << firstLevel;
    fs << "wta_k" << WTA_K;
    fs << "scoreType" << scoreType;
    fs << "patchSize" << patchSize;
    fs << "fastThreshold" << fastThreshold;
    fs << "adaptiveThreshold" << int(adaptiveThreshold);
    fs << "minThresholdRatio" << minThresholdRatio;
    fs << "cellSize" << cellSize;
    fs << "maxDepth" << maxDepth;
    fs << "selectionType" << selectionType;
    fs << "strengthWeight" << strengthWeight;
    fs << "rankRadius" << rankRadius;
    fs << "octaveSuppression" << octaveSuppression;
    fs << "subPixel" << int(subPixel);
}

// FileStorage would read text as 0, and would round or wrap numbers that do not fit an int, all without an error.
static void readValue(const FileNode& node, const char* key, double& value)
{
    const FileNode found = node[key];
    if (found.empty())
        return;
    if (!found.isInt() && !found.isReal())
        CV_Error_(Error::StsParseError, ("%s: got no number; a number is accepted", key));
    value = double(found);
}

static void readValue(const FileNode& node, const char* key, int& value)
{
    double number = value;
    readValue(node, key, number);
    if (!(number >= INT_MIN && number <= INT_MAX) || number != std::floor(number))
        reject(key, number, "a whole number");
    value = int(number);
}

static void readValue(const FileNode& node, const char* key, bool& value)
{
    int number = value;
    readValue(node, key, number);
    if (number != 0 && number != 1)
        reject(key, number, "0 or 1");
    value = number != 0;
}

void Parameters::read(const FileNode& node)
{
    if (node.isNone())
        return;
    if (!node.isMap())
        CV_Error_(Error::StsParseError, ("node: got no map; a map of the parameters is accepted"));
    Parameters changed = *this;
    readValue(node, "nfeatures", changed.nfeatures);
    readValue(node, "scaleFactor", changed.scaleFactor);
    readValue(node, "nlevels", changed.nlevels);
    readValue(node, "edgeThreshold", changed.edgeThreshold);
    readValue(node, "firstLevel", changed.firstLevel);
    readValue(node, "wta_k", changed.WTA_K);
    readValue(node, "scoreType", changed.scoreType);
    readValue(node, "patchSize", changed.patchSize);
    readValue(node, "fastThreshold", changed.fastThreshold);
    readValue(node, "adaptiveThreshold", changed.adaptiveThreshold);
    readValue(node, "minThresholdRatio", changed.minThresholdRatio);
    readValue(node, "cellSize", changed.cellSize);
    readValue(node, "maxDepth", changed.maxDepth);
    readValue(node, "selectionType", changed.selectionType);
    readValue(node, "strengthWeight", changed.strengthWeight);
    readValue(node, "rankRadius", changed.rankRadius);
    readValue(node, "octaveSuppression", changed.octaveSuppression);
    readValue(node, "subPixel", changed.subPixel);
    changed.check();
    *this = changed;
}

}  // namespace aqorb
}  // namespace cv
