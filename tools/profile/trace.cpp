// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "trace.hpp"

#include <opencv2/core.hpp>

#include <cstdio>
#include <fstream>
#include <map>

namespace
{

//! "virtual void cv::A::f(int) const" is cv::A::f; names of blocks stay as they are.
std::string qualifiedName(std::string name)
{
    const std::string clangs = "(anonymous namespace)";
    for (size_t at; (at = name.find(clangs)) != std::string::npos;)
        name.replace(at, clangs.size(), "{anonymous}");
    const size_t arguments = name.find('(');
    if (arguments == std::string::npos)
        return name;
    name.resize(arguments);
    return name.substr(name.rfind(' ') + 1);
}

//! l,LOCATION,"FILE",LINE,"NAME",FLAGS
std::map<int, std::string> readLocations(const std::string& path)
{
    std::ifstream file(path);
    std::map<int, std::string> names;
    int threads = 0;
    for (std::string line; std::getline(file, line);)
    {
        threads += line.compare(0, 12, "#thread file") == 0;
        int location;
        if (std::sscanf(line.c_str(), "l,%d,", &location) != 1)
            continue;
        const size_t end = line.rfind('"'), begin = line.rfind('"', end - 1) + 1;
        names[location] = qualifiedName(line.substr(begin, end - begin));
    }
    if (threads != 1)
        CV_Error(cv::Error::StsError, cv::format("%s: has %d threads, not 1", path.c_str(), threads));
    return names;
}

}  // namespace

bool TraceRegion::is(const std::string& suffix) const
{
    const size_t size = suffix.size();
    return name == suffix || (name.size() > size + 1 && name.compare(name.size() - size, size, suffix) == 0 &&
                              name.compare(name.size() - size - 2, 2, "::") == 0);
}

double TraceRegion::selfDuration() const
{
    double self = duration;
    for (const TraceRegion& child : children)
        self -= child.duration;
    return self;
}

std::vector<TraceRegion> readTrace(const std::string& location)
{
    const std::map<int, std::string> names = readLocations(location + ".txt");
    const std::string path = location + "-000.txt";
    std::ifstream file(path);
    // b,THREAD,TIME,LOCATION,REGION and e,THREAD,TIME,LOCATION,REGION,DURATION[,skip=COUNT]
    std::vector<TraceRegion> open(1);  // the outermost regions are children of the first
    for (std::string line; std::getline(file, line);)
    {
        int id, thread;
        long long time, region, duration;
        if (std::sscanf(line.c_str(), "b,%d,%lld,%d,%lld", &thread, &time, &id, &region) == 4)
        {
            open.push_back(TraceRegion());
            open.back().name = names.at(id);
        }
        else if (std::sscanf(line.c_str(), "e,%d,%lld,%d,%lld,%lld", &thread, &time, &id, &region,
                             &duration) == 5)
        {
            if (open.size() < 2 || line.find(",skip=") != std::string::npos)
                CV_Error(cv::Error::StsError, path + ": has not all regions, see " + line);
            TraceRegion closed;
            std::swap(closed, open.back());
            closed.duration = double(duration);
            open.pop_back();
            open.back().children.push_back(std::move(closed));
        }
    }
    if (open.size() != 1 || open[0].children.empty())
        CV_Error(cv::Error::StsError, path + ": absent, empty or not complete");
    return open[0].children;
}
