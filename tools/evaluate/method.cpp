// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "method.hpp"

#include <opencv2/imgproc.hpp>

#include <algorithm>

cv::Mat grayOf(const cv::Mat& image)
{
    cv::Mat gray = image;
    if (image.channels() > 1)
        cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
    return gray;
}

Features Feature2DMethod::compute(const cv::Mat& image, int n)
{
    if (n != detectorN)
    {
        detector = create(n);
        detectorN = n;
    }
    Features features;
    detector->detectAndCompute(image, cv::noArray(), features.keypoints, features.descriptors);
    return features;
}

namespace
{

// The paper's column C. Where the paper states no value, as for cells and border, the default stays.
const char* const PAPER_SETTINGS = "selection=balanced:octave=0:subpixel=0";

struct NamedMethod
{
    const char* name;
    const char* title;
    std::function<cv::Ptr<Method>(const std::string& superPoint)> make;
};

const std::vector<NamedMethod>& namedMethods()
{
    typedef const std::string& Model;
    static const std::vector<NamedMethod> methods = {
        {"orb", "cv::ORB (A)", [](Model) { return makeOrb(); }},
        {"orb_slam", "ORB_SLAM's quadtree (B)", [](Model) { return makeOrbSlam(); }},
        {"paper", "ours, the paper's settings (C)", [](Model) { return makeAqorb(PAPER_SETTINGS); }},
        {"aqorb", "ours as shipped", [](Model) { return makeAqorb(""); }},
        {"sift", "SIFT", [](Model) { return makeSift(); }},
        {"surf", "SURF (dlib)", [](Model) { return makeSurf(); }},
        {"brisk", "BRISK", [](Model) { return makeBrisk(); }},
        {"akaze", "AKAZE", [](Model) { return makeAkaze(); }},
        {"ssc", "FAST + SSC + ORB descriptors", [](Model) { return makeSsc(); }},
        {"superpoint", "SuperPoint", [](Model model) { return makeSuperPoint(model); }},
        {"figure2", "Figure 2 to the letter", [](Model) { return makeFigure2(); }},
    };
    return methods;
}

}  // namespace

std::vector<std::string> allMethods()
{
    std::vector<std::string> names;
    for (const NamedMethod& method : namedMethods())
        if (std::string(method.name) != "figure2")
            names.push_back(method.name);
    return names;
}

std::vector<Ablation> ablationMethods()
{
    return {
        {"aqorb", "nothing"},
        {"aqorb:threshold=0", "fixed FAST threshold 20"},
        {"aqorb:ratio=1", "no lower threshold in empty cells"},
        {"aqorb:depth=0", "no quadtree: score alone"},
        {"aqorb:selection=balanced", "the balanced selection, as version 0.1"},
        {"aqorb:strength=0", "no strength: rank alone"},
        {"aqorb:radius=0", "no rank: strength alone"},
        {"aqorb:depth=6", "depth 6 on all levels"},
        {"aqorb:depth=15", "no depth limit: leaves as small as the selection takes"},
        {"aqorb:octave=0", "no octave suppression"},
        {"aqorb:subpixel=0", "whole pixels"},
        {"paper", "both: the paper's settings"},
        {"figure2", "both, and Figure 2 to the letter: no balanced selection"},
        {"aqorb:edge=31", "border 31"},
        {"aqorb:score=fast", "FAST score instead of Harris"},
    };
}

cv::Ptr<Method> makeMethod(const std::string& name, const std::string& superPoint)
{
    cv::Ptr<Method> method;
    for (const NamedMethod& named : namedMethods())
    {
        if (name != named.name)
            continue;
        method = named.make(superPoint);
        if (method->title.empty())
            method->title = named.title;
    }
    const size_t colon = std::min(name.find(':'), name.size());
    const std::string kind = name.substr(0, colon),
                      settings = colon < name.size() ? name.substr(colon + 1) : "";
    if (kind == "slam" || (kind == "aqorb" && !settings.empty()))
    {
        method = kind == "slam" ? makeSlam(settings) : makeAqorb(settings);
        method->title = name;
    }
    if (!method)
        CV_Error(cv::Error::StsBadArg, name + ": unknown method");
    method->name = name;
    return method;
}
