// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Measures matching, in turns with cv::BFMatcher, and prints CSV; tools/report/report.py makes the tables of
// doc/performance.md of it, and scripts/performance.sh runs both.

#include "../../test/geometry.hpp"
#include "../../test/data_files.hpp"
#include "../common/csv.hpp"
#include "../common/program.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <functional>
#include <iostream>

using namespace cv;
using aqorb::HammingMatcher;

namespace
{

const char* const ABOUT =
    "Measures matching by HammingMatcher and by cv::BFMatcher in turns, as CSV. One of --matchers, "
    "--program, "
    "--pairs, --scaling and --frequency chooses what. OPENCV_CPU_DISABLE leaves instructions out, for both.\n"
    "Exit codes: 0 done, 1 bad arguments, 2 other.\n";

const char* const KEYS =
    "{help h usage ? |      | print this text }"
    "{matchers       |      | print the times of both matchers for descriptors as they come from two images, "
    "on one "
    "thread; in ms }"
    "{program        |      | print the times of cv::BFMatcher alone, on one thread, which "
    "libaqorb_preload.so may "
    "serve; in ms }"
    "{pairs          |      | print the times of two frames, their matches and the homography, on one "
    "thread; in ms. "
    "Needs OPENCV_TEST_DATA_PATH }"
    "{scaling        |      | print the times of HammingMatcher with one and with two threads; in ms }"
    "{frequency      |      | print the frequency of the CPU in GHz, 0 where it is not known }"
    "{n              | 500,1000,2000,5000 | numbers of descriptors, or of features of --pairs }"
    "{bytes          | 32   | of --matchers and --program: bytes of a descriptor }"
    "{repeats        | 11   | how often each is measured }";

const char* const SETS[] = {"bikes", "leuven", "bark", "trees", "ubc"};

//! The kernels that both can choose among on this CPU.
std::string cpuName()
{
#ifdef CV_CPU_AVX512_ICL
    if (checkHardwareSupport(CV_CPU_AVX512_ICL) && checkHardwareSupport(CV_CPU_AVX512_SKX))
        return "AVX-512 with VPOPCNTDQ";
#endif
    if (checkHardwareSupport(CV_CPU_AVX512_SKX))
        return "AVX-512 without it";
    if (checkHardwareSupport(CV_CPU_AVX2))
        return "AVX2";
    if (checkHardwareSupport(CV_CPU_SSE4_1))
        return "SSE4.1";
    return checkHardwareSupport(CV_CPU_NEON) ? "NEON" : "baseline";
}

double milliseconds(const std::function<void()>& work)
{
    const int64 begin = getTickCount();
    work();
    return double(getTickCount() - begin) * 1000 / getTickFrequency();
}

//! Descriptors of two images, of which 6 of 10 are of the same points: of these some bits differ.
struct Descriptors
{
    Descriptors(int n, int bytes) : query(n, bytes, CV_8UC1), train(n, bytes, CV_8UC1)
    {
        RNG rng(1);
        rng.fill(query, RNG::UNIFORM, 0, 256);
        rng.fill(train, RNG::UNIFORM, 0, 256);
        std::vector<int> order(n);
        for (int i = 0; i < n; i++)
            std::swap(order[i] = i, order[rng.uniform(0, i + 1)]);
        for (int i = 0; i < n; i++)
        {
            const Point2f point(rng.uniform(0.f, 1000.f), rng.uniform(0.f, 700.f));
            positions.push_back(point);
            keypoints.push_back(KeyPoint(Point2f(rng.uniform(0.f, 1000.f), rng.uniform(0.f, 700.f)), 31));
        }
        for (int i = 0; i < n * 6 / 10; i++)
        {
            query.row(i).copyTo(train.row(order[i]));
            keypoints[order[i]].pt = positions[i] + Point2f(rng.uniform(-9.f, 9.f), rng.uniform(-9.f, 9.f));
            for (int j = 0; j < 20; j++)
                train.at<uchar>(order[i], rng.uniform(0, bytes)) ^= uchar(1 << rng.uniform(0, 8));
        }
    }
    void match(const DescriptorMatcher& matcher) { matcher.match(query, train, matches); }
    void matchTwo(const DescriptorMatcher& matcher)
    {
        lists.clear();
        matcher.knnMatch(query, train, lists, 2);
    }

    Mat query, train;
    std::vector<Point2f> positions;
    std::vector<KeyPoint> keypoints;
    // Outputs, which keep their memory.
    std::vector<DMatch> matches;
    std::vector<std::vector<DMatch>> lists;
    Mat pairs, distances;
};

//! What is measured, and the cells of its rows that say so.
struct Work
{
    std::vector<std::string> cells;
    std::function<void()> run;
};

//! Measures works in turns. Adds a row for each time, which ends with the number of the repeat and the milliseconds.
void measure(const std::vector<Work>& works, int repeats, tools::CsvTable& table)
{
    for (int repeat = 0; repeat < repeats; repeat++)
    {
        for (const Work& work : works)
        {
            std::vector<std::string> cells = work.cells;
            cells.insert(cells.begin(), cpuName());
            cells.push_back(std::to_string(repeat));
            cells.push_back(tools::csvNumber(milliseconds(work.run)));
            table.add(cells);
        }
    }
}

tools::CsvTable measureMatchers(const std::vector<int>& numbers, int bytes, int repeats)
{
    setNumThreads(1);
    tools::CsvTable table({"cpu", "n", "bytes", "task", "contender", "repeat", "ms"});
    const BFMatcher cvCross(NORM_HAMMING, true), cvAll(NORM_HAMMING);
    const HammingMatcher ourCross(NORM_HAMMING, true), ourAll(NORM_HAMMING);
    for (const int number : numbers)
    {
        Descriptors d(number, bytes);
        const std::string n = std::to_string(number), b = std::to_string(bytes);
        measure({{{n, b, "cross check", "cv::BFMatcher"}, [&] { d.match(cvCross); }},
                 {{n, b, "cross check", "HammingMatcher"}, [&] { d.match(ourCross); }},
                 {{n, b, "cross check", "matchArrays"},
                  [&] { aqorb::matchArrays(d.query, d.train, d.pairs, d.distances); }},
                 {{n, b, "cross check", "matchByPosition"},
                  [&]
                  {
                      aqorb::matchByPosition(d.query, d.positions, d.train, d.keypoints, Size2f(20, 20),
                                             d.pairs, d.distances);
                  }},
                 {{n, b, "knn 2", "cv::BFMatcher"}, [&] { d.matchTwo(cvAll); }},
                 {{n, b, "knn 2", "HammingMatcher"}, [&] { d.matchTwo(ourAll); }}},
                repeats, table);
    }
    return table;
}

tools::CsvTable measureProgram(const std::vector<int>& numbers, int bytes, int repeats)
{
    setNumThreads(1);
    tools::CsvTable table({"cpu", "n", "task", "repeat", "ms"});
    const BFMatcher all(NORM_HAMMING), cross(NORM_HAMMING, true);
    for (const int number : numbers)
    {
        Descriptors d(number, bytes);
        const std::string n = std::to_string(number);
        measure({{{n, "match"}, [&] { d.match(all); }},
                 {{n, "cross check"}, [&] { d.match(cross); }},
                 {{n, "knn 2"}, [&] { d.matchTwo(all); }}},
                repeats, table);
    }
    return table;
}

tools::CsvTable measureScaling(const std::vector<int>& numbers, int repeats)
{
    tools::CsvTable table({"cpu", "n", "task", "threads", "repeat", "ms"});
    const HammingMatcher cross(NORM_HAMMING, true), all(NORM_HAMMING);
    for (const int number : numbers)
    {
        Descriptors d(number, 32);
        const std::string n = std::to_string(number);
        // Not in turns: a new number of threads makes OpenCV start its threads anew.
        for (const int threads : {1, 2})
        {
            setNumThreads(threads);
            const std::string with = std::to_string(threads);
            measure({{{n, "cross check", with}, [&] { d.match(cross); }}}, repeats, table);
            measure({{{n, "knn 2", with}, [&] { d.matchTwo(all); }}}, repeats, table);
        }
    }
    return table;
}

//! Two images of a set, as grey images.
std::vector<Mat> readPair(const std::string& set)
{
    std::vector<Mat> images;
    for (int index = 1; index <= 2; index++)
    {
        const std::string file = opencv_test::oxfordImage(set, index);
        if (file.empty())
            CV_Error(Error::StsObjectNotFound, "OPENCV_TEST_DATA_PATH is not set");
        images.push_back(imread(file, IMREAD_GRAYSCALE));
        if (images.back().empty())
            CV_Error(Error::StsObjectNotFound, file + " cannot be read");
    }
    return images;
}

// The whole work for two images: features, matches and the homography.
void findHomographyOf(const std::vector<Mat>& images, Feature2D& detector, const DescriptorMatcher& matcher)
{
    std::vector<KeyPoint> keypoints[2];
    Mat descriptors[2];
    for (int i = 0; i < 2; i++)
        detector.detectAndCompute(images[i], noArray(), keypoints[i], descriptors[i]);
    std::vector<DMatch> matches;
    matcher.match(descriptors[0], descriptors[1], matches);
    std::vector<Point2f> from, to;
    for (const DMatch& match : matches)
    {
        from.push_back(keypoints[0][match.queryIdx].pt);
        to.push_back(keypoints[1][match.trainIdx].pt);
    }
    if (matches.size() >= 4)
        findHomography(from, to, RANSAC);
}

tools::CsvTable measurePairs(const std::vector<int>& numbers, int repeats)
{
    setNumThreads(1);
    tools::CsvTable table({"cpu", "set", "n", "contender", "repeat", "ms"});
    const BFMatcher slow(NORM_HAMMING, true);
    const HammingMatcher fast(NORM_HAMMING, true);
    for (const char* set : SETS)
    {
        const std::vector<Mat> images = readPair(set);
        for (const int n : numbers)
        {
            const Ptr<ORB> orb = ORB::create(n), ours = aqorb::AdaptiveQuadtreeORB::create(n);
            const std::string number = std::to_string(n);
            measure(
                {{{set, number, "cv::ORB, cv::BFMatcher"}, [&] { findHomographyOf(images, *orb, slow); }},
                 {{set, number, "aqorb, cv::BFMatcher"}, [&] { findHomographyOf(images, *ours, slow); }},
                 {{set, number, "aqorb, HammingMatcher"}, [&] { findHomographyOf(images, *ours, fast); }}},
                repeats, table);
        }
    }
    return table;
}

// By a chain of additions, which take a cycle each.
tools::CsvTable measureFrequency()
{
    double gigahertz = 0;
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__aarch64__))
    const int ROUNDS = 10000000;
    for (int attempt = 0; attempt < 5; attempt++)
    {
        uint64 sum = 0;
        const double ms = milliseconds(
            [&]
            {
                for (int i = 0; i < ROUNDS; i++)
                {
#if defined(__x86_64__)
                    __asm__ volatile("add $1, %0\n\tadd $1, %0\n\tadd $1, %0\n\tadd $1, %0\n\tadd $1, %0\n\t"
                                     "add $1, %0\n\tadd $1, %0\n\tadd $1, %0\n\t"
                                     : "+r"(sum));
#else
                    __asm__ volatile(
                        "add %0, %0, #1\n\tadd %0, %0, #1\n\tadd %0, %0, #1\n\tadd %0, %0, #1\n\t"
                        "add %0, %0, #1\n\tadd %0, %0, #1\n\tadd %0, %0, #1\n\tadd %0, %0, #1\n\t"
                        : "+r"(sum));
#endif
                }
            });
        gigahertz = std::max(gigahertz, 8. * ROUNDS / ms * 1e-6);
    }
#endif
    tools::CsvTable table({"ghz"});
    table.add({tools::csvNumber(gigahertz)});
    return table;
}

int run(const CommandLineParser& parser)
{
    const std::vector<int> numbers = tools::splitNumbers(parser.get<String>("n"));
    const int repeats = parser.get<int>("repeats"), bytes = parser.get<int>("bytes");
    tools::checkRead(parser);
    if (numbers.empty() || *std::min_element(numbers.begin(), numbers.end()) < 1 || repeats < 1 || bytes < 1)
        throw tools::BadArguments{"--n, --repeats, --bytes: numbers above 0"};
    if (parser.has("matchers") + parser.has("program") + parser.has("pairs") + parser.has("scaling") +
            parser.has("frequency") !=
        1)
        throw tools::BadArguments{
            "one of --matchers, --program, --pairs, --scaling and --frequency; see --help"};
    const tools::CsvTable table = parser.has("matchers")  ? measureMatchers(numbers, bytes, repeats)
                                  : parser.has("program") ? measureProgram(numbers, bytes, repeats)
                                  : parser.has("pairs")   ? measurePairs(numbers, repeats)
                                  : parser.has("scaling") ? measureScaling(numbers, repeats)
                                                          : measureFrequency();
    std::cout << table.text();
    return 0;
}

}  // namespace

int main(int argc, char** argv)
{
    return tools::runProgram("aqorb_matching", ABOUT, KEYS, argc, argv, run);
}
