// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../../common/program.hpp"
#include "../method.hpp"

#include <opencv2/aqorb.hpp>

#include <map>

using cv::aqorb::AdaptiveQuadtreeORB;

void applySettings(AdaptiveQuadtreeORB& detector, const std::string& settings)
{
    static const std::map<std::string, void (*)(AdaptiveQuadtreeORB&, double)> setters = {
        {"cell", [](AdaptiveQuadtreeORB& d, double v) { d.setCellSize(int(v)); }},
        {"depth", [](AdaptiveQuadtreeORB& d, double v) { d.setMaxDepth(int(v)); }},
        {"edge", [](AdaptiveQuadtreeORB& d, double v) { d.setEdgeThreshold(int(v)); }},
        {"fast", [](AdaptiveQuadtreeORB& d, double v) { d.setFastThreshold(int(v)); }},
        {"octave", [](AdaptiveQuadtreeORB& d, double v) { d.setOctaveSuppression(v); }},
        {"radius", [](AdaptiveQuadtreeORB& d, double v) { d.setRankRadius(v); }},
        {"ratio", [](AdaptiveQuadtreeORB& d, double v) { d.setMinThresholdRatio(v); }},
        {"strength", [](AdaptiveQuadtreeORB& d, double v) { d.setStrengthWeight(v); }},
        {"subpixel", [](AdaptiveQuadtreeORB& d, double v) { d.setSubPixel(v != 0); }},
        {"threshold", [](AdaptiveQuadtreeORB& d, double v) { d.setAdaptiveThreshold(v != 0); }},
    };
    for (const std::string& setting : tools::splitList(settings, ':'))
    {
        const size_t equals = std::min(setting.find('='), setting.size());
        const std::string key = setting.substr(0, equals), value = setting.substr(equals);
        const auto setter = setters.find(key);
        if (setting == "score=fast")
            detector.setScoreType(cv::ORB::FAST_SCORE);
        else if (setting == "selection=balanced")
            detector.setSelectionType(AdaptiveQuadtreeORB::BALANCED_SELECTION);
        else if (setting == "selection=ranked")
            detector.setSelectionType(AdaptiveQuadtreeORB::RANKED_SELECTION);
        else if (setter == setters.end() || value.size() < 2)
            CV_Error(cv::Error::StsBadArg, setting + ": no setting of aqorb");
        else
            setter->second(detector, std::stod(value.substr(1)));
    }
}

// The detector of this module, as shipped or with some of its settings changed.
cv::Ptr<Method> makeAqorb(const std::string& settings)
{
    const auto create = [settings](int n)
    {
        const cv::Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(n);
        applySettings(*detector, settings);
        return detector;
    };
    create(1);  // raises an exception for a bad setting before anything is measured
    return cv::makePtr<Feature2DMethod>(create);
}
