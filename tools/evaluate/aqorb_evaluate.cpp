// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures detectors on the images of the paper and others, and writes CSV files. tools/report/report.py makes
// tables of them: see doc/reproduction.md.

#include "../common/csv.hpp"
#include "../common/median.hpp"
#include "../common/program.hpp"
#include "dataset.hpp"
#include "method.hpp"
#include "measures.hpp"
#include "stereo_odometry.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <ctime>
#include <iostream>
#include <map>

#include <unistd.h>

using namespace cv;
using std::to_string;
using tools::csvNumber;
using tools::CsvTable;

namespace
{

const char* const ABOUT =
    "Measures AdaptiveQuadtreeORB and other detectors on sets of the Oxford data (bikes, leuven, ...):\n"
    "uniformity, time, matches. Writes CSV files and pictures of keypoints.\n"
    "Exit codes: 0 done, 1 bad arguments, 2 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{out            | .    | folder to write to }"
    "{sets           | bikes,leuven,bark,trees,ubc | folders in DATASETS: img1..6, H1to2p..6p }"
    "{methods        | all  | all: orb,orb_slam,paper,aqorb,sift,surf,brisk,akaze,ssc,superpoint; also "
    "figure2 "
    "and aqorb:key=value:... }"
    "{n              | 500  | numbers of features; tables 1 to 3 are of the first }"
    "{runs           | 30   | repeats of a time measurement, fewer for methods that take long }"
    "{seeds          | 15   | random seeds of a homography's estimation }"
    "{degrade        |      | dark,gamma,noise,blur,shrunk,enlarged: also measure on images made worse so }"
    "{ablation       |      | also measure aqorb with one ingredient changed }"
    "{odometry       |      | stereo sequence laid out as KITTI's: also measure visual odometry }"
    "{superpoint     |      | ONNX file of SuperPoint's two heads }"
    "{@datasets      |      | folder of the sets }";

struct Options
{
    std::string datasets, out, odometry, superPoint;
    std::vector<std::string> sets, methods, degradations;
    std::vector<int> numbers;
    int runs, seeds;
    bool ablation;
};

//! Shows in one line what is being measured, if standard error is a terminal.
class Progress
{
public:
    ~Progress() { show(""); }
    void show(const std::string& what) const
    {
        if (isTerminal)
            std::cerr << "\r\033[K" << what << std::flush;
    }

private:
    const bool isTerminal = isatty(STDERR_FILENO) != 0;
};

Options readOptions(const CommandLineParser& parser)
{
    Options options;
    options.datasets = parser.get<String>("@datasets");
    options.out = parser.get<String>("out");
    options.odometry = parser.get<String>("odometry");
    options.superPoint = parser.get<String>("superpoint");
    options.sets = tools::splitList(parser.get<String>("sets"));
    for (const std::string& name : tools::splitList(parser.get<String>("methods")))
    {
        if (name == "all")
            for (const std::string& each : allMethods())
                options.methods.push_back(each);
        else
            options.methods.push_back(name);
    }
    options.degradations = tools::splitList(parser.get<String>("degrade"));
    options.numbers = tools::splitNumbers(parser.get<String>("n"));
    options.runs = parser.get<int>("runs");
    options.seeds = parser.get<int>("seeds");
    options.ablation = parser.has("ablation");
    tools::checkRead(parser);
    if (options.datasets.empty())
        throw tools::BadArguments{"which DATASETS? see --help"};
    if (options.numbers.empty() || *std::min_element(options.numbers.begin(), options.numbers.end()) < 1)
        throw tools::BadArguments{"--n: numbers above 0, separated by commas"};
    if (options.runs < 0 || options.seeds < 1)
        throw tools::BadArguments{"--runs: at least 0; --seeds: at least 1"};
    return options;
}

/** What tools/report/evaluation.py makes tables of, all numbers as they were measured: what OpenCV and which CPU
 features were in use; titles of the methods and of the ablations, and why others are absent; the measures. Cells are
 empty where nothing was measured. */
struct Results
{
    CsvTable setting{{"name", "value"}};
    CsvTable methods{{"method", "role", "text"}};
    CsvTable uniformity{{"set", "image", "method", "n", "keypoints", "uniformity", "occupancy", "time_ms"}};
    CsvTable matching{{"set", "pair", "method", "n", "matches", "correct", "distinct", "places", "precision",
                       "repeatability", "corner_error"}};
    CsvTable homography{{"set", "pair", "method", "n", "seed", "corner_error"}};
    CsvTable odometry{{"method", "n", "frame", "stereo", "matches", "inliers", "translation_error_m",
                       "rotation_error_deg"}};
};

typedef std::vector<Ptr<Method>> Methods;

Methods makeMethods(const std::vector<std::string>& names, const std::string& superPoint, Results& results)
{
    Methods methods;
    for (const std::string& name : names)
    {
        try
        {
            methods.push_back(makeMethod(name, superPoint));
            results.methods.add({name, "method", methods.back()->title});
        }
        catch (const Absent& absent)
        {
            std::cerr << name << " is absent: " << absent.reason << std::endl;
            results.methods.add({name, "absent", absent.reason});
        }
    }
    return methods;
}

/** Median CPU times in ms on one thread. The methods take turns, so that other load of the machine slows all of
 them alike. A method that has taken long enough in total is not run again. */
std::vector<double> medianTimes(const Methods& methods, const Mat& image, int n, int runs)
{
    const double ENOUGH = 300;  // ms
    const int threads = getNumThreads();
    setNumThreads(1);
    std::vector<std::vector<double>> times(methods.size());
    std::vector<double> total(methods.size(), 0);
    for (int run = 0; run < runs; run++)
        for (size_t i = 0; i < methods.size(); i++)
        {
            if (total[i] >= ENOUGH)
                continue;
            const std::clock_t start = std::clock();
            methods[i]->compute(image, n);
            times[i].push_back(1e3 * double(std::clock() - start) / CLOCKS_PER_SEC);
            total[i] += times[i].back();
        }
    setNumThreads(threads);
    std::vector<double> medians;
    for (const std::vector<double>& all : times)
        medians.push_back(all.empty() ? -1 : tools::median(all));
    return medians;
}

void drawKeypoints(const Mat& image, const Features& features, const std::string& file)
{
    Mat picture;
    cv::drawKeypoints(image, features.keypoints, picture, Scalar(0, 255, 0));
    if (!imwrite(file, picture, {IMWRITE_JPEG_QUALITY, 85}))
        CV_Error(Error::StsError, file + ": cannot be written");
}

//! Draws the pictures of figures 3 to 5: bikes img1 by the paper's three methods, leuven by two of them.
void drawFigures(const ImageSet& set, size_t image, const Method& method, const Features& features,
                 const std::string& folder)
{
    static const std::map<std::string, char> letters = {{"orb", 'a'}, {"orb_slam", 'b'}, {"paper", 'c'}};
    if (set.name == "bikes" && image == 0 && letters.count(method.name))
        drawKeypoints(set.images[image], features,
                      folder + format("/figure3%c_%s.jpg", letters.at(method.name), method.name.c_str()));
    if (set.name == "leuven" && (method.name == "orb" || method.name == "paper"))
        drawKeypoints(set.images[image], features,
                      folder + format("/figure%d%c_%s.jpg", method.name == "orb" ? 4 : 5, char('a' + image),
                                      method.name.c_str()));
}

void addMatching(const std::string& set, const std::string& pair, const std::string& method, int n,
                 const Matching& m, Results& results)
{
    results.matching.add({set, pair, method, to_string(n), to_string(m.matches), to_string(m.correct),
                          to_string(m.distinct), to_string(m.places), csvNumber(m.precision()),
                          csvNumber(m.repeatability), csvNumber(tools::median(m.errors))});
    for (size_t seed = 0; seed < m.errors.size(); seed++)
        results.homography.add(
            {set, pair, method, to_string(n), to_string(seed + 1), csvNumber(m.errors[seed])});
}

void measureSet(const ImageSet& set, Methods& methods, const Options& options, bool isPlain, Results& results,
                const Progress& progress)
{
    for (const int n : options.numbers)
    {
        const bool isPaper = isPlain && n == options.numbers[0];
        std::vector<std::vector<double>> times(set.images.size(), std::vector<double>(methods.size(), -1));
        for (size_t i = 0; isPaper && i < set.images.size(); i++)
        {
            progress.show(format("%s: times, image %d", set.name.c_str(), int(i + 1)));
            times[i] = medianTimes(methods, set.images[i], n, options.runs);
        }
        for (size_t m = 0; m < methods.size(); m++)
        {
            progress.show(format("%s: n = %d, %s", set.name.c_str(), n, methods[m]->name.c_str()));
            std::vector<Features> features;
            for (size_t i = 0; i < set.images.size(); i++)
            {
                const Size size = set.images[i].size();
                features.push_back(methods[m]->compute(set.images[i], n));
                const std::vector<KeyPoint>& keypoints = features.back().keypoints;
                results.uniformity.add({set.name, to_string(i + 1), methods[m]->name, to_string(n),
                                        to_string(keypoints.size()),
                                        csvNumber(aqorb::distributionUniformity(keypoints, size)),
                                        csvNumber(aqorb::distributionOccupancy(keypoints, size)),
                                        times[i][m] < 0 ? "" : csvNumber(times[i][m])});
                if (isPaper)
                    drawFigures(set, i, *methods[m], features.back(), options.out);
            }
            std::vector<Matching> pairs(set.images.size());
            parallel_for_(Range(1, int(set.images.size())),
                          [&](const Range& range)
                          {
                              for (int i = range.start; i < range.end; i++)
                                  pairs[i] = measureMatching(features[0], features[i], methods[m]->norm(),
                                                             set.homographies[i], set.images[0].size(),
                                                             set.images[i].size(), options.seeds);
                          });
            for (size_t i = 1; i < pairs.size(); i++)
                addMatching(set.name, "1-" + to_string(i + 1), methods[m]->name, n, pairs[i], results);
        }
    }
}

void measureOdometry(const StereoSequence& sequence, Method& method, int n, Results& results)
{
    StereoFrame earlier;
    for (size_t i = 0; i < sequence.left.size(); i++)
    {
        const Features left = method.compute(imread(sequence.left[i]), n);
        const Features right = method.compute(imread(sequence.right[i]), n);
        const StereoFrame later = triangulate(sequence, left, right, method.norm());
        if (i > 0)
        {
            const std::vector<DMatch> matches =
                matchFrames(earlier, later, *opencv_test::makeMatcher(method.norm(), true));
            const OdometryStep step = estimateMotion(sequence, earlier, i - 1, later, i, matches);
            results.odometry.add({method.name, to_string(n), to_string(i), to_string(step.points),
                                  to_string(step.matches), to_string(step.inliers),
                                  step.found ? csvNumber(step.metres) : "",
                                  step.found ? csvNumber(step.degrees) : ""});
        }
        earlier = later;
    }
}

void run(const Options& options)
{
    Results results;
    Methods methods = makeMethods(options.methods, options.superPoint, results);
    Methods ablations;  // those that are not among the methods already
    for (const Ablation& ablation : options.ablation ? ablationMethods() : std::vector<Ablation>())
    {
        results.methods.add({ablation.name, "ablation", ablation.but});
        const auto isIt = [&](const Ptr<Method>& method) { return method->name == ablation.name; };
        if (std::none_of(methods.begin(), methods.end(), isIt))
            ablations.push_back(makeMethod(ablation.name, ""));
    }
    utils::fs::createDirectories(options.out);

    const Progress progress;
    for (const std::string& name : options.sets)
    {
        const ImageSet set = readSet(options.datasets, name);
        measureSet(set, methods, options, true, results, progress);
        measureSet(set, ablations, options, false, results, progress);
        for (const std::string& degradation : options.degradations)
            measureSet(degrade(set, degradation), methods, options, false, results, progress);
    }
    if (!options.odometry.empty())
    {
        const StereoSequence sequence = readPosedSequence(options.odometry);
        for (const int n : options.numbers)
            for (const Ptr<Method>& method : methods)
            {
                progress.show(format("odometry: n = %d, %s", n, method->name.c_str()));
                measureOdometry(sequence, *method, n, results);
            }
    }
    results.setting.add({"OpenCV", CV_VERSION});
    results.setting.add({"CPU features", getCPUFeaturesLine()});
    results.setting.write(options.out + "/setting.csv");
    results.methods.write(options.out + "/methods.csv");
    results.uniformity.write(options.out + "/uniformity.csv");
    results.matching.write(options.out + "/matching.csv");
    results.homography.write(options.out + "/homography.csv");
    if (!options.odometry.empty())
        results.odometry.write(options.out + "/odometry.csv");
}

}  // namespace

int main(int argc, char** argv)
{
    return tools::runProgram("aqorb_evaluate", ABOUT, KEYS, argc, argv,
                             [](const CommandLineParser& parser)
                             {
                                 run(readOptions(parser));
                                 return 0;
                             });
}
