// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// What the page's worker calls. The engine holds two pictures, 0 and 1, and the features that both detectors find in
// them. Each function returns an object; if something is wrong, it holds a sentence, `error`, and nothing else.

#include "../../perf/perf_scene.hpp"
#include "../../test/scenes.hpp"
#include "../../tools/fingerprint/lines.hpp"
#include "parameter_table.hpp"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include <emscripten/bind.h>
#include <emscripten/emscripten.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;
using emscripten::val;

namespace
{

const int DETECTORS = 2;      // 0: cv::ORB, 1: AdaptiveQuadtreeORB
const double SAME_PLACE = 3;  // pixels between keypoints that count as one found again, as in tools/evaluate

struct Features
{
    std::vector<KeyPoint> keypoints;
    Mat descriptors;
};

struct Picture
{
    Mat rgba, grey, mask;
    Features features[DETECTORS];
};

Picture pictures[2];
Ptr<ORB> detectors[DETECTORS];
Matx33d motion;        // from picture 0 to picture 1, where the engine made picture 1
bool isKnown = false;  // whether it did

//! A copy, as a typed array: a view would end with the next growth of the memory.
template <typename T> val copied(const std::vector<T>& values)
{
    return val(emscripten::typed_memory_view(values.size(), values.data())).template call<val>("slice");
}

//! Calls a function that returns a val, and turns its exceptions into an error.
template <typename Function> val guarded(Function function)
{
    std::string error;
    try
    {
        return function();
    }
    catch (const cv::Exception& e)
    {
        error = e.err;
    }
    catch (const std::exception& e)
    {
        error = e.what();
    }
    val result = val::object();
    result.set("error", error);
    return result;
}

//! The picture's size and, as RGBA, its pixels.
val shown(const Picture& picture)
{
    val result = val::object();
    result.set("width", picture.rgba.cols);
    result.set("height", picture.rgba.rows);
    result.set(
        "pixels",
        val(emscripten::typed_memory_view(picture.rgba.total() * 4, picture.rgba.data)).call<val>("slice"));
    return result;
}

val setPicture(int index, int width, int height, val pixels)
{
    return guarded(
        [&]
        {
            CV_CheckGT(width, 0, "a picture has pixels");
            CV_CheckGT(height, 0, "a picture has pixels");
            CV_CheckEQ(pixels["length"].as<int>(), width * height * 4, "the length of the pixels");
            Picture& picture = pictures[index] = Picture();
            isKnown = false;
            picture.rgba.create(height, width, CV_8UC4);
            val(emscripten::typed_memory_view(picture.rgba.total() * 4, picture.rgba.data))
                .call<void>("set", pixels);
            cvtColor(picture.rgba, picture.grey, COLOR_RGBA2GRAY);
            return val::object();
        });
}

//! Draws a street as picture 0. The page has photographs; this is for programs that cannot decode one.
val drawScene(int width, int height)
{
    return guarded(
        [&]
        {
            Picture& picture = pictures[0] = Picture();
            picture.grey = opencv_test::makeStreetScene(Size(width, height));
            cvtColor(picture.grey, picture.rgba, COLOR_GRAY2RGBA);
            isKnown = false;
            return shown(picture);
        });
}

//! A turn clockwise about the centre of a picture of one size, which gets to the centre of one of another size.
Matx33d turnBetween(const Size& from, const Size& to, double degrees)
{
    const Point2d centre(.5 * (from.width - 1), .5 * (from.height - 1));
    Matx33d matrix = Matx33d::eye();
    getRotationMatrix2D(centre, -degrees, 1).copyTo(Mat(matrix, false).rowRange(0, 2));
    matrix(0, 2) += .5 * (to.width - from.width);
    matrix(1, 2) += .5 * (to.height - from.height);
    return matrix;
}

//! What a camera in the dark makes of a picture: blurred, with less light, and noisy. It is the same in every run.
void darken(Mat& rgba)
{
    GaussianBlur(rgba, rgba, Size(), 1);
    Mat light, noise(rgba.size(), CV_16SC3);
    cvtColor(rgba, light, COLOR_RGBA2RGB);
    light.convertTo(light, CV_16S, .5);
    RNG rng(1);
    rng.fill(noise, RNG::NORMAL, 0, 4);
    light += noise;
    light.convertTo(light, CV_8U);
    cvtColor(light, rgba, COLOR_RGB2RGBA);
}

/** Picture 1 becomes another view of the plane of picture 0, in a frame of the same size. What picture 0 does not show
 is masked.
 @param name "side": from a camera that has moved to the side and a little nearer; "far": from one that is twice as far
 and rolled; "night": from one that is rolled a little, at night */
val drawOtherView(const std::string& name)
{
    return guarded(
        [&]
        {
            Mat image = pictures[0].rgba;
            const Size size = image.size();
            Matx33d view, shrink = Matx33d::eye();
            if (name == "side")
            {
                const float w = float(size.width), h = float(size.height);
                const Point2f from[] = {{0.f, 0.f}, {w, 0.f}, {w, h}, {0.f, h}};
                const Point2f to[] = {{-.06f * w, .1f * h},
                                      {.92f * w, -.14f * h},
                                      {1.02f * w, 1.04f * h},
                                      {.05f * w, .88f * h}};
                view = Matx33d(getPerspectiveTransform(from, to).ptr<double>());
                view = view * (1 / view(2, 2));  // errorOf takes points in front, and the sign may be either
            }
            else if (name == "far")
            {
                // Means of four pixels first, as warpPerspective takes no means.
                const Size half((size.width + 1) / 2, (size.height + 1) / 2);
                resize(image, image, half, 0, 0, INTER_AREA);
                const double x = double(half.width) / size.width, y = double(half.height) / size.height;
                shrink = Matx33d(x, 0, .5 * x - .5, 0, y, .5 * y - .5, 0, 0, 1);
                view = turnBetween(half, size, 40);
            }
            else if (name == "night")
                view = turnBetween(size, size, 8);
            else
                CV_Error_(Error::StsBadArg, ("There is no view %s", name.c_str()));

            Picture& picture = pictures[1] = Picture();
            // Reflected, because an edge of the picture would be one of the scene for a detector.
            warpPerspective(image, picture.rgba, view, size, INTER_LINEAR, BORDER_REFLECT_101);
            warpPerspective(Mat(image.size(), CV_8UC1, Scalar(255)), picture.mask, view, size, INTER_NEAREST,
                            BORDER_CONSTANT, Scalar(0));
            if (name == "night")
                darken(picture.rgba);
            cvtColor(picture.rgba, picture.grey, COLOR_RGBA2GRAY);
            picture.rgba.setTo(Scalar(90, 90, 90, 255), picture.mask == 0);
            motion = view * shrink;
            isKnown = true;
            return shown(picture);
        });
}

//! Makes both detectors, with the properties that are given. Those of cv::ORB are for both, but the others have
//! defaults of their own.
val setProperties(val properties)
{
    return guarded(
        [&]
        {
            const Ptr<AdaptiveQuadtreeORB> ours = AdaptiveQuadtreeORB::create();
            detectors[0] = ORB::create();
            detectors[1] = ours;
#define AQORB_SET(orb, property, type, name) \
    if (properties.hasOwnProperty(#name))    \
        (orb)->set##property(type(properties[#name].as<double>()));
#define AQORB_SET_OURS(property, type, name, ...) AQORB_SET(ours, property, type, name)
#define AQORB_SET_BOTH(property, type, name, ...) \
    AQORB_SET(ours, property, type, name)         \
    AQORB_SET(detectors[0], property, type, name)
            AQORB_PARAMETERS_OF_ORB(AQORB_SET_BOTH)
            AQORB_OWN_PARAMETERS(AQORB_SET_OURS)
            for (const Ptr<ORB>& detector : detectors)  // a float, as for create
                detector->setScaleFactor(float(detector->getScaleFactor()));
            return val::object();
        });
}

//! How many of nlevels levels have at least one pixel. cv::ORB raises an exception if it is asked for more.
int levelsOf(const Size& size, int nlevels, double scaleFactor)
{
    int levels = 1;
    double side = std::min(size.width, size.height);
    for (; levels < nlevels && side / scaleFactor >= 1; levels++)
        side /= scaleFactor;
    return levels;
}

/** Finds the features of a picture.
 @param runs how often it is called; the time is the shortest */
val detect(int index, int detector, int runs)
{
    return guarded(
        [&]
        {
            Picture& picture = pictures[index];
            Features& features = picture.features[detector];
            detectors[0]->setNLevels(
                levelsOf(picture.grey.size(), detectors[1]->getNLevels(), detectors[1]->getScaleFactor()));
            double time = 0;
            for (int run = 0; run < runs; run++)
            {
                const double start = emscripten_get_now();
                detectors[detector]->detectAndCompute(picture.grey, picture.mask, features.keypoints,
                                                      features.descriptors);
                const double taken = emscripten_get_now() - start;
                time = run == 0 ? taken : std::min(time, taken);
            }
            std::vector<float> keypoints;
            for (const KeyPoint& keypoint : features.keypoints)
                keypoints.insert(keypoints.end(), {keypoint.pt.x, keypoint.pt.y});
            val result = val::object();
            result.set("keypoints", copied(keypoints));
            result.set("count", features.keypoints.size());
            result.set("time", time);
            result.set("uniformity", aqorb::distributionUniformity(features.keypoints, picture.grey.size()));
            result.set("occupancy", aqorb::distributionOccupancy(features.keypoints, picture.grey.size()));
            return result;
        });
}

//! Mutual nearest neighbours, the nearest first.
std::vector<DMatch> matched(int detector)
{
    const Features &a = pictures[0].features[detector], &b = pictures[1].features[detector];
    std::vector<DMatch> matches;
    if (!a.descriptors.empty() && !b.descriptors.empty())
        aqorb::HammingMatcher(NORM_HAMMING, true).match(a.descriptors, b.descriptors, matches);
    std::stable_sort(matches.begin(), matches.end());
    return matches;
}

//! The distance of one point from where a homography maps the other; infinite for one behind the camera.
double errorOf(const Matx33d& homography, const Point2f& from, const Point2f& to)
{
    const Vec3d mapped = homography * Vec3d(from.x, from.y, 1);
    return mapped[2] > 0 ? norm(Point2d(mapped[0] / mapped[2] - to.x, mapped[1] / mapped[2] - to.y))
                         : INFINITY;
}

/** Matches the features of the pictures.
 @param refines whether refineMatches moves the matches to where both pictures show the same, and leaves some out
 @return `homography`, which is found from the matches: nine numbers, or null where fewer than ten agree; `matches`: x
 and y in picture 0, those in picture 1, and whether the match is right; their number, `count`, and that of the right
 ones, `agreeing`, with `medianError` in pixels. They are right by the motion if that is known (`known`), and otherwise
 by the homography. */
val match(int detector, bool refines)
{
    return guarded(
        [&]
        {
            std::vector<Point2f> from, to;
            std::vector<DMatch> pairs = matched(detector);
            const std::vector<KeyPoint>&first = pictures[0].features[detector].keypoints,
                  &second = pictures[1].features[detector].keypoints;
            if (refines)
                aqorb::refineMatches(pictures[0].grey, first, pictures[1].grey, second, pairs, from, to);
            for (size_t i = 0; i < pairs.size() && !refines; i++)
            {
                from.push_back(first[pairs[i].queryIdx].pt);
                to.push_back(second[pairs[i].trainIdx].pt);
            }
            const int FEWEST = 10;
            Matx33d homography;
            if (int(from.size()) >= FEWEST)
            {
                const Mat estimate = findHomography(from, to, USAC_MAGSAC, SAME_PLACE);
                if (!estimate.empty())
                    homography = estimate;
            }
            int inliers = 0;
            for (size_t i = 0; i < from.size(); i++)
                inliers += errorOf(homography, from[i], to[i]) <= SAME_PLACE;
            if (inliers < FEWEST)
                homography = Matx33d();  // with which nothing agrees
            std::vector<float> matches, errors;
            for (size_t i = 0; i < from.size(); i++)
            {
                const double error = errorOf(isKnown ? motion : homography, from[i], to[i]);
                const bool isRight = error <= SAME_PLACE;
                if (isRight)
                    errors.push_back(float(error));
                matches.insert(matches.end(), {from[i].x, from[i].y, to[i].x, to[i].y, isRight ? 1.f : 0.f});
            }
            val result = val::object();
            result.set("matches", copied(matches));
            result.set("count", from.size());
            std::sort(errors.begin(), errors.end());
            result.set("agreeing", errors.size());
            result.set("medianError", errors.empty() ? 0.f : errors[errors.size() / 2]);
            result.set("known", isKnown);
            result.set("homography", inliers >= FEWEST
                                         ? copied(std::vector<double>(homography.val, homography.val + 9))
                                         : val::null());
            return result;
        });
}

/** What aqorb_fingerprint prints of the scenes that it draws, and, if there is a picture 0 and a name, of that as the
 file of this name.
 @return `lines` */
val fingerprint(bool quadtree, const std::string& name)
{
    return guarded(
        [&]
        {
            FingerprintLines lines(quadtree ? AdaptiveQuadtreeORB::QUADTREE_SELECTION
                                            : AdaptiveQuadtreeORB::RANKED_SELECTION);
            std::string text = lines.scenes();
            if (!name.empty())
            {
                Mat image;
                cvtColor(pictures[0].rgba, image, COLOR_RGBA2BGR);
                text += lines.image(name, image);
            }
            val result = val::object();
            result.set("lines", text);
            return result;
        });
}

}  // namespace

EMSCRIPTEN_BINDINGS(aqorb)
{
    emscripten::function("setPicture", &setPicture);
    emscripten::function("drawScene", &drawScene);
    emscripten::function("drawOtherView", &drawOtherView);
    emscripten::function("setProperties", &setProperties);
    emscripten::function("detect", &detect);
    emscripten::function("match", &match);
    emscripten::function("fingerprint", &fingerprint);
}
