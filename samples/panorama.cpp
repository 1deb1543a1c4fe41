// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

// A panorama by cv::Stitcher, which takes any Feature2D for its features.

#include <opencv2/aqorb.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/stitching.hpp>

#include <iostream>

using namespace cv;

static const char* const USAGE =
    "Stitches overlapping photographs to a panorama.\n\n"
    "Usage: panorama [--scans] [--nfeatures=1500] [--out=panorama.jpg] IMAGE IMAGE ...\n\n"
    "  --scans  the images are views of a plane, not of a turning camera\n";

int main(int argc, char** argv)
{
    const CommandLineParser parser(argc, argv,
                                   "{help h usage ? ||}{scans||}{nfeatures|1500|}{out|panorama.jpg|}");
    std::vector<Mat> images;
    for (int i = 1; i < argc; i++)  // CommandLineParser takes a fixed number of files
    {
        if (argv[i][0] == '-')
            continue;
        images.push_back(imread(samples::findFile(argv[i], false)));
        if (images.back().empty())
        {
            std::cerr << argv[i] << ": not an image that OpenCV can read" << std::endl;
            return 1;
        }
    }
    if (parser.has("help") || images.size() < 2)
    {
        std::cout << USAGE;
        return parser.has("help") ? 0 : 1;
    }

    const Ptr<Stitcher> stitcher =
        Stitcher::create(parser.has("scans") ? Stitcher::SCANS : Stitcher::PANORAMA);
    stitcher->setFeaturesFinder(aqorb::AdaptiveQuadtreeORB::create(parser.get<int>("nfeatures")));
    Mat panorama;
    const Stitcher::Status status = stitcher->stitch(images, panorama);
    if (status != Stitcher::OK)
    {
        std::cerr << (status == Stitcher::ERR_NEED_MORE_IMGS ? "The images do not overlap enough"
                                                             : "The cameras could not be estimated")
                  << std::endl;
        return 1;
    }
    const String out = parser.get<String>("out");
    if (!imwrite(out, panorama))
    {
        std::cerr << out << ": cannot be written" << std::endl;
        return 1;
    }
    std::cout << stitcher->component().size() << " of " << images.size() << " images stitched, "
              << panorama.cols << "x" << panorama.rows << "\nPicture: " << out << std::endl;
    return 0;
}
