// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "calls.hpp"

#include "generate.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utils/logger.hpp>

#include <cmath>
#include <functional>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace fuzz
{

namespace
{

typedef std::vector<KeyPoint> KeyPoints;

// What is slow by design, or takes much memory, is left out: a pyramid of more pixels, larger patches.
const double MAX_PYRAMID_PIXELS = 4e5;
const double MAX_PATCH_PIXELS = 2e7;

//! Another thing than what the documentation says has happened.
struct Problem
{
    Outcome outcome;
    std::string text;
};

void require(bool condition, const std::string& what)
{
    if (!condition)
        throw Problem{BAD_OUTPUT, what};
}

bool isFinite(double value)
{
    return std::isfinite(value);
}

//! All of cv::ORB, which has no getter that could tell an invalid score type.
struct OrbParameters
{
    int nfeatures = 500;
    double scaleFactor = 1.2f;
    int nlevels = 8, edgeThreshold = 16, firstLevel = 0, WTA_K = 2, scoreType = ORB::HARRIS_SCORE;
    int patchSize = 31, fastThreshold = 20;

    //! Whether a value is bad by itself; `limits`: also one that only AdaptiveQuadtreeORB rejects.
    bool isBad(bool limits) const
    {
        return nfeatures < 0 || !isFinite(scaleFactor) || scaleFactor <= 0 || nlevels < 1 ||
               edgeThreshold < 0 || firstLevel < 0 || WTA_K < 2 || WTA_K > 4 || scoreType < 0 ||
               scoreType > 1 || patchSize < 2 || (limits && (nlevels > 65536 || patchSize > 16384));
    }
    //! Whether values do not go together.
    bool clash() const { return (nlevels > 1 && scaleFactor <= 1) || firstLevel >= nlevels; }

    double scale(int level) const { return std::pow(scaleFactor, double(level - firstLevel)); }
    bool hasTooLargeLevel(Size image, int level) const
    {
        return !(std::max(image.width, image.height) / scale(level) < (1 << 20) - 1);
    }
};

//! Whether an exception says which argument it is about.
bool isNamed(const cv::Exception& e)
{
    const char* names[] = {"nfeatures",     "scaleFactor",       "nlevels",
                           "edgeThreshold", "firstLevel",        "WTA_K",
                           "wta_k",         "scoreType",         "patchSize",
                           "fastThreshold", "adaptiveThreshold", "minThresholdRatio",
                           "cellSize",      "octaveSuppression", "subPixel",
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

//! Whether it is as documented: says what is accepted, too.
bool isDocumented(const cv::Exception& e)
{
    return isNamed(e) && e.err.find("accepted") != std::string::npos &&
           (e.code == Error::StsBadArg || e.code == Error::StsOutOfRange || e.code == Error::StsParseError);
}

class Caller
{
public:
    Caller(const uint8_t* bytes, size_t size, bool ofOrb) : data(bytes, size), isOrb(ofOrb) {}

    Report run()
    {
        Report report;
        const auto runChecked = [&](const std::function<void()>& part)
        {
            try
            {
                part();
            }
            catch (const Problem& problem)
            {
                if (problem.outcome > report.outcome)
                {
                    report.outcome = problem.outcome;
                    report.problem = problem.text;
                }
            }
        };
        runChecked([&] { create(); });
        picture = image(data, 64, true);
        // What cv::ORB comes to should not hide what it comes to later.
        for (int calls = 0; calls < 20 && data.remaining_bytes() > 0 && orb; calls++)
        {
            if (!isOrb && report.outcome != FINE)
                break;
            runChecked([&] { callOne(); });
        }
        if (report.outcome == FINE && rejections > 0)
            report.outcome = NAMED_EXCEPTION;
        return report;
    }

private:
    enum Expectation
    {
        GOOD,    // arguments: no exception
        BAD,     // an exception that names one
        UNKNOWN  // either
    };

    //! Calls a function; false if it rejected its arguments.
    bool attempt(const char* name, Expectation expected, const std::function<void()>& function)
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

    void create()
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
        const auto make = [&](const OrbParameters& p)
        {
            if (isOrb)
            {
                orb = ORB::create(p.nfeatures, float(p.scaleFactor), p.nlevels, p.edgeThreshold, p.firstLevel,
                                  p.WTA_K, static_cast<ORB::ScoreType>(p.scoreType), p.patchSize,
                                  p.fastThreshold);
                return;
            }
            ours = AdaptiveQuadtreeORB::create(
                p.nfeatures, float(p.scaleFactor), p.nlevels, p.edgeThreshold, p.firstLevel, p.WTA_K,
                static_cast<ORB::ScoreType>(p.scoreType), p.patchSize, p.fastThreshold);
            orb = ours;
        };
        // cv::ORB checks when it is used.
        if (attempt("create", isOrb ? UNKNOWN : expect(wanted.isBad(true)), [&] { make(wanted); }))
            parameters = wanted;
        else
            make(parameters);
    }

    static Expectation expect(bool bad) { return bad ? BAD : GOOD; }

    void callOne()
    {
        switch (data.ConsumeIntegralInRange(0, 15))
        {
        case 0:
            setOrbParameter();
            return;
        case 1:
            setOrbParameter();
            return;
        case 2:
            setOurParameter();
            return;
        case 3:
            setOurParameter();
            return;
        case 4:
            readStorage();
            return;
        case 5:
            buildPyramid();
            return;
        case 6:
            callFunctions();
            return;
        case 7:
        case 8:
            picture = image(data, data.ConsumeBool() ? 64 : 300, true);
            return;
        case 9:
            area = mask(data, picture.dims > 2 ? Size() : picture.size(), true);
            return;
        case 10:
        case 11:
            compute();
            return;
        default:
            detect();
            return;
        }
    }

    void setOrbParameter()
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

    void setOurParameter()
    {
        const int which = data.ConsumeIntegralInRange(0, 5);
        const int whole = which == 0 ? number(data, 8, 100) : which == 1 ? number(data, -1, 15) : 0;
        const double ratio = which == 2 ? real(data, 1, 10) : which == 3 ? real(data, 0, 20) : 0;
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
            attempt("setMinThresholdRatio", expect(!isFinite(ratio) || ratio < 1),
                    [&] { ours->setMinThresholdRatio(ratio); });
            return;
        case 3:
            attempt("setOctaveSuppression", expect(!isFinite(ratio) || ratio < 0),
                    [&] { ours->setOctaveSuppression(ratio); });
            return;
        case 4:
            ours->setAdaptiveThreshold(flag);
            return;
        default:
            ours->setSubPixel(flag);
        }
    }

    //! A value that was rejected must not stay, one that was accepted must.
    void requireParameters(const char* after) const
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
    void readStorage()
    {
        static const char* const KEYS[] = {"nfeatures",         "scaleFactor",       "nlevels",
                                           "edgeThreshold",     "firstLevel",        "wta_k",
                                           "scoreType",         "patchSize",         "fastThreshold",
                                           "adaptiveThreshold", "minThresholdRatio", "cellSize",
                                           "maxDepth",          "octaveSuppression", "subPixel"};
        const char* names[] = {"memory.yml", "memory.xml", "memory.json"};
        FileStorage out(data.PickValueInArray(names), FileStorage::WRITE | FileStorage::MEMORY);
        out << "detector"
            << "{";
        const bool whole = data.ConsumeBool();
        if (whole && !isOrb)
            ours->write(out);
        std::vector<bool> written(15, whole);
        for (int i = data.ConsumeIntegralInRange(0, 6); i > 0; i--)
        {
            const int key = data.ConsumeIntegralInRange(0, 14), kind = data.ConsumeIntegralInRange(0, 7);
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
            return;  // reads nothing in OpenCV 4.6
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

    bool isPicture() const
    {
        return picture.dims <= 2 && picture.depth() == CV_8U &&
               (picture.channels() == 1 || picture.channels() == 3 || picture.channels() == 4);
    }
    Size pictureSize() const { return picture.dims > 2 ? Size() : picture.size(); }

    //! Whether the levels 0 .. count - 1 have few enough pixels, or so many that this is an error.
    bool isAffordable(int count, size_t keypoints) const
    {
        const OrbParameters& p = parameters;
        if (p.isBad(true))
            return isOrb;  // under a limit of time there
        if (std::min(double(keypoints), MAX_PYRAMID_PIXELS) * p.patchSize * p.patchSize > MAX_PATCH_PIXELS)
            return false;
        if (p.clash() || (count > 0 && p.hasTooLargeLevel(pictureSize(), 0)))
            return true;
        double pixels = 0;
        for (int i = 0; i < count && pixels <= MAX_PYRAMID_PIXELS; i++)
        {
            const double levelPixels = pictureSize().area() / p.scale(i) / p.scale(i);
            if (levelPixels < 0.25)
                break;
            pixels += levelPixels;
        }
        return pixels <= MAX_PYRAMID_PIXELS;
    }

    void buildPyramid()
    {
        if (isOrb || !isAffordable(parameters.nlevels, 0))
            return;
        const bool bad = !isPicture() || parameters.clash() || parameters.hasTooLargeLevel(picture.size(), 0);
        std::vector<Mat> levels(3);
        if (!attempt("buildPyramid", expect(!picture.empty() && bad),
                     [&] { ours->buildPyramid(picture, levels); }))
            return;
        require(int(levels.size()) <= parameters.nlevels && levels.empty() == picture.empty(),
                "buildPyramid gave a wrong number of levels");
        for (const Mat& level : levels)
            require(level.type() == CV_8UC1 && !level.empty(), "buildPyramid gave a bad level");
    }

    void callFunctions()
    {
        const Size size(number(data, 1, 400), number(data, 1, 400));
        const Size grid(number(data, 1, 40), number(data, 1, 40));
        const int npoints = number(data, 0, 20);
        KeyPoints given = keypoints(data, Size(100, 100));
        if (isOrb)
            return;
        const bool badSize = size.width <= 0 || size.height <= 0;
        const bool badGrid =
            grid.width <= 0 || grid.height <= 0 || int64(grid.width) * grid.height > (1 << 24);
        double u = 0, share = 0, threshold = 0;
        attempt("distributionUniformity", expect(badSize),
                [&] { u = aqorb::distributionUniformity(given, size); });
        require(isFinite(u) && u >= 0, "distributionUniformity gave no number");
        attempt("distributionOccupancy", expect(badSize || badGrid),
                [&] { share = aqorb::distributionOccupancy(given, size, grid); });
        require(share >= 0 && share <= 1, "distributionOccupancy gave no share");

        KeyPoints kept = given;
        if (attempt("retainUniform", expect(badSize || npoints < 0),
                    [&] { aqorb::retainUniform(kept, size, npoints); }))
        {
            require(int(kept.size()) <= npoints, "retainUniform kept too many");
            int before = INT_MAX;  // class_id falls in the order given
            for (const KeyPoint& k : kept)
            {
                require(k.class_id < before && k.pt.x >= 0 && k.pt.y >= 0 && k.pt.x < float(size.width) &&
                            k.pt.y < float(size.height),
                        "retainUniform kept a wrong point, or in another order");
                before = k.class_id;
            }
        }
        const bool bad =
            !isPicture() ||
            (!area.empty() && (area.dims > 2 || area.type() != CV_8UC1 || area.size() != picture.size()));
        attempt("adaptiveFastThreshold", picture.empty() ? UNKNOWN : expect(bad),
                [&] { threshold = aqorb::adaptiveFastThreshold(picture, area); });
        require(isFinite(threshold) && threshold >= 0, "adaptiveFastThreshold gave no number");
    }

    void detect()
    {
        const int kind = data.ConsumeIntegralInRange(0, 3);
        const OrbParameters& p = parameters;
        const size_t corners = std::min<size_t>(std::max(p.nfeatures, 0), pictureSize().area() / 4);
        if (!isAffordable(p.nlevels, corners))
            return;
        const bool badMask =
            !area.empty() && (area.dims > 2 || area.type() != CV_8UC1 || area.size() != pictureSize());
        const bool bad = p.isBad(!isOrb) || p.clash() || !isPicture() || badMask ||
                         (!isOrb && p.hasTooLargeLevel(pictureSize(), 0));
        // What was there before must go.
        KeyPoints found(3, KeyPoint(Point2f(-7, -7), 1.f, -1.f, 0.f, -1));
        Mat descriptors(2, 5, CV_16SC1, Scalar(3));
        const bool withDescriptors = kind < 2;
        const auto call = [&]
        {
            if (kind == 0)
            {
                orb->detectAndCompute(picture, area, found, descriptors);
            }
            else if (kind == 1)
            {
                UMat output;
                orb->detectAndCompute(picture.getUMat(ACCESS_READ), area, found, output);
                output.copyTo(descriptors);
            }
            else
            {
                orb->detect(picture, found, area);
            }
        };
        if (!attempt("detect", picture.empty() ? UNKNOWN : expect(bad), call))
        {
            require(isOrb || (found.size() == 3 && found[0].pt.x == -7), "a failed call changed its output");
            return;
        }
        if (picture.empty())
        {
            require(found.empty() && (!withDescriptors || descriptors.empty()),
                    "stale outputs for an empty image");
            return;
        }
        require(int64(found.size()) <= p.nfeatures, "detect gave more keypoints than nfeatures");
        for (const KeyPoint& k : found)
        {
            requireInside(k);
            require(isFinite(k.size) && isFinite(k.angle) && isFinite(k.response),
                    "detect gave a keypoint of which a field is not finite");
            require(k.octave >= 0 && k.octave < p.nlevels, "detect gave an octave that is no level");
            require(area.empty() || area.at<uchar>(cvRound(k.pt.y), cvRound(k.pt.x)) != 0,
                    "detect gave a keypoint on a masked pixel");
        }
        if (withDescriptors)
            requireDescriptors(found, descriptors);
    }

    void compute()
    {
        const OrbParameters& p = parameters;
        const KeyPoints given = keypoints(data, pictureSize());
        int maxOctave = 0, minOctave = 0;
        bool badAngle = false;
        for (const KeyPoint& k : given)
        {
            maxOctave = std::max(maxOctave, k.octave);
            minOctave = std::min(minOctave, k.octave);
            badAngle |= !isFinite(k.angle);
        }
        if (!isAffordable(std::min(maxOctave, 65536) + 1, given.size()))
            return;
        const double scale = p.scale(maxOctave);
        const Size size = pictureSize();
        const bool isTooSmall = !(cvRound(size.width / scale) >= 1 && cvRound(size.height / scale) >= 1);
        bool bad = p.isBad(!isOrb) || p.clash() || !isPicture() || minOctave < 0 ||
                   (maxOctave > 0 && p.scaleFactor <= 1) || isTooSmall || badAngle;
        // Of levels that no keypoint is left on, cv::ORB and we need not know.
        const bool mayBeBad = p.hasTooLargeLevel(size, 0);
        KeyPoints found = given;
        Mat descriptors(2, 5, CV_16SC1, Scalar(3));
        const Expectation expected = picture.empty() || (mayBeBad && !bad) ? UNKNOWN : expect(bad);
        if (!attempt("compute", expected, [&] { orb->compute(picture, found, descriptors); }) ||
            picture.empty())
            return;
        require(found.size() <= given.size(), "compute gave more keypoints than there were");
        for (const KeyPoint& k : found)
            requireInside(k);
        requireDescriptors(found, descriptors);
    }

    void requireInside(const KeyPoint& k) const
    {
        // By its pixel: the border of cv::ORB's compute is that of Rect::contains.
        require(isFinite(k.pt.x) && isFinite(k.pt.y) && k.pt.x >= -0.5f && k.pt.y >= -0.5f &&
                    k.pt.x <= float(picture.cols) - 0.5f && k.pt.y <= float(picture.rows) - 0.5f,
                "a keypoint lies off the image");
    }
    static void requireDescriptors(const KeyPoints& found, const Mat& descriptors)
    {
        require(descriptors.rows == int(found.size()) &&
                    (found.empty() || (descriptors.cols == 32 && descriptors.type() == CV_8UC1)),
                "descriptors and keypoints do not match");
    }

    FuzzedDataProvider data;
    const bool isOrb;
    Ptr<AdaptiveQuadtreeORB> ours;
    Ptr<ORB> orb;
    OrbParameters parameters;
    Mat picture, area;
    int rejections = 0;
};

}  // namespace

Report callDetector(const uint8_t* bytes, size_t size, bool ofOrb)
{
    // An exception is no reason to print its message.
    static const bool quiet = []
    {
        utils::logging::setLogLevel(utils::logging::LOG_LEVEL_SILENT);
        redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
        return true;
    }();
    (void)quiet;
    return Caller(bytes, size, ofOrb).run();
}

}  // namespace fuzz
