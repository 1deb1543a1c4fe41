// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures what is claimed of the default selection, prints each claim with its number, and says whether it holds:
// see doc/reproduction.md.

#include "../../common/csv.hpp"
#include "../../common/program.hpp"
#include "claims.hpp"
#include "subjects.hpp"

#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

namespace
{

const char* const ABOUT = "Measures what is claimed of AdaptiveQuadtreeORB's selection beside cv::ORB and "
                          "the paper's selection, and says\n"
                          "whether it holds. Images are read in grey unless a line says otherwise.\n"
                          "Exit codes: 0 all that is asked holds (a time does not count), 3 something does "
                          "not, 1 bad arguments, 2 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{methods        | aqorb | methods to judge: aqorb or aqorb:key=value:..., separated by commas }"
    "{orb            | orb  | the method that stands for cv::ORB }"
    "{paper          | aqorb:selection=balanced | the method that stands for the paper's selection }"
    "{paperslam      | slam:selection=balanced:octave=0.5 | SlamExtractor with the paper's selection, as it "
    "was }"
    "{dial           | aqorb:strength=1000 | the method at the dial's other end }"
    "{only           | distinct,uniformity,roll,scale,findobj,heldout,stereo,start,degraded,cost | what is "
    "measured }"
    "{table          |      | print a row of means for each method instead of claims }"
    "{short          |      | only distinct,uniformity,roll,scale,findobj,start, and no homographies }"
    "{n              | 500,1000,2000 | numbers of features }"
    "{seeds          | 15   | random seeds; 0 leaves homographies out }"
    "{sets           | bikes,leuven,bark,trees,ubc,graf | folders in DATASETS }"
    "{photographs    | bikes,leuven,trees,graf | sets whose first image is rolled, and rolled and scaled }"
    "{object         |      | folder with box.png and box_in_scene.png of OpenCV's samples, for findobj }"
    "{heldout        |      | folder that scripts/held_out.sh made, for heldout }"
    "{stereo         |      | stereo sequence laid out as KITTI's, for stereo and start }"
    "{degrade        | dark,gamma,noise,blur,shrunk,enlarged | the ways in which images are made worse }"
    "{runs           | 30   | repeats of a time measurement }"
    "{out            |      | folder to write claims.csv and measured.csv to }"
    "{@datasets      |      | folder of the sets }";

//! In degrees, of the photographs; and those that are scaled, too: one of each third of a quarter turn.
const std::vector<int> ROLLS = {15, 45, 75, 105, 135, 165, 195, 225, 255, 285, 315, 345},
                       FEW_ROLLS = {15, 135, 255};

struct Options
{
    std::string datasets, out, orb, paper, paperSlam, dial, object, heldOut, stereo;
    std::vector<std::string> methods, only, sets, photographs, degradations;
    std::vector<int> numbers;
    int seeds, runs;
    bool isTable;
};

Options readOptions(const cv::CommandLineParser& parser)
{
    const auto text = [&](const char* key) { return std::string(parser.get<cv::String>(key)); };
    const auto list = [&](const char* key) { return tools::splitList(text(key)); };
    Options options = {text("@datasets"),
                       text("out"),
                       text("orb"),
                       text("paper"),
                       text("paperslam"),
                       text("dial"),
                       text("object"),
                       text("heldout"),
                       text("stereo"),
                       list("methods"),
                       list("only"),
                       list("sets"),
                       list("photographs"),
                       list("degrade"),
                       tools::splitNumbers(text("n")),
                       parser.get<int>("seeds"),
                       parser.get<int>("runs"),
                       parser.has("table")};
    if (parser.has("short"))
    {
        options.only = {"distinct", "uniformity", "roll", "scale", "findobj", "start"};
        options.seeds = 0;
    }
    tools::checkRead(parser);
    if (options.datasets.empty())
        throw tools::BadArguments{"which DATASETS? see --help"};
    if (options.numbers.empty() || *std::min_element(options.numbers.begin(), options.numbers.end()) < 1)
        throw tools::BadArguments{"--n: numbers above 0, separated by commas"};
    if (options.runs < 1 || options.seeds < 0)
        throw tools::BadArguments{"--runs: at least 1; --seeds: at least 0"};
    static const std::vector<std::string> subjects = {"distinct", "uniformity", "roll",   "scale",
                                                      "findobj",  "heldout",    "stereo", "start",
                                                      "degraded", "cost"};
    for (const std::string& subject : options.only)
        if (std::find(subjects.begin(), subjects.end(), subject) == subjects.end())
            throw tools::BadArguments{"--only: " + subject +
                                      " is none of distinct, uniformity, roll, scale, findobj, "
                                      "heldout, stereo, start, degraded, cost"};
    return options;
}

/** Whether a subject is asked for. It is left out with a word where its data is not given.
 @param data the option's value; "-" for a subject that needs no other data than the sets */
bool isAsked(const Options& options, const std::string& subject, const std::string& data = "-")
{
    if (std::find(options.only.begin(), options.only.end(), subject) == options.only.end())
        return false;
    if (data.empty())
        std::cerr << subject << " is left out: its data is not given, see --help" << std::endl;
    return !data.empty();
}

//! Names without repetition, in the order in which they first appear.
std::vector<std::string> unique(const std::vector<std::string>& names)
{
    std::vector<std::string> found;
    for (const std::string& name : names)
        if (!name.empty() && std::find(found.begin(), found.end(), name) == found.end())
            found.push_back(name);
    return found;
}

std::vector<ImageSet> readSets(const Options& options, const std::vector<std::string>& names, int flags)
{
    std::vector<ImageSet> sets;
    for (const std::string& name : names)
        sets.push_back(readSet(options.datasets, name, flags));
    return sets;
}

cv::Mat readGrey(const std::string& file)
{
    const cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
    if (image.empty())
        CV_Error(cv::Error::StsObjectNotFound, file + ": no such image");
    return image;
}

Measurements measure(const Options& options)
{
    Measurements results;
    std::vector<std::string> names = options.methods;
    names.insert(names.begin(), {options.orb, options.paper});
    std::vector<cv::Ptr<Method>> methods;
    for (const std::string& name : unique(names))
        methods.push_back(makeMethod(name, ""));

    const std::vector<ImageSet> sets = readSets(options, options.sets, cv::IMREAD_GRAYSCALE);
    if (isAsked(options, "distinct"))
        for (const ImageSet& set : sets)
            for (const int n : options.numbers)
                for (const cv::Ptr<Method>& method : methods)
                    measureSet("sets", set, *method, n, options.seeds, results);
    if (isAsked(options, "uniformity"))
    {
        for (const ImageSet& set : readSets(options, options.sets, cv::IMREAD_COLOR))
            for (const cv::Ptr<Method>& method : methods)
                measureUniformity("colour", set, *method, options.numbers[0], results);
        for (const ImageSet& set : sets)
            for (const cv::Ptr<Method>& method : methods)
                for (const int n : options.numbers)
                    if (!isAsked(options, "distinct"))
                        measureUniformity("sets", set, *method, n, results);
    }
    if (isAsked(options, "roll"))
        for (const ImageSet& set : readSets(options, options.photographs, cv::IMREAD_GRAYSCALE))
            for (const cv::Ptr<Method>& method : methods)
                measureRolled("rolled", set.name, set.images[0], ROLLS, 1, *method, 1000, results);
    if (isAsked(options, "scale"))
    {
        for (const ImageSet& set : sets)
            for (const int n : options.numbers)
                for (const cv::Ptr<Method>& method : methods)
                    measureScaled(set.name, set.images[0], SCALES, *method, n, results);
        for (const ImageSet& set : readSets(options, options.photographs, cv::IMREAD_GRAYSCALE))
            for (const double scale : ROLLED_SCALES)
                for (const cv::Ptr<Method>& method : methods)
                    measureRolled("rolled, " + subjectOfScale(scale), set.name, set.images[0], FEW_ROLLS,
                                  scale, *method, 1000, results);
    }
    if (isAsked(options, "findobj", options.object))
    {
        const cv::Mat object = readGrey(options.object + "/box.png");
        const cv::Mat scene = readGrey(options.object + "/box_in_scene.png");
        std::vector<cv::Ptr<Method>> all = methods;
        if (std::find(names.begin(), names.end(), options.dial) == names.end())
            all.push_back(makeMethod(options.dial, ""));
        for (const cv::Ptr<Method>& method : all)
            for (const int n : OBJECT_NUMBERS)
                measureFindObject(object, scene, *method, n, results);
    }
    if (isAsked(options, "heldout", options.heldOut))
    {
        const std::vector<ImagePair> pairs = readPairs(options.heldOut);
        for (const int n : options.numbers)
            for (const cv::Ptr<Method>& method : methods)
                measureHeldOut(pairs, *method, n, options.seeds, results);
    }
    if (isAsked(options, "stereo", options.stereo))
    {
        const StereoSequence sequence = readPosedSequence(options.stereo);
        std::vector<std::string> all = names;
        all.push_back(options.paperSlam);
        for (const std::string& name : options.methods)
            all.push_back(slamOf(name));
        for (const std::string& name : unique(all))
            measureStereo(sequence, *makeMethod(name, ""), 1000, std::max(options.seeds, 1), results);
    }
    if (isAsked(options, "start", options.stereo))
    {
        const StereoSequence sequence = readPosedSequence(options.stereo);
        std::vector<std::string> all = {options.orb, options.paperSlam};
        for (const std::string& name : options.methods)
            all.push_back(slamOf(name));
        for (const std::string& name : unique(all))
            for (const int n : options.numbers)
                measureStart(sequence, *makeMethod(name, ""), n, results);
    }
    if (isAsked(options, "degraded"))
    {
        for (const std::string& degradation : options.degradations)
        {
            for (const ImageSet& set : sets)
            {
                ImageSet worse = degrade(set, degradation);
                worse.name = set.name;
                for (const cv::Ptr<Method>& method : methods)
                    measureSet(degradation, worse, *method, 1000, 0, results);
            }
        }
    }
    if (isAsked(options, "cost"))
        measureCost(sets, methods, 1000, options.runs, results);
    return results;
}

const char* words(Claim::Verdict verdict)
{
    return verdict == Claim::HOLDS ? "yes" : verdict == Claim::FAILS ? "no" : "";
}

void print(const std::string& method, const std::vector<Claim>& claims)
{
    std::cout << "\n" << method << "\n";
    const char* const form = "%-66s %5s %8s %8s %8s  %-60s %-14s %s\n";
    std::printf(form, "", "n", "here", "cv::ORB", "paper's", "asked", "aim", "holds");
    for (const Claim& claim : claims)
        std::printf(form, claim.what.c_str(), claim.n ? std::to_string(claim.n).c_str() : "",
                    claim.here.c_str(), claim.orb.c_str(), claim.paper.c_str(), claim.asked.c_str(),
                    claim.aim.c_str(), words(claim.verdict));
    std::fflush(stdout);
}

//! A number, or a hyphen for what was not measured.
std::string cell(double value, int digits)
{
    return std::isnan(value) ? "-" : cv::format("%.*f", digits, value);
}

//! What each method reaches on the sets at the first n, at other scales, and on the small object at each n.
void printTable(const Options& options, const Measurements& measured)
{
    const int first = options.numbers[0];
    std::printf(
        "| n = %d | u | occupancy | distinct | places | precision | distinct at other scales | inliers on "
        "the object, n =",
        first);
    for (const int n : OBJECT_NUMBERS)
        std::printf(" %d", n);
    std::printf(" |\n|---|---|---|---|---|---|---|---|\n");
    std::vector<std::string> names = options.methods;
    names.insert(names.end(), {options.paper, options.orb});
    for (const std::string& name : unique(names))
    {
        const auto mean = [&](const char* quantity) { return measured.mean("sets", name, first, quantity); };
        std::printf("| %s | %s | %s | %s | %s | %s | %s |", name.c_str(), cell(mean("uniformity"), 1).c_str(),
                    cell(mean("occupancy"), 3).c_str(), cell(mean("distinct"), 1).c_str(),
                    cell(mean("places"), 1).c_str(), cell(mean("precision"), 3).c_str(),
                    cell(distinctAtScales(measured, name, first), 1).c_str());
        for (const int n : OBJECT_NUMBERS)
            std::printf(" %s", cell(measured.mean("object", name, n, "inliers"), 0).c_str());
        std::printf(" |\n");
    }
}

//! Whether all that is asked holds.
bool run(const Options& options)
{
    const Measurements measured = measure(options);
    if (options.isTable)
    {
        printTable(options, measured);
        return true;
    }
    tools::CsvTable table({"method", "claim", "n", "here", "orb", "paper", "asked", "aim", "holds"});
    bool holds = true;
    for (const std::string& method : options.methods)
    {
        const std::vector<Claim> claims = judge(
            measured, {method, options.orb, options.paper, options.paperSlam, options.dial}, options.numbers);
        print(method, claims);
        for (const Claim& claim : claims)
        {
            table.add({method, claim.what, claim.n ? std::to_string(claim.n) : "", claim.here, claim.orb,
                       claim.paper, claim.asked, claim.aim, words(claim.verdict)});
            holds = holds && (claim.isTime || claim.verdict != Claim::FAILS);
        }
    }
    if (!options.out.empty())
    {
        cv::utils::fs::createDirectories(options.out);
        table.write(options.out + "/claims.csv");
        measured.write(options.out + "/measured.csv");
    }
    return holds;
}

}  // namespace

int main(int argc, char** argv)
{
    return tools::runProgram("aqorb_claims", ABOUT, KEYS, argc, argv,
                             [](const cv::CommandLineParser& parser)
                             { return run(readOptions(parser)) ? 0 : 3; });
}
