// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "generate.hpp"
#include "parameters.hpp"

#include <cmath>
#include <tuple>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace fuzz
{

void require(bool condition, const std::string& what)
{
    if (!condition)
        throw Problem{what};
}

bool OrbParameters::isBad() const
{
    return nfeatures < 0 || !std::isfinite(scaleFactor) || scaleFactor <= 0 || nlevels < 1 ||
           edgeThreshold < 0 || firstLevel < 0 || WTA_K < 2 || WTA_K > 4 || scoreType < 0 || scoreType > 1 ||
           patchSize < 2 || nlevels > 65536 || patchSize > 16384;
}

bool OrbParameters::clash() const
{
    return (nlevels > 1 && scaleFactor <= 1) || firstLevel >= nlevels;
}

double OrbParameters::scale(int level) const
{
    return std::pow(scaleFactor, double(level - firstLevel));
}

bool OrbParameters::hasTooLargeLevel(Size image, int level) const
{
    return !(std::max(image.width, image.height) / scale(level) < (1 << 20) - 1);
}

//! Whether an exception says which argument it is about.
static bool isNamed(const cv::Exception& e)
{
#define AQORB_NAME(property, type, name, key, ...) #name, #key,
    const char* names[] = {
        AQORB_PARAMETERS(AQORB_NAME) "image", "mask", "keypoints", "imageSize", "npoints", "grid"};
#undef AQORB_NAME
    for (const char* name : names)
    {
        if (e.err.find(name) != std::string::npos)
            return true;
    }
    return false;
}

//! Whether an exception is as documented: it names the argument and says what is accepted.
static bool isDocumented(const cv::Exception& e)
{
    return isNamed(e) && e.err.find(" must ") != std::string::npos &&
           (e.code == Error::StsBadArg || e.code == Error::StsOutOfRange || e.code == Error::StsParseError);
}

void Detector::make(const OrbParameters& p)
{
    orb = AdaptiveQuadtreeORB::create(p.nfeatures, float(p.scaleFactor), p.nlevels, p.edgeThreshold,
                                      p.firstLevel, p.WTA_K, static_cast<ORB::ScoreType>(p.scoreType),
                                      p.patchSize, p.fastThreshold);
}

bool Detector::attempt(const char* name, Expectation expected, const std::function<void()>& function)
{
    try
    {
        function();
    }
    catch (const cv::Exception& e)
    {
        if (expected == GOOD || !isDocumented(e))
            throw Problem{std::string(name) + ": " + e.what()};
        return false;
    }
    catch (const std::exception& e)
    {
        throw Problem{std::string(name) + ": " + e.what()};
    }
    if (expected == BAD)
        throw Problem{std::string(name) + " accepted a bad argument"};
    return true;
}

void Detector::create(FuzzedDataProvider& data)
{
    OrbParameters wanted;
    if (data.ConsumeBool())
    {
        wanted.nfeatures = number(data, 0, 2000);
        wanted.scaleFactor = float(real(data, 1, 3));
        wanted.nlevels = number(data, 1, 12);
        wanted.edgeThreshold = number(data, 0, 40);
        wanted.firstLevel = number(data, 0, 2);
        wanted.WTA_K = number(data, 2, 4);
        wanted.scoreType = number(data, 0, 1);
        wanted.patchSize = number(data, 2, 80);
        wanted.fastThreshold = number(data, 0, 60);
    }
    if (attempt("create", expect(wanted.isBad() || wanted.clash()), [&] { make(wanted); }))
        parameters = wanted;
    else if (!orb)
        make(parameters);
}

void Detector::setOrbParameter(FuzzedDataProvider& data)
{
    typedef OrbParameters P;
    static const struct
    {
        void (*draw)(FuzzedDataProvider& data, P& p);
        void (*set)(ORB& detector, const P& p);
    } SETTERS[] = {{[](auto& d, P& p) { p.nfeatures = number(d, 0, 2000); },
                    [](ORB& detector, const P& p) { detector.setMaxFeatures(p.nfeatures); }},
                   {[](auto& d, P& p) { p.scaleFactor = real(d, 1, 3); },
                    [](ORB& detector, const P& p) { detector.setScaleFactor(p.scaleFactor); }},
                   {[](auto& d, P& p) { p.nlevels = number(d, 1, 12); },
                    [](ORB& detector, const P& p) { detector.setNLevels(p.nlevels); }},
                   {[](auto& d, P& p) { p.edgeThreshold = number(d, 0, 40); },
                    [](ORB& detector, const P& p) { detector.setEdgeThreshold(p.edgeThreshold); }},
                   {[](auto& d, P& p) { p.firstLevel = number(d, 0, 3); },
                    [](ORB& detector, const P& p) { detector.setFirstLevel(p.firstLevel); }},
                   {[](auto& d, P& p) { p.WTA_K = number(d, 2, 4); },
                    [](ORB& detector, const P& p) { detector.setWTA_K(p.WTA_K); }},
                   {[](auto& d, P& p) { p.scoreType = number(d, 0, 1); }, [](ORB& detector, const P& p)
                    { detector.setScoreType(static_cast<ORB::ScoreType>(p.scoreType)); }},
                   {[](auto& d, P& p) { p.patchSize = number(d, 2, 80); },
                    [](ORB& detector, const P& p) { detector.setPatchSize(p.patchSize); }},
                   {[](auto& d, P& p) { p.fastThreshold = number(d, 0, 60); },
                    [](ORB& detector, const P& p) { detector.setFastThreshold(p.fastThreshold); }}};
    const auto& setter = SETTERS[data.ConsumeIntegralInRange(0, 8)];
    OrbParameters wanted = parameters;
    setter.draw(data, wanted);
    if (attempt("a setter", expect(wanted.isBad()), [&] { setter.set(*orb, wanted); }))
        parameters = wanted;
    requireParameters("a setter");
}

void Detector::setOurParameter(FuzzedDataProvider& data)
{
    int which = data.ConsumeIntegralInRange(0, 8);
#define AQORB_SET(property, type, name, key, byDefault, range, text)                                \
    if (which-- == 0)                                                                               \
    {                                                                                               \
        const double value =                                                                        \
            std::is_same<type, double>::value ? real(data, -1, 20) : double(number(data, -1, 100)); \
        attempt("set" #property, expect(!range.has(value)),                                         \
                [&] { orb->set##property(static_cast<type>(static_cast<Stored<type>>(value))); });  \
    }
    using namespace cv::aqorb;
    AQORB_OWN_PARAMETERS(AQORB_SET)
#undef AQORB_SET
}

OrbParameters Detector::current() const
{
    OrbParameters now;
    now.nfeatures = orb->getMaxFeatures();
    now.scaleFactor = orb->getScaleFactor();
    now.nlevels = orb->getNLevels();
    now.edgeThreshold = orb->getEdgeThreshold();
    now.firstLevel = orb->getFirstLevel();
    now.WTA_K = orb->getWTA_K();
    now.scoreType = orb->getScoreType();
    now.patchSize = orb->getPatchSize();
    now.fastThreshold = orb->getFastThreshold();
    return now;
}

void Detector::requireParameters(const char* after) const
{
    const auto all = [](const OrbParameters& p)
    {
        return std::make_tuple(p.nfeatures, p.scaleFactor, p.nlevels, p.edgeThreshold, p.firstLevel, p.WTA_K,
                               p.scoreType, p.patchSize, p.fastThreshold);
    };
    require(all(current()) == all(parameters), std::string(after) + " left other parameters");
}

//! Writes a storage with fields of any kind, and reads it.
void Detector::readStorage(FuzzedDataProvider& data)
{
#define AQORB_KEY(property, type, name, key, ...) #key,
    static const char* const KEYS[] = {AQORB_PARAMETERS(AQORB_KEY)};
#undef AQORB_KEY
    const int count = int(sizeof(KEYS) / sizeof(KEYS[0]));
    const char* names[] = {"memory.yml", "memory.xml", "memory.json"};
    FileStorage out(data.PickValueInArray(names), FileStorage::WRITE | FileStorage::MEMORY);
    out << "detector"
        << "{";
    const bool whole = data.ConsumeBool();
    if (whole)
        orb->write(out);
    std::vector<bool> written(count, whole);
    for (int i = data.ConsumeIntegralInRange(0, 6); i > 0; i--)
    {
        const int key = data.ConsumeIntegralInRange(0, count - 1), kind = data.ConsumeIntegralInRange(0, 7);
        const int wholeNumber = number(data, 0, 30);
        const double realNumber = real(data, 0, 10);
        if (written[key])
            continue;
        written[key] = true;
        out << KEYS[key];
        if (kind == 0)
            out << "text";
        else if (kind == 1)
            out << "[" << wholeNumber << realNumber << "]";
        else if (kind == 2)
            out << "{"
                << "nfeatures" << wholeNumber << "}";
        else if (kind < 5)
            out << realNumber;
        else
            out << wholeNumber;
    }
    out << "}";
    const std::string text = out.releaseAndGetString();
    FileStorage in(text, FileStorage::READ | FileStorage::MEMORY);
    const FileNode node = data.ConsumeBool() ? in["detector"] : in.root();
    attempt("read", UNKNOWN, [&] { orb->read(node); });
    parameters = current();
    require(!parameters.isBad(), "read left a bad parameter");
}

}  // namespace fuzz
