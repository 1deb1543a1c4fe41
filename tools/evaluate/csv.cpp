// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "results.hpp"

#include <fstream>

namespace
{

std::ofstream create(const std::string& file, const char* header)
{
    std::ofstream stream(file);
    stream << header << '\n';
    if (!stream)
        CV_Error(cv::Error::StsError, file + ": cannot be written");
    return stream;
}

}  // namespace

void writeCsv(const Results& results, const std::string& folder)
{
    std::ofstream uniformity =
        create(folder + "/uniformity.csv", "set,image,method,n,keypoints,uniformity,occupancy,time_ms");
    for (const FeatureRow& r : results.features)
        uniformity << r.set << ',' << r.image << ',' << r.method << ',' << r.n << ',' << r.keypoints << ','
                   << cv::format("%.2f,%.4f,", r.uniformity, r.occupancy)
                   << (r.milliseconds < 0 ? "" : cv::format("%.3f", r.milliseconds)) << '\n';

    std::ofstream matching =
        create(folder + "/matching.csv",
               "set,pair,method,n,matches,correct,distinct,places,precision,repeatability,corner_error");
    std::ofstream homography = create(folder + "/homography.csv", "set,pair,method,n,seed,corner_error");
    for (const MatchingRow& r : results.matching)
    {
        const std::string row = cv::format("%s,1-%d,%s,%d,", r.set.c_str(), r.image, r.method.c_str(), r.n);
        const Matching& m = r.matching;
        matching << row << m.matches << ',' << m.correct << ',' << m.distinct << ',' << m.places << ','
                 << cv::format("%.4f,%.4f,%.3f", m.precision(), m.repeatability, m.medianError()) << '\n';
        for (size_t seed = 0; seed < m.errors.size(); seed++)
            homography << row << seed + 1 << ',' << cv::format("%.3f", m.errors[seed]) << '\n';
    }

    if (results.odometry.empty())
        return;
    std::ofstream odometry =
        create(folder + "/odometry.csv",
               "method,n,frame,stereo,matches,inliers,translation_error_m,rotation_error_deg");
    for (const OdometryRow& r : results.odometry)
        odometry << r.method << ',' << r.n << ',' << r.frame << ',' << r.stereo << ',' << r.matches << ','
                 << r.inliers << ',' << cv::format("%.5f,%.5f", r.metres, r.degrees) << '\n';
}
