// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How the samples draw keypoints, matches and captions: in proportion to the picture. The circles of
// cv::drawKeypoints and cv::drawMatches measure 3 pixels, which cannot be seen on a photograph of 12 megapixels.

#ifndef AQORB_SAMPLES_DRAWING_HPP
#define AQORB_SAMPLES_DRAWING_HPP

#include <opencv2/aqorb/features.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <vector>

const cv::Scalar YELLOW(0, 255, 255), GREEN(0, 255, 0);

//! How much larger circles and letters are than on a picture of 800x640 pixels; at least 1.
inline double drawingScale(cv::Size size)
{
    return std::max(1., std::sqrt(double(size.width) * size.height / (800 * 640)));
}

inline int lineWidth(cv::Size size)
{
    return cvRound(drawingScale(size));
}

//! By which factor a small image is enlarged, so that circles and a caption find room on it.
inline int enlargement(cv::Size size)
{
    const int WIDTH = 400;
    return std::max(1, (WIDTH + size.width - 1) / size.width);
}

//! The image in colour, enlarged.
inline cv::Mat canvas(const cv::Mat& image, int factor)
{
    cv::Mat picture;
    cv::resize(image, picture, cv::Size(), factor, factor, cv::INTER_NEAREST);
    if (picture.channels() == 1)
        cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    return picture;
}

//! Where a position lies on the enlarged image. The centre of a pixel has whole numbers on both.
inline cv::Point2f enlarged(const cv::Point2f& position, int factor)
{
    const cv::Point2f half(0.5f, 0.5f);
    return (position + half) * factor - half;
}

//! A circle at a fraction of a pixel.
inline void drawCircle(cv::Mat& picture, const cv::Point2f& centre, double radius, int width,
                       const cv::Scalar& colour = YELLOW)
{
    const int BITS = 4;  // of the fraction
    cv::circle(picture, cv::Point(centre * (1 << BITS)), cvRound(radius * (1 << BITS)), colour, width,
               cv::LINE_AA, BITS);
}

//! The image with a circle at each keypoint.
inline cv::Mat keypointPicture(const cv::Mat& image, const std::vector<cv::KeyPoint>& keypoints)
{
    const int factor = enlargement(image.size());
    cv::Mat picture = canvas(image, factor);
    for (const cv::KeyPoint& keypoint : keypoints)
        drawCircle(picture, enlarged(keypoint.pt, factor), 3 * drawingScale(picture.size()),
                   lineWidth(picture.size()));
    return picture;
}

/** Two images side by side, darker, with a line for each match, and the outline of an area of the second where
 its corners are given. */
inline cv::Mat matchPicture(const cv::Mat& image1, const std::vector<cv::KeyPoint>& keypoints1,
                            const cv::Mat& image2, const std::vector<cv::KeyPoint>& keypoints2,
                            const std::vector<cv::DMatch>& matches,
                            const std::vector<cv::Point2f>& area = std::vector<cv::Point2f>())
{
    const int factor = std::min(enlargement(image1.size()), enlargement(image2.size()));
    const cv::Mat left = canvas(image1 * 0.6, factor), right = canvas(image2 * 0.6, factor);
    cv::Mat picture(std::max(left.rows, right.rows), left.cols + right.cols, CV_8UC3, cv::Scalar::all(255));
    left.copyTo(picture(cv::Rect(cv::Point(0, 0), left.size())));
    right.copyTo(picture(cv::Rect(cv::Point(left.cols, 0), right.size())));

    const cv::Size size(std::max(left.cols, right.cols), picture.rows);
    const cv::Point2f shift(float(left.cols), 0);
    // Hundreds of lines would hide the images, so the lines are translucent. The circles at their ends are not.
    cv::Mat lines = picture.clone();
    for (const cv::DMatch& match : matches)
        cv::line(lines, enlarged(keypoints1[match.queryIdx].pt, factor),
                 enlarged(keypoints2[match.trainIdx].pt, factor) + shift, YELLOW, lineWidth(size),
                 cv::LINE_AA);
    cv::addWeighted(lines, 0.4, picture, 0.6, 0, picture);
    for (const cv::DMatch& match : matches)
        for (const cv::Point2f& end : {enlarged(keypoints1[match.queryIdx].pt, factor),
                                       enlarged(keypoints2[match.trainIdx].pt, factor) + shift})
            drawCircle(picture, end, 3 * drawingScale(size), lineWidth(size));
    std::vector<cv::Point> outline;
    for (const cv::Point2f& corner : area)
        outline.push_back(enlarged(corner, factor) + shift);
    if (!outline.empty())
        cv::polylines(picture, outline, true, GREEN, 2 * lineWidth(size), cv::LINE_AA);
    return picture;
}

//! The picture with a line of text above it, in letters that fit its width.
inline cv::Mat captioned(const cv::Mat& picture, const cv::String& text,
                         const cv::Scalar& colour = cv::Scalar::all(0))
{
    const int font = cv::FONT_HERSHEY_SIMPLEX;
    const double largest = 0.75 * drawingScale(picture.size());
    const int width = cv::getTextSize(text, font, 1, 1, nullptr).width;
    const double scale = std::min(largest, 0.94 * picture.cols / width);
    const int height = cvRound(48 * largest), thickness = std::max(1, cvRound(1.3 * scale));
    cv::Mat result;
    cv::copyMakeBorder(picture, result, height, 0, 0, 0, cv::BORDER_CONSTANT, cv::Scalar::all(255));
    cv::putText(result, text, cv::Point(cvRound(0.02 * picture.cols), height - cvRound(15 * largest)), font,
                scale, colour, thickness, cv::LINE_AA);
    return result;
}

#endif
