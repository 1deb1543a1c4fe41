// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "generate.hpp"

#include <cmath>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace fuzz
{

void require(bool condition, const std::string& what)
{
    if (!condition)
        throw Problem{BAD_OUTPUT, what};
}

bool OrbParameters::isBad(bool limits) const
{
    return nfeatures < 0 || !std::isfinite(scaleFactor) || scaleFactor <= 0 || nlevels < 1 ||
           edgeThreshold < 0 || firstLevel < 0 || WTA_K < 2 || WTA_K > 4 || scoreType < 0 || scoreType > 1 ||
           patchSize < 2 || (limits && (nlevels > 65536 || patchSize > 16384));
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
    const char* names[] = {"nfeatures",     "scaleFactor",       "nlevels",
                           "edgeThreshold", "firstLevel",        "WTA_K",
                           "wta_k",         "scoreType",         "patchSize",
                           "fastThreshold", "adaptiveThreshold", "minThresholdRatio",
                           "cellSize",      "octaveSuppression", "subPixel",
                           "selectionType", "strengthWeight",    "rankRadius",
                           "image",         "maxDepth",          "mask",
                           "keypoints",     "imageSize",         "npoints",
                           "grid"};
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
    return isNamed(e) && e.err.find("accepted") != std::string::npos &&
           (e.code == Error::StsBadArg || e.code == Error::StsOutOfRange || e.code == Error::StsParseError);
}

void Detector::make(const OrbParameters& p)
{
    if (isOrb)
    {
        orb = ORB::create(p.nfeatures, float(p.scaleFactor), p.nlevels, p.edgeThreshold, p.firstLevel,
                          p.WTA_K, static_cast<ORB::ScoreType>(p.scoreType), p.patchSize, p.fastThreshold);
        return;
    }
    ours = AdaptiveQuadtreeORB::create(p.nfeatures, float(p.scaleFactor), p.nlevels, p.edgeThreshold,
                                       p.firstLevel, p.WTA_K, static_cast<ORB::ScoreType>(p.scoreType),
                                       p.patchSize, p.fastThreshold);
    orb = ours;
}

bool Detector::attempt(const char* name, Expectation expected, const std::function<void()>& function)
{
    try
    {
        function();
    }
    catch (const cv::Exception& e)
    {
        if (expected == GOOD || !(isOrb ? isNamed(e) : isDocumented(e)))
            throw Problem{BAD_EXCEPTION, std::string(name) + ": " + e.what()};
        rejections++;
        return false;
    }
    catch (const std::exception& e)
    {
        throw Problem{BAD_EXCEPTION, std::string(name) + ": " + e.what()};
    }
    if (expected == BAD)
        throw Problem{ACCEPTED, std::string(name) + " accepted a bad argument"};
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
    // cv::ORB checks its parameters only when it is used.
    if (attempt("create", isOrb ? UNKNOWN : expect(wanted.isBad(true)), [&] { make(wanted); }))
        parameters = wanted;
    else
        make(parameters);
}

void Detector::setOrbParameter(FuzzedDataProvider& data)
{
    OrbParameters wanted = parameters;
    std::function<void()> set;
    switch (data.ConsumeIntegralInRange(0, 8))
    {
    case 0:
        wanted.nfeatures = number(data, 0, 2000);
        set = [&] { orb->setMaxFeatures(wanted.nfeatures); };
        break;
    case 1:
        wanted.scaleFactor = real(data, 1, 3);
        set = [&] { orb->setScaleFactor(wanted.scaleFactor); };
        break;
    case 2:
        wanted.nlevels = number(data, 1, 12);
        set = [&] { orb->setNLevels(wanted.nlevels); };
        break;
    case 3:
        wanted.edgeThreshold = number(data, 0, 40);
        set = [&] { orb->setEdgeThreshold(wanted.edgeThreshold); };
        break;
    case 4:
        wanted.firstLevel = number(data, 0, 3);
        set = [&] { orb->setFirstLevel(wanted.firstLevel); };
        break;
    case 5:
        wanted.WTA_K = number(data, 2, 4);
        set = [&] { orb->setWTA_K(wanted.WTA_K); };
        break;
    case 6:
        wanted.scoreType = number(data, 0, 1);
        set = [&] { orb->setScoreType(static_cast<ORB::ScoreType>(wanted.scoreType)); };
        break;
    case 7:
        wanted.patchSize = number(data, 2, 80);
        set = [&] { orb->setPatchSize(wanted.patchSize); };
        break;
    default:
        wanted.fastThreshold = number(data, 0, 60);
        set = [&] { orb->setFastThreshold(wanted.fastThreshold); };
    }
    if (attempt("a setter", isOrb ? UNKNOWN : expect(wanted.isBad(true)), set))
        parameters = wanted;
    requireParameters("a setter");
}

void Detector::setOurParameter(FuzzedDataProvider& data)
{
    // What is drawn for each: a number of a small or of any kind. The cases of version 0.1 come first.
    const int which = data.ConsumeIntegralInRange(0, 8);
    const int whole = which == 0   ? number(data, 8, 100)
                      : which == 1 ? number(data, -1, 15)
                      : which == 6 ? number(data, 0, 1)
                                   : 0;
    const double ratio = which == 2   ? real(data, 1, 10)
                         : which == 3 ? real(data, -1, 20)
                         : which == 7 ? real(data, 0, 2)
                         : which == 8 ? real(data, 0, 16)
                                      : 0;
    const bool flag = data.ConsumeBool();
    if (isOrb)
        return;
    switch (which)
    {
    case 0:
        attempt("setCellSize", expect(whole < 8), [&] { ours->setCellSize(whole); });
        return;
    case 1:
        attempt("setMaxDepth", expect(whole < -1 || whole > 15), [&] { ours->setMaxDepth(whole); });
        return;
    case 2:
        attempt("setMinThresholdRatio", expect(!std::isfinite(ratio) || ratio < 1),
                [&] { ours->setMinThresholdRatio(ratio); });
        return;
    case 3:
        attempt("setOctaveSuppression", expect(!std::isfinite(ratio) || (ratio < 0 && ratio != -1)),
                [&] { ours->setOctaveSuppression(ratio); });
        return;
    case 4:
        ours->setAdaptiveThreshold(flag);
        return;
    case 5:
        ours->setSubPixel(flag);
        return;
    case 6:
        attempt("setSelectionType", expect(whole < 0 || whole > 1),
                [&] { ours->setSelectionType(static_cast<AdaptiveQuadtreeORB::SelectionType>(whole)); });
        return;
    case 7:
        attempt("setStrengthWeight", expect(!(ratio >= 0 && ratio <= 1000)),
                [&] { ours->setStrengthWeight(ratio); });
        return;
    default:
        attempt("setRankRadius", expect(!(ratio >= 0 && ratio <= 16)), [&] { ours->setRankRadius(ratio); });
    }
}

void Detector::requireParameters(const char* after) const
{
    if (isOrb)
        return;
    const OrbParameters& p = parameters;
    require(orb->getMaxFeatures() == p.nfeatures && orb->getScaleFactor() == p.scaleFactor &&
                orb->getNLevels() == p.nlevels && orb->getEdgeThreshold() == p.edgeThreshold &&
                orb->getFirstLevel() == p.firstLevel && orb->getWTA_K() == p.WTA_K &&
                orb->getScoreType() == p.scoreType && orb->getPatchSize() == p.patchSize &&
                orb->getFastThreshold() == p.fastThreshold,
            std::string(after) + " left other parameters");
}

//! Writes a storage with fields of any kind, and reads it.
void Detector::readStorage(FuzzedDataProvider& data)
{
    static const char* const KEYS[] = {"nfeatures",         "scaleFactor",       "nlevels",
                                       "edgeThreshold",     "firstLevel",        "wta_k",
                                       "scoreType",         "patchSize",         "fastThreshold",
                                       "adaptiveThreshold", "minThresholdRatio", "cellSize",
                                       "maxDepth",          "octaveSuppression", "subPixel",
                                       "selectionType",     "strengthWeight",    "rankRadius"};
    const char* names[] = {"memory.yml", "memory.xml", "memory.json"};
    FileStorage out(data.PickValueInArray(names), FileStorage::WRITE | FileStorage::MEMORY);
    out << "detector"
        << "{";
    const bool whole = data.ConsumeBool();
    if (whole && !isOrb)
        ours->write(out);
    std::vector<bool> written(18, whole);
    for (int i = data.ConsumeIntegralInRange(0, 6); i > 0; i--)
    {
        const int key = data.ConsumeIntegralInRange(0, 17), kind = data.ConsumeIntegralInRange(0, 7);
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
    if (isOrb)
        return;  // cv::ORB of OpenCV 4.6 does not read its parameters
    FileStorage in(text, FileStorage::READ | FileStorage::MEMORY);
    const FileNode node = data.ConsumeBool() ? in["detector"] : in.root();
    attempt("read", UNKNOWN, [&] { ours->read(node); });
    OrbParameters& p = parameters;
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
    require(!now.isBad(true), "read left a bad parameter");
    p = now;
}

}  // namespace fuzz
