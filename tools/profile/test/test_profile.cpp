// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The profile of a trace that was made up, so that every number is known.

#include "../critical_path.hpp"
#include "../profile.hpp"

#include <opencv2/core/utility.hpp>

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

namespace
{

//! A trace's files while it lives.
class TraceFiles
{
public:
    TraceFiles(const std::string& locations, const std::string& events) : location(cv::tempfile())
    {
        std::ofstream(location + ".txt") << locations;
        std::ofstream(location + "-000.txt") << events;
    }
    ~TraceFiles()
    {
        std::remove((location + ".txt").c_str());
        std::remove((location + "-000.txt").c_str());
    }
    const std::string location;
};

const char* const LOCATIONS =
    "#thread file: x-000.txt\n"
    "l,1,\"a.cpp\",1,\"virtual void cv::aqorb::AdaptiveQuadtreeORBImpl::detectAndCompute(InputArray, "
    "int)\",0x3\n"
    "l,2,\"a.cpp\",2,\"double cv::aqorb::stages::varianceOverMean(const cv::Mat&, const cv::Mat&)\",0x3\n"
    "l,3,\"a.cpp\",3,\"search\",0x1\n"
    "l,4,\"a.cpp\",4,\"order\",0x0\n"
    "l,5,\"a.cpp\",5,\"void cv::aqorb::stages::BandSearch::find(const Level&, const cv::Rect&)\",0x3\n"
    "l,6,\"a.cpp\",6,\"void cv::aqorb::stages::harrisResponses(int)\",0x3\n"
    "l,7,\"a.cpp\",7,\"select\",0x3\n"
    "l,8,\"a.cpp\",8,\"void cv::aqorb::(anonymous namespace)::orderByRank(const std::vector<int>&, int "
    "(*)(int))\",0x3\n"
    "l,9,\"a.cpp\",9,\"void cv::aqorb::stages::fillLevel(int)\",0x3\n"
    "l,10,\"a.cpp\",10,\"void cv::aqorb::stages::resizeExact(int)\",0x3\n";

// 1000 ns: 50 threshold, 100 pyramid, 400 search, 200 order, 200 selection, 50 rest.
const char* const EVENTS =
    "b,0,0,1,1\n"
    "b,0,0,2,2\ne,0,50,2,2,50\n"
    "b,0,50,9,3\nb,0,60,10,4\ne,0,140,10,4,80\ne,0,150,9,3,100\n"
    "b,0,150,3,5\nb,0,150,5,6\ne,0,540,5,6,390\ne,0,550,3,5,400\n"
    "b,0,550,4,7\nb,0,570,8,8\nb,0,600,6,9\ne,0,700,6,9,100\ne,0,750,8,8,180\ne,0,750,4,7,200\n"
    "b,0,760,7,10\nb,0,800,6,11\ne,0,830,6,11,30\ne,0,960,7,10,200\n"
    "e,0,1000,1,1,1000\n";

TEST(Aqorb_Profile, shares_the_time_of_a_frame_among_stages)
{
    const TraceFiles files(LOCATIONS, EVENTS);
    const std::vector<TraceRegion> frames = readTrace(files.location);
    ASSERT_EQ(1u, frames.size());
    EXPECT_EQ("cv::aqorb::AdaptiveQuadtreeORBImpl::detectAndCompute", frames[0].name);
    const Profile profile = profileOf(frames[0]);
    EXPECT_EQ(1000, profile.total);
    EXPECT_EQ(50, profile.stages[THRESHOLD]);
    EXPECT_EQ(100, profile.stages[PYRAMID]);
    EXPECT_EQ(390, profile.stages[FAST]);
    EXPECT_EQ(80, profile.stages[RANKING]);
    EXPECT_EQ(100, profile.stages[HARRIS]);  // what selection calls is its own
    EXPECT_EQ(200, profile.stages[SELECTION]);
    EXPECT_EQ(10 + 20 + 50, profile.stages[REST]);
}

// Two chains from the first task to the last one, of 1 + 2 + 4 + 1 and 1 + 3 + 1, and a task of 6 by itself.
const std::vector<DoneTask> TASKS = {{1, {}}, {2, {0}}, {4, {1}}, {3, {0}}, {1, {2, 3}}, {6, {}}};

TEST(Aqorb_Profile, knows_the_least_time_of_threads)
{
    EXPECT_EQ(17, workOf(TASKS));
    EXPECT_EQ(8, longestPath(TASKS));
    EXPECT_EQ(17, leastTime(TASKS, 1));
    EXPECT_EQ(8.5, leastTime(TASKS, 2));  // a share of the work
    EXPECT_EQ(8, leastTime(TASKS, 3));    // the longest path
    EXPECT_EQ(8, leastTime(TASKS, 0));
}

TEST(Aqorb_Profile, knows_the_time_of_a_queue)
{
    EXPECT_EQ(17, queueTime(TASKS, 1));
    // The second thread takes the task of 6 at once, as nothing else is ready; then the first one does all others.
    EXPECT_EQ(10, queueTime(TASKS, 2));
    EXPECT_EQ(8, queueTime(TASKS, 3));
    EXPECT_EQ(0, queueTime({}, 2));
}

TEST(Aqorb_Profile, a_queue_takes_ready_tasks_in_their_order)
{
    // Three tasks without inputs on two threads: the third one begins when the first one ends, not before.
    EXPECT_EQ(7, queueTime({{2, {}}, {3, {}}, {5, {}}}, 2));
    // A thread does not wait for a task that comes first but is not ready yet.
    EXPECT_EQ(6, queueTime({{4, {}}, {2, {0}}, {2, {}}, {2, {}}}, 2));
}

TEST(Aqorb_Profile, names_the_stages_that_a_trace_lacks)
{
    const TraceFiles files(LOCATIONS, EVENTS);
    const std::vector<std::string> absent = absentStages(readTrace(files.location));
    EXPECT_EQ(0, std::count(absent.begin(), absent.end(), "orderByRank"));
    EXPECT_EQ(1, std::count(absent.begin(), absent.end(), "computeDescriptors"));
}

TEST(Aqorb_Profile, refuses_a_trace_that_is_not_whole)
{
    const TraceFiles skipping(LOCATIONS, "b,0,0,1,1\ne,0,9,1,1,9,skip=1\n");
    EXPECT_THROW(readTrace(skipping.location), cv::Exception);
    const TraceFiles open(LOCATIONS, "b,0,0,1,1\nb,0,0,2,2\ne,0,50,2,2,50\n");
    EXPECT_THROW(readTrace(open.location), cv::Exception);
    const TraceFiles twoThreads(std::string(LOCATIONS) + "#thread file: x-001.txt\n", EVENTS);
    EXPECT_THROW(readTrace(twoThreads.location), cv::Exception);
    EXPECT_THROW(readTrace("/absent"), cv::Exception);
}

}  // namespace
