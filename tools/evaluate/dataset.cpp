// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "dataset.hpp"

#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <fstream>

namespace
{

const int IMAGES = 6;

cv::Mat readImage(const std::string& stem, int flags)
{
    for (const char* extension : {".png", ".ppm", ".pgm", ".jpg"})
        if (cv::utils::fs::exists(stem + extension))
            return cv::imread(stem + extension, flags);
    return cv::Mat();
}

//! A homography or a fundamental matrix.
cv::Mat readMatrix(const std::string& stem)
{
    cv::Mat homography;
    if (cv::utils::fs::exists(stem + ".xml"))
        cv::FileStorage(stem + ".xml", cv::FileStorage::READ).getFirstTopLevelNode() >> homography;
    else
    {
        std::ifstream file(stem);
        cv::Mat1d numbers(3, 3);
        for (double& number : numbers)
            file >> number;
        if (file)
            homography = numbers;
    }
    return homography;
}

}  // namespace

ImageSet readSet(const std::string& folder, const std::string& name, int flags)
{
    ImageSet set;
    set.name = name;
    for (int i = 1; i <= IMAGES; i++)
    {
        const std::string path = folder + "/" + name + "/", pair = path + cv::format("H1to%dp", i);
        set.images.push_back(readImage(path + cv::format("img%d", i), flags));
        set.homographies.push_back(i == 1 ? cv::Mat(cv::Mat::eye(3, 3, CV_64F)) : readMatrix(pair));
        if (set.images.back().empty())
            CV_Error(cv::Error::StsObjectNotFound, path + cv::format("img%d: no such image", i));
        if (set.homographies.back().empty())
            CV_Error(cv::Error::StsObjectNotFound, pair + ": no such homography");
    }
    return set;
}

ScaledImage scaleImage(const cv::Mat& image, double scale)
{
    ScaledImage scaled;
    cv::resize(image, scaled.image, cv::Size(), scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
    // Coordinates count from the middle of a pixel.
    const double shift = (scale - 1) / 2;
    scaled.homography = cv::Mat(cv::Matx33d(scale, 0, shift, 0, scale, shift, 0, 0, 1));
    return scaled;
}

std::vector<std::string> degradations()
{
    return {"dark", "gamma", "noise", "blur", "shrunk", "enlarged"};
}

ImageSet degrade(const ImageSet& set, const std::string& degradation)
{
    ImageSet worse = set;
    worse.name += "/" + degradation;
    for (size_t i = 0; i < set.images.size(); i++)
    {
        cv::Mat& image = worse.images[i];
        image = set.images[i].clone();
        if (degradation == "dark")
            image.convertTo(image, -1, 0.12);
        else if (degradation == "gamma")
        {
            cv::Mat1b table(1, 256);
            for (int v = 0; v < 256; v++)
                table(v) = cv::saturate_cast<uchar>(255 * std::pow(v / 255., 2.5));
            cv::LUT(image, table, image);
        }
        else if (degradation == "noise")
        {
            cv::Mat noise(image.size(), CV_16SC(image.channels()));
            cv::RNG(i + 1).fill(noise, cv::RNG::NORMAL, 0, 15);
            cv::add(image, noise, image, cv::noArray(), CV_8U);
        }
        else if (degradation == "blur")
            cv::GaussianBlur(image, image, cv::Size(), 2);
        else if (degradation == "shrunk" || degradation == "enlarged")
        {
            const double scale = degradation == "shrunk" ? 0.7 : 1.4;
            if (i == 0)
                continue;
            const ScaledImage scaled = scaleImage(set.images[i], scale);
            image = scaled.image;
            // A new matrix: the set's own stays as it is.
            const cv::Mat homography = scaled.homography * set.homographies[i];
            worse.homographies[i] = homography;
        }
        else
            CV_Error(cv::Error::StsBadArg, degradation + ": no such degradation");
    }
    return worse;
}

std::vector<ImagePair> readPairs(const std::string& folder)
{
    std::vector<cv::String> images;
    cv::glob(folder + "/img1.*", images, true);
    std::sort(images.begin(), images.end());
    std::vector<ImagePair> pairs;
    for (const std::string& image : images)
    {
        const std::string path = image.substr(0, image.find_last_of('/')) + "/";
        ImagePair pair;
        pair.name = path.substr(path.find_last_of('/', path.size() - 2) + 1);
        pair.name.pop_back();
        pair.first = readImage(path + "img1", cv::IMREAD_GRAYSCALE);
        pair.second = readImage(path + "img2", cv::IMREAD_GRAYSCALE);
        pair.homography = readMatrix(path + "H1to2p");
        pair.fundamental = readMatrix(path + "F1to2p");
        if (pair.first.empty() || pair.second.empty() || pair.homography.empty() == pair.fundamental.empty())
            CV_Error(cv::Error::StsObjectNotFound, path + ": needs img1, img2 and either H1to2p or F1to2p");
        pairs.push_back(pair);
    }
    if (pairs.empty())
        CV_Error(cv::Error::StsObjectNotFound, folder + ": no pairs of images below it");
    return pairs;
}
