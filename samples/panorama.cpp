// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// A panorama by cv::Stitcher, which takes any Feature2D for its features, and any matcher for their descriptors.

#include <opencv2/aqorb.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/stitching.hpp>

#include <iostream>
#include <set>

using namespace cv;

//! Finds the matches of two images that pass the ratio test in one direction at least, as OpenCV's own matcher does.
class HammingPairs : public detail::FeaturesMatcher
{
public:
    explicit HammingPairs(float matchConf) : FeaturesMatcher(true), ratio(1 - matchConf) {}

private:
    void match(const detail::ImageFeatures& first, const detail::ImageFeatures& second,
               detail::MatchesInfo& info) CV_OVERRIDE
    {
        std::set<std::pair<int, int>> found;
        info.matches.clear();
        for (const bool isBack : {false, true})
        {
            Mat pairs, distances;
            aqorb::matchArrays((isBack ? second : first).descriptors, (isBack ? first : second).descriptors,
                               pairs, distances, ratio, false);
            for (int i = 0; i < pairs.rows; i++)
            {
                const int query = pairs.at<int>(i, isBack), train = pairs.at<int>(i, !isBack);
                if (found.insert(std::make_pair(query, train)).second)
                    info.matches.push_back(DMatch(query, train, float(distances.at<int>(i))));
            }
        }
    }

    const double ratio;
};

//! BestOf2NearestMatcher, which estimates a homography from the matches, with HammingPairs for the matches.
class HammingFeaturesMatcher : public detail::BestOf2NearestMatcher
{
public:
    explicit HammingFeaturesMatcher(float matchConf = 0.3f) : BestOf2NearestMatcher(false, matchConf)
    {
        impl_ = makePtr<HammingPairs>(matchConf);
    }
};

static const char* const KEYS =
    "{help      |              | print this text }"
    "{nfeatures | 1500         | number of keypoints to ask for }"
    "{scans     |              | the images are views of a plane, not of a turning camera }"
    "{out       | panorama.jpg | picture to write }";

int main(int argc, char** argv)
{
    CommandLineParser parser(argc, argv, KEYS);
    parser.about("Stitches two or more overlapping photographs to a panorama:\n"
                 "  panorama --out=hills.jpg left.jpg middle.jpg right.jpg");
    std::vector<Mat> images;
    for (int i = 1; i < argc; i++)
    {
        if (argv[i][0] == '-')
            continue;
        images.push_back(imread(argv[i]));
        if (images.back().empty())
        {
            std::cerr << argv[i] << ": cannot be read as an image\n";
            return 1;
        }
    }
    const Ptr<ORB> detector = aqorb::AdaptiveQuadtreeORB::create(parser.get<int>("nfeatures"));
    const String out = parser.get<String>("out");
    if (parser.has("help") || !parser.check() || images.size() < 2)
    {
        parser.printErrors();
        parser.printMessage();
        return !parser.has("help");
    }

    const Ptr<Stitcher> stitcher =
        Stitcher::create(parser.has("scans") ? Stitcher::SCANS : Stitcher::PANORAMA);
    stitcher->setFeaturesFinder(detector);
    if (!parser.has("scans"))  // these are matched under an affine map
        stitcher->setFeaturesMatcher(makePtr<HammingFeaturesMatcher>());
    Mat panorama;
    Stitcher::Status status = Stitcher::ERR_HOMOGRAPHY_EST_FAIL;
    try
    {
        status = stitcher->stitch(images, panorama);
    }
    catch (const cv::Exception&)  // an assertion, for example where hardly anything matches
    {
    }
    if (status != Stitcher::OK)
    {
        std::cerr << (status == Stitcher::ERR_NEED_MORE_IMGS ? "the images do not overlap enough\n"
                                                             : "the cameras could not be estimated\n");
        return 1;
    }
    std::cout << stitcher->component().size() << " of " << images.size() << " images stitched, "
              << panorama.cols << "x" << panorama.rows << std::endl;
    if (!imwrite(out, panorama))
        return 1;
    std::cout << "Picture: " << out << '\n';
    return 0;
}
