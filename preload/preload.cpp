// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// cv::ORB::create for unchanged programs: preloaded, this definition replaces OpenCV's. batch_distance.cpp replaces
// cv::batchDistance. Environment variables set the properties that cv::ORB does not have, see README.md in this folder.

#include "preload.hpp"

#include "detector/parameter_table.hpp"

#include <opencv2/aqorb.hpp>

#include <dlfcn.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <locale>
#include <mutex>
#include <set>
#include <sstream>
#include <string>

namespace
{

using cv::aqorb::AdaptiveQuadtreeORB;

// The values that a variable of a type may have.
struct Accepted
{
    static const char* of(int) { return "a whole number"; }
    static const char* of(double) { return "a number"; }
    static const char* of(bool) { return "0 or 1"; }
    static const char* of(AdaptiveQuadtreeORB::SelectionType) { return "ranked or quadtree"; }
};

// Reads an enumeration for readVariable.
std::istream& operator>>(std::istream& stream, AdaptiveQuadtreeORB::SelectionType& value)
{
    std::string name;
    stream >> name;
    if (name == "ranked")
        value = AdaptiveQuadtreeORB::RANKED_SELECTION;
    else if (name == "quadtree")
        value = AdaptiveQuadtreeORB::QUADTREE_SELECTION;
    else
        stream.setstate(std::ios::failbit);
    return stream;
}

// Reads an environment variable. Returns false if it is empty or not set.
template <typename T> bool readVariable(const char* name, T& value)
{
    const char* text = std::getenv(name);
    if (!text || !*text)
        return false;
    std::istringstream stream(text);
    stream.imbue(std::locale::classic());  // the program's locale may have a decimal comma
    if (!(stream >> value) || !(stream >> std::ws).eof())
        CV_Error_(cv::Error::StsBadArg, ("%s must be %s, got \"%s\"", name, Accepted::of(value), text));
    return true;
}

// Name of a property's variable: AQORB_SUB_PIXEL for SubPixel.
std::string variableOf(const std::string& property)
{
    std::string name = "AQORB";
    for (const char c : property)
        name += c >= 'A' && c <= 'Z' ? std::string("_") + c : std::string(1, char(c - 'a' + 'A'));
    return name;
}

template <typename Class, typename T>
void setFromVariable(AdaptiveQuadtreeORB& orb, const char* property, void (Class::*setter)(T))
{
    const std::string name = variableOf(property);
    T value = T();
    if (!readVariable(name.c_str(), value))
        return;
    try
    {
        (orb.*setter)(value);
    }
    catch (const cv::Exception& e)
    {
        CV_Error_(e.code, ("%s: %s", name.c_str(), e.err.c_str()));
    }
}

// Sets the properties that cv::ORB does not have, and edgeThreshold.
void setFromEnvironment(AdaptiveQuadtreeORB& orb)
{
    setFromVariable(orb, "EdgeThreshold", &AdaptiveQuadtreeORB::setEdgeThreshold);
#define AQORB_SET(property, ...) setFromVariable(orb, #property, &AdaptiveQuadtreeORB::set##property);
    AQORB_OWN_PARAMETERS(AQORB_SET)
#undef AQORB_SET
}

// Says that cv::ORB::create gives our detector, and which variables beginning with AQORB_ are unknown.
void notice(const AdaptiveQuadtreeORB& orb)
{
    std::fprintf(stderr, "aqorb: cv::ORB::create gives AdaptiveQuadtreeORB (edgeThreshold %d)\n",
                 orb.getEdgeThreshold());
    std::set<std::string> known = {"AQORB_DISABLE", "AQORB_DISABLE_MATCHER", "AQORB_EDGE_THRESHOLD",
                                   "AQORB_VERBOSE"};
#define AQORB_KNOW(property, ...) known.insert(variableOf(#property));
    AQORB_OWN_PARAMETERS(AQORB_KNOW)
#undef AQORB_KNOW
    for (char** variable = environ; *variable; variable++)
    {
        const std::string text = *variable, name = text.substr(0, text.find('='));
        if (name.compare(0, 6, "AQORB_") == 0 && known.count(name) == 0)
            std::fprintf(stderr, "aqorb: %s is no variable of this library\n", name.c_str());
    }
}

}  // namespace

namespace aqorb_preload
{

bool isVariableOn(const char* name)
{
    bool on = false;
    return readVariable(name, on) && on;
}

void* originalOf(void* ours, const char* name)
{
    Dl_info here;
    void* const symbol = dladdr(ours, &here) && here.dli_sname ? dlsym(RTLD_NEXT, here.dli_sname) : nullptr;
    if (!symbol)
        CV_Error_(cv::Error::StsNotImplemented, ("OpenCV's %s was not found", name));
    return symbol;
}

}  // namespace aqorb_preload

namespace cv
{

Ptr<ORB> ORB::create(int nfeatures, float scaleFactor, int nlevels, int edgeThreshold, int firstLevel,
                     int WTA_K, ORB::ScoreType scoreType, int patchSize, int fastThreshold)
{
    if (aqorb_preload::isVariableOn("AQORB_DISABLE"))
        return aqorb_preload::originalOf(&ORB::create, "cv::ORB::create")(
            nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K, scoreType, patchSize,
            fastThreshold);

    const Ptr<AdaptiveQuadtreeORB> orb =
        AdaptiveQuadtreeORB::create(nfeatures, scaleFactor, nlevels, edgeThreshold, firstLevel, WTA_K,
                                    scoreType, patchSize, fastThreshold);
    setFromEnvironment(*orb);
    if (aqorb_preload::isVariableOn("AQORB_VERBOSE"))
    {  // Once per process, at the first call: LD_PRELOAD reaches every program that a shell starts.
        static std::once_flag once;
        std::call_once(once, [&] { notice(*orb); });
    }
    return orb;
}

}  // namespace cv
