// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "benchmark.hpp"

#include <opencv2/core/utility.hpp>

#include <iostream>

using namespace cv;

namespace
{

const Size REFERENCE_SIZE(640, 480);
const int REFERENCE_N = 1000;

//! A size and an n with the times of both detectors, a pass each.
struct Case
{
    Size size;
    int nfeatures;
    std::vector<double> times[2];  //!< by detector
    size_t keypoints[2];

    double time(Detector detector) const { return median(times[detector]); }
};

//! Time of a pixel and of a keypoint.
struct Cost
{
    double pixel, keypoint;
    double deviation;  //!< the largest of a case, relative
};

//! Least squares of relative errors: times lie orders of magnitude apart.
Cost fit(const std::vector<Case>& cases, Detector detector)
{
    Mat factors(int(cases.size()), 2, CV_64F), solution;
    for (size_t i = 0; i < cases.size(); i++)
    {
        const double time = cases[i].time(detector);
        factors.at<double>(int(i), 0) = cases[i].size.area() / time;
        factors.at<double>(int(i), 1) = double(cases[i].keypoints[detector]) / time;
    }
    const Mat ones = Mat::ones(factors.rows, 1, CV_64F);
    solve(factors, ones, solution, DECOMP_SVD);
    const Cost cost = {solution.at<double>(0), solution.at<double>(1),
                       norm(factors * solution, ones, NORM_INF)};
    return cost;
}

void timeCase(Case& c, const Mat& image)
{
    for (Detector id : {CV_ORB, AQORB})
    {
        const Ptr<Feature2D> detector = createDetector(id, c.nfeatures);
        Features features;
        timeFrame(*detector, image, features);  // for the memory that a stream of frames has
        c.times[id].push_back(timeFrame(*detector, image, features));
        c.keypoints[id] = features.keypoints.size();
    }
}

std::string relative(double time, double reference)
{
    return format(time < 9.95 * reference ? "%.2f" : "%.1f", time / reference);
}

}  // namespace

void printScaling(const Settings& settings, const std::vector<Size>& sizes, const std::vector<int>& numbers)
{
    setNumThreads(1);
    std::vector<Case> cases;
    std::vector<Mat> images;
    size_t reference = 0;
    for (const Size& size : sizes)
    {
        const Mat image = Image(format("%dx%d", size.width, size.height)).pixels;
        for (int n : numbers)
        {
            if (size == REFERENCE_SIZE && n == REFERENCE_N)
                reference = cases.size();
            Case c = {};
            c.size = size;
            c.nfeatures = n;
            cases.push_back(c);
            images.push_back(image);
        }
    }
    // All cases in each pass, so that a change of the machine's speed meets all alike.
    for (int pass = 0; pass < settings.repeats; pass++)
    {
        for (size_t i = 0; i < cases.size(); i++)
            timeCase(cases[i], images[i]);
    }

    std::vector<std::string> head(1, "size");
    for (int n : numbers)
        head.push_back(format("n = %d", n));
    Table ratios("Speed by size and n", head), growth("Growth", head);
    for (size_t i = 0; i < cases.size(); i += numbers.size())
    {
        std::vector<std::string> ratioRow(1, format("%dx%d", cases[i].size.width, cases[i].size.height));
        std::vector<std::string> growthRow = ratioRow;
        for (size_t j = i; j < i + numbers.size(); j++)
        {
            const Case& c = cases[j];
            // Fewer keypoints than asked for: no such n.
            const char* const mark = c.keypoints[AQORB] < size_t(c.nfeatures) ? "*" : "";
            ratioRow.push_back(format("%.2f%s", c.time(CV_ORB) / c.time(AQORB), mark));
            growthRow.push_back(relative(c.time(AQORB), cases[reference].time(AQORB)) + " (" +
                                relative(c.time(CV_ORB), cases[reference].time(CV_ORB)) + ")" + mark);
        }
        ratios.add(ratioRow);
        growth.add(growthRow);
    }
    ratios.print();
    std::cout << "Time of cv::ORB / time of AdaptiveQuadtreeORB, scenes, one thread. *: fewer than n "
                 "keypoints.\n\n";
    growth.print();
    std::cout << "Time relative to that of 640x480 with n = 1000; in brackets the same of cv::ORB.\n\n";

    const Cost orb = fit(cases, CV_ORB), ours = fit(cases, AQORB);
    Table costs("Cost of a pixel and of a keypoint",
                {"", "a pixel", "a keypoint", "a keypoint in pixels", "largest deviation"});
    costs.add({"cv::ORB", "1", "1", format("%.0f", orb.keypoint / orb.pixel),
               format("%.0f %%", 100 * orb.deviation)});
    costs.add({"AdaptiveQuadtreeORB", format("%.3f", ours.pixel / orb.pixel),
               format("%.3f", ours.keypoint / orb.keypoint), format("%.0f", ours.keypoint / ours.pixel),
               format("%.0f %%", 100 * ours.deviation)});
    costs.print();
}
