// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The profile of a trace that was made up, so that every number is known.

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
    "l,3,\"a.cpp\",3,\"parallel_for\",0x1\n"
    "l,4,\"a.cpp\",4,\"level\",0x0\n"
    "l,5,\"a.cpp\",5,\"void cv::aqorb::stages::BandSearch::find(const Level&, const cv::Rect&)\",0x3\n"
    "l,6,\"a.cpp\",6,\"void cv::aqorb::stages::harrisResponses(int)\",0x3\n"
    "l,7,\"a.cpp\",7,\"select\",0x0\n"
    "l,8,\"a.cpp\",8,\"void cv::aqorb::(anonymous namespace)::orderByRank(const std::vector<int>&, int "
    "(*)(int))\",0x3\n"
    "l,9,\"a.cpp\",9,\"void cv::aqorb::Workspace::makeLevel(int)\",0x3\n"
    "l,10,\"a.cpp\",10,\"void cv::aqorb::stages::resizeExact(int)\",0x3\n";

// 1000 ns: 50 threshold, 100 pyramid, 2 tasks of 400 and 200, 200 selection, 50 rest.
const char* const EVENTS =
    "b,0,0,1,1\n"
    "b,0,0,2,2\ne,0,50,2,2,50\n"
    "b,0,50,9,3\nb,0,60,10,4\ne,0,140,10,4,80\ne,0,150,9,3,100\n"
    "b,0,150,3,5\n"
    "b,0,150,4,6\nb,0,150,5,7\nb,0,250,6,8\ne,0,300,6,8,50\ne,0,550,5,7,400\ne,0,550,4,6,400\n"
    "b,0,550,4,9\nb,0,570,5,10\ne,0,750,5,10,180\ne,0,750,4,9,200\n"
    "e,0,760,3,5,610\n"
    "b,0,760,7,11\nb,0,800,8,12\ne,0,830,8,12,30\ne,0,960,7,11,200\n"
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
    EXPECT_EQ(350 + 180, profile.stages[FAST]);
    EXPECT_EQ(50, profile.stages[HARRIS]);
    EXPECT_EQ(0, profile.stages[QUADTREE]);  // what selection calls is its own
    EXPECT_EQ(200, profile.stages[SELECTION]);
    EXPECT_EQ(20 + 10 + 40, profile.stages[REST]);
}

TEST(Aqorb_Profile, knows_the_least_time_of_threads)
{
    const TraceFiles files(LOCATIONS, EVENTS);
    const TraceRegion frame = readTrace(files.location)[0];
    EXPECT_EQ(400, serialTime(frame));
    EXPECT_EQ(1000, leastTime(frame, 1));
    EXPECT_EQ(800, leastTime(frame, 2));  // the longest task
    EXPECT_EQ(800, leastTime(frame, 0));
}

TEST(Aqorb_Profile, knows_the_least_time_of_tasks_that_are_split_again)
{
    // A task of 10, and one of 90 with 60 in two halves.
    const TraceFiles files(LOCATIONS, "b,0,0,3,1\n"
                                      "b,0,0,4,2\ne,0,10,4,2,10\n"
                                      "b,0,10,4,3\nb,0,40,3,4\n"
                                      "b,0,40,5,5\ne,0,70,5,5,30\nb,0,70,5,6\ne,0,100,5,6,30\n"
                                      "e,0,100,3,4,60\ne,0,100,4,3,90\ne,0,100,3,1,100\n");
    const TraceRegion region = readTrace(files.location)[0];
    EXPECT_EQ(0, serialTime(region));
    EXPECT_EQ(100, leastTime(region, 1));
    EXPECT_EQ(60, leastTime(region, 2));
    EXPECT_EQ(60, leastTime(region, 0));
}

// Two levels: the fine one is made at 10, the coarse one at 45, and the thresholds are known at 40.
TEST(Aqorb_Profile, knows_the_longest_chain_of_a_frames_tasks)
{
    const std::string locations = "#thread file: x-000.txt\n"
                                  "l,1,\"a.cpp\",1,\"parallel_for\",0x1\n"
                                  "l,2,\"a.cpp\",2,\"parallel_for_body\",0x1\n"
                                  "l,3,\"a.cpp\",3,\"measure\",0x0\nl,4,\"a.cpp\",4,\"make\",0x0\n"
                                  "l,5,\"a.cpp\",5,\"search\",0x0\nl,6,\"a.cpp\",6,\"order\",0x0\n"
                                  "l,7,\"a.cpp\",7,\"select\",0x0\nl,8,\"a.cpp\",8,\"describe\",0x0\n";
    const int tasks[][2] = {{3, 40}, {4, 10}, {4, 35}, {5, 30}, {6, 7},   {7, 2},
                            {5, 50}, {5, 60}, {6, 8},  {7, 3},  {8, 100}, {8, 90}};
    std::string events = "b,0,0,1,1\nb,0,0,2,2\n";
    int now = 0, region = 3;
    for (const auto& task : tasks)
    {
        events += cv::format("b,0,%d,%d,%d\n", now, task[0], region);
        now += task[1];
        events += cv::format("e,0,%d,%d,%d,%d\n", now, task[0], region++, task[1]);
    }
    events += cv::format("e,0,%d,2,2,%d\ne,0,%d,1,1,%d\n", now, now, now, now);
    const TraceFiles files(locations, events);
    const TraceRegion frame = readTrace(files.location)[0];
    // The coarse level is selected at 45 + 30 + 7 + 2, the fine one at 40 + 60 + 8 + 3.
    EXPECT_EQ(111 + 90, leastTime(frame, 0));
    EXPECT_EQ(435, now);
    EXPECT_EQ(435, leastTime(frame, 1));
    EXPECT_EQ(435. / 2, leastTime(frame, 2));
    EXPECT_EQ(201, leastTime(frame, 4));
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
