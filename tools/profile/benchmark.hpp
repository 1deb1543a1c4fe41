// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef AQORB_BENCHMARK_HPP
#define AQORB_BENCHMARK_HPP

#include <opencv2/aqorb.hpp>

#include <string>
#include <vector>

//! Scene (WIDTHxHEIGHT, drawn), photograph of opencv_extra by its short name, or file.
struct Image
{
    explicit Image(const std::string& spec);

    std::string spec;
    std::string name;  //!< with the size
    cv::Mat pixels;
};

struct Settings
{
    std::vector<std::string> images;
    int nfeatures;
    int repeats;
};

enum Detector
{
    CV_ORB,
    AQORB
};

cv::Ptr<cv::Feature2D> createDetector(Detector detector, int nfeatures);

//! Features of a frame; outputs are kept from frame to frame, as programs do.
struct Features
{
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
};

const int WARM_UP = 3;  //!< frames that --frames runs before those that count

//! Seconds that detectAndCompute takes.
double timeFrame(cv::Feature2D& detector, const cv::Mat& image, Features& features);

double median(std::vector<double> values);

//! A table of Markdown. The first row is the head; the first column is text, the others are numbers.
class Table
{
public:
    explicit Table(const std::string& title, const std::vector<std::string>& head);
    void add(const std::vector<std::string>& row);
    void print() const;

private:
    std::string title;
    std::vector<std::vector<std::string>> rows;
};

// Each prints tables.
void printSetting(const Settings& settings);
void printStages(const Settings& settings);
void printScaling(const Settings& settings, const std::vector<cv::Size>& sizes,
                  const std::vector<int>& numbers);
void printMemory(const Settings& settings);

#endif
