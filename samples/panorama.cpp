// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Makes a panorama by cv::Stitcher, which takes any Feature2D and any matcher.

#include "sample.hpp"

#include <opencv2/aqorb.hpp>
#include <opencv2/stitching.hpp>

#include <set>

using namespace cv;

//! Finds matches that pass the ratio test in at least one direction, as OpenCV's own matcher does.
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

//! BestOf2NearestMatcher, which estimates a homography, or AffineBestOf2NearestMatcher, which estimates an affine map,
//! with the matches of HammingPairs.
template <typename Estimator> class HammingFeaturesMatcher : public Estimator
{
public:
    explicit HammingFeaturesMatcher(float matchConf = 0.3f)
    {
        this->impl_ = makePtr<HammingPairs>(matchConf);
    }
};

static const char* const ABOUT = "Stitches two or more overlapping photographs to a panorama:\n"
                                 "  panorama --out=hills.jpg left.jpg middle.jpg right.jpg";

static const char* const KEYS =
    "{help      |              | print this text }"
    "{nfeatures | 1500         | number of keypoints to ask for }"
    "{scans     |              | the images are views of a plane, not of a turning camera }"
    "{out       | panorama.jpg | picture to write }";

static int panorama(int argc, char** argv)
{
    const CommandLineParser parser = parseOptions(argc, argv, KEYS, ABOUT);
    const String out = pictureOption(parser);
    std::vector<Mat> images;
    for (const String& file : fileArguments(argc, argv))
        images.push_back(readImage(file, IMREAD_COLOR));
    if (images.size() < 2)
        CV_Error(Error::StsBadArg, "two images or more are needed; --help says how to name them");

    const Ptr<aqorb::AdaptiveQuadtreeORB> detector =
        aqorb::AdaptiveQuadtreeORB::create(option<int>(parser, "nfeatures"));
    const bool isPlane = parser.has("scans");
    const Ptr<Stitcher> stitcher = Stitcher::create(isPlane ? Stitcher::SCANS : Stitcher::PANORAMA);
    if (isPlane)
    {
        detector->setStrengthWeight(1);  // joins more scans than the default
        stitcher->setFeaturesMatcher(makePtr<HammingFeaturesMatcher<detail::AffineBestOf2NearestMatcher>>());
    }
    else
        stitcher->setFeaturesMatcher(makePtr<HammingFeaturesMatcher<detail::BestOf2NearestMatcher>>());
    stitcher->setFeaturesFinder(detector);
    Mat picture;
    Stitcher::Status status = Stitcher::ERR_HOMOGRAPHY_EST_FAIL;
    try
    {
        status = stitcher->stitch(images, picture);
    }
    catch (const cv::Exception&)  // an assertion, for example with hardly any matches
    {
    }
    size_t smallest = images[0].total();
    for (const Mat& image : images)
        smallest = std::min(smallest, image.total());
    if (status == Stitcher::OK &&
        picture.total() < smallest)  // impossible cameras fold the images to less than one
        status = Stitcher::ERR_CAMERA_PARAMS_ADJUST_FAIL;
    if (status != Stitcher::OK)
        CV_Error(Error::StsNoConv, status == Stitcher::ERR_NEED_MORE_IMGS
                                       ? "the images do not overlap enough"
                                       : "the cameras could not be estimated");
    std::cout << stitcher->component().size() << " of " << images.size() << " images stitched, "
              << picture.cols << "x" << picture.rows << std::endl;
    writePicture(out, picture);
    return 0;
}

int main(int argc, char** argv)
{
    return runSample(panorama, argc, argv);
}
