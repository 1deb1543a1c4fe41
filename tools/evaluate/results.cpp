// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "results.hpp"

#include "../common/csv.hpp"
#include "../common/median.hpp"

#include <opencv2/core/utility.hpp>

using tools::csvNumber;
using tools::CsvTable;

namespace
{

CsvTable settingTable()
{
    CsvTable table({"name", "value"});
    table.add({"OpenCV", CV_VERSION});
    table.add({"CPU features", cv::getCPUFeaturesLine()});
    return table;
}

CsvTable methodTable(const Results& results)
{
    CsvTable table({"method", "role", "text"});
    for (const std::string& method : results.methods)
        table.add({method, "method", results.titles.at(method)});
    for (const Ablation& ablation : results.ablations)
        table.add({ablation.name, "ablation", ablation.but});
    for (const auto& absent : results.absent)
        table.add({absent.first, "absent", absent.second});
    return table;
}

CsvTable featureTable(const std::vector<FeatureRow>& rows)
{
    CsvTable table({"set", "image", "method", "n", "keypoints", "uniformity", "occupancy", "time_ms"});
    for (const FeatureRow& r : rows)
        table.add({r.set, std::to_string(r.image), r.method, std::to_string(r.n), std::to_string(r.keypoints),
                   csvNumber(r.uniformity), csvNumber(r.occupancy),
                   r.milliseconds < 0 ? "" : csvNumber(r.milliseconds)});
    return table;
}

CsvTable matchingTable(const std::vector<MatchingRow>& rows)
{
    CsvTable table({"set", "pair", "method", "n", "matches", "correct", "distinct", "places", "precision",
                    "repeatability", "corner_error"});
    for (const MatchingRow& r : rows)
    {
        const Matching& m = r.matching;
        table.add({r.set, cv::format("1-%d", r.image), r.method, std::to_string(r.n),
                   std::to_string(m.matches), std::to_string(m.correct), std::to_string(m.distinct),
                   std::to_string(m.places), csvNumber(m.precision()), csvNumber(m.repeatability),
                   csvNumber(tools::median(m.errors))});
    }
    return table;
}

CsvTable homographyTable(const std::vector<MatchingRow>& rows)
{
    CsvTable table({"set", "pair", "method", "n", "seed", "corner_error"});
    for (const MatchingRow& r : rows)
        for (size_t seed = 0; seed < r.matching.errors.size(); seed++)
            table.add({r.set, cv::format("1-%d", r.image), r.method, std::to_string(r.n),
                       std::to_string(seed + 1), csvNumber(r.matching.errors[seed])});
    return table;
}

//! The cells of the errors are empty where no motion was found.
CsvTable odometryTable(const std::vector<OdometryRow>& rows)
{
    CsvTable table({"method", "n", "frame", "stereo", "matches", "inliers", "translation_error_m",
                    "rotation_error_deg"});
    for (const OdometryRow& r : rows)
    {
        const OdometryStep& step = r.step;
        table.add({r.method, std::to_string(r.n), std::to_string(r.frame), std::to_string(step.points),
                   std::to_string(step.matches), std::to_string(step.inliers),
                   step.found ? csvNumber(step.metres) : "", step.found ? csvNumber(step.degrees) : ""});
    }
    return table;
}

}  // namespace

void writeCsv(const Results& results, const std::string& folder)
{
    settingTable().write(folder + "/setting.csv");
    methodTable(results).write(folder + "/methods.csv");
    featureTable(results.features).write(folder + "/uniformity.csv");
    matchingTable(results.matching).write(folder + "/matching.csv");
    homographyTable(results.matching).write(folder + "/homography.csv");
    if (!results.odometry.empty())
        odometryTable(results.odometry).write(folder + "/odometry.csv");
}
