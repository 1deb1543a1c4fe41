// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// Thins out the keypoints of other detectors: the best by response, and the best spread.

#include <opencv2/aqorb.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <cstdio>

using namespace cv;

static const char* const KEYS = "{help h usage ? |                    | print this text }"
                                "{@image         | graf1.png          | image }"
                                "{npoints        | 500                | number of keypoints to keep }"
                                "{out            | retain_uniform.jpg | picture to write }";

static Mat drawn(const Mat& image, const std::vector<KeyPoint>& keypoints, const String& name)
{
    const double u = aqorb::distributionUniformity(keypoints, image.size());
    const double occupied = 100 * aqorb::distributionOccupancy(keypoints, image.size());
    std::printf("%-24s %9d %10.1f %9.0f %%\n", name.c_str(), int(keypoints.size()), u, occupied);
    Mat picture;
    drawKeypoints(image, keypoints, picture, Scalar(0, 255, 255));
    putText(picture, name, Point(10, 25), FONT_HERSHEY_SIMPLEX, 0.75, Scalar(0, 255, 0), 2, LINE_AA);
    return picture;
}

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about(
        "Keeps some keypoints of SIFT and of FAST: by cv::KeyPointsFilter::retainBest, which goes by\n"
        "the response alone, and by cv::aqorb::retainUniform.");
    if (parser.has("help"))
    {
        parser.printMessage();
        return 0;
    }
    const Mat image = imread(samples::findFile(parser.get<String>("@image"), false), IMREAD_GRAYSCALE);
    const int npoints = parser.get<int>("npoints");
    const String out = parser.get<String>("out");
    if (!parser.check() || image.empty())
    {
        parser.printErrors();
        std::fprintf(stderr, "%s", image.empty() ? "The image cannot be read\n" : "");
        return 1;
    }

    const struct
    {
        String name;
        Ptr<Feature2D> detector;
    } detectors[] = {{"SIFT", SIFT::create()}, {"FAST", FastFeatureDetector::create()}};

    std::printf("%-24s %9s %10s %11s\n", "", "keypoints", "uniformity", "occupied");
    Mat rows[2];
    for (int i = 0; i < 2; i++)
    {
        std::vector<KeyPoint> best, uniform;
        detectors[i].detector->detect(image, best);
        uniform = best;
        KeyPointsFilter::retainBest(best, npoints);
        aqorb::retainUniform(uniform, image.size(), npoints);
        const Mat left = drawn(image, best, detectors[i].name + ", retainBest");
        const Mat right = drawn(image, uniform, detectors[i].name + ", retainUniform");
        hconcat(left, right, rows[i]);
    }
    Mat picture;
    vconcat(rows[0], rows[1], picture);
    if (!imwrite(out, picture))
    {
        std::fprintf(stderr, "%s: cannot be written\n", out.c_str());
        return 1;
    }
    std::printf("Picture: %s\n", out.c_str());
    return 0;
}
