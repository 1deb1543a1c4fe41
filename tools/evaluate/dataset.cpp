// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "dataset.hpp"

#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/imgcodecs.hpp>

#include <fstream>

namespace
{

const int IMAGES = 6;

cv::Mat readImage(const std::string& stem)
{
    for (const char* extension : {".png", ".ppm", ".pgm"})
        if (cv::utils::fs::exists(stem + extension))
            return cv::imread(stem + extension, cv::IMREAD_COLOR);
    return cv::Mat();
}

cv::Mat readHomography(const std::string& stem)
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

ImageSet readSet(const std::string& folder, const std::string& name)
{
    ImageSet set;
    set.name = name;
    for (int i = 1; i <= IMAGES; i++)
    {
        const std::string path = folder + "/" + name + "/", pair = path + cv::format("H1to%dp", i);
        set.images.push_back(readImage(path + cv::format("img%d", i)));
        set.homographies.push_back(i == 1 ? cv::Mat(cv::Mat::eye(3, 3, CV_64F)) : readHomography(pair));
        if (set.images.back().empty())
            CV_Error(cv::Error::StsObjectNotFound, path + cv::format("img%d: no such image", i));
        if (set.homographies.back().empty())
            CV_Error(cv::Error::StsObjectNotFound, pair + ": no such homography");
    }
    return set;
}

std::vector<std::string> degradations()
{
    return {"dark", "gamma", "noise"};
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
            cv::Mat noise(image.size(), CV_16SC3);
            cv::RNG(i + 1).fill(noise, cv::RNG::NORMAL, 0, 15);
            cv::add(image, noise, image, cv::noArray(), CV_8U);
        }
        else
            CV_Error(cv::Error::StsBadArg, degradation + ": no such degradation");
    }
    return worse;
}
