// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "../method.hpp"

#include <opencv2/opencv_modules.hpp>

#ifdef HAVE_OPENCV_DNN

#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

namespace
{

// SuperPoint (DeTone et al. 2018) through cv::dnn: any ONNX file that takes a grey image and has its two
// heads, 65 channels of corner scores and 256 of descriptors, at an eighth of the image's size.
class SuperPoint : public Method
{
public:
    explicit SuperPoint(const std::string& model) : net(cv::dnn::readNetFromONNX(model)) {}

    Features compute(const cv::Mat& image, int n) override
    {
        cv::Mat gray = grayOf(image);
        // The network takes whole cells: pixels left over at the right and the bottom are cut off.
        gray = gray(cv::Rect(0, 0, gray.cols / CELL * CELL, gray.rows / CELL * CELL));

        net.setInput(cv::dnn::blobFromImage(gray, 1 / 255.));
        std::vector<cv::Mat> heads;
        net.forward(heads, net.getUnconnectedOutLayersNames());
        if (heads.size() != 2 || heads[0].size[1] + heads[1].size[1] != SCORES + DESCRIPTOR)
            CV_Error(cv::Error::StsBadArg, "the model does not have SuperPoint's two heads");
        if (heads[0].size[1] != SCORES)
            std::swap(heads[0], heads[1]);

        Features features;
        features.keypoints = peaks(scores(heads[0]));
        cv::KeyPointsFilter::retainBest(features.keypoints, n);
        features.descriptors = describe(heads[1], features.keypoints);
        return features;
    }

    int norm() const override { return cv::NORM_L2; }

private:
    static const int CELL = 8, SCORES = CELL * CELL + 1, DESCRIPTOR = 256;
    static const int RADIUS = 4;  // of non-maximum suppression, and the border; as in the paper's program

    //! The softmax over a cell's pixels and "none of them", laid out as an image.
    static cv::Mat1f scores(const cv::Mat& head)
    {
        const int rows = head.size[2], columns = head.size[3];
        cv::Mat1f exponentials(SCORES, rows * columns), sums, image(rows * CELL, columns * CELL);
        cv::exp(cv::Mat(SCORES, rows * columns, CV_32F, const_cast<float*>(head.ptr<float>())), exponentials);
        cv::reduce(exponentials, sums, 0, cv::REDUCE_SUM);
        for (int c = 0; c < SCORES - 1; c++)
            for (int i = 0; i < rows * columns; i++)
                image(i / columns * CELL + c / CELL, i % columns * CELL + c % CELL) =
                    exponentials(c, i) / sums(i);
        return image;
    }

    static std::vector<cv::KeyPoint> peaks(const cv::Mat1f& score)
    {
        cv::Mat1f highest;
        cv::dilate(score, highest, cv::Mat::ones(2 * RADIUS + 1, 2 * RADIUS + 1, CV_8U));
        std::vector<cv::KeyPoint> keypoints;
        for (int y = RADIUS; y < score.rows - RADIUS; y++)
            for (int x = RADIUS; x < score.cols - RADIUS; x++)
                if (score(y, x) == highest(y, x))
                    keypoints.emplace_back(float(x), float(y), float(CELL), -1.f, score(y, x));
        return keypoints;
    }

    //! Interpolates bilinearly between the descriptors of cells, and normalizes.
    static cv::Mat describe(const cv::Mat& head, const std::vector<cv::KeyPoint>& keypoints)
    {
        if (keypoints.empty())
            return cv::Mat();
        cv::Mat1f map(int(keypoints.size()), 2), descriptors(int(keypoints.size()), DESCRIPTOR);
        for (int i = 0; i < map.rows; i++)
        {
            map(i, 0) = (keypoints[i].pt.x + 0.5f) / CELL - 0.5f;
            map(i, 1) = (keypoints[i].pt.y + 0.5f) / CELL - 0.5f;
        }
        const cv::Mat positions = map.reshape(2);
        for (int c = 0; c < DESCRIPTOR; c++)
        {
            cv::Mat1f column;
            cv::remap(channel(head, c), column, positions, cv::noArray(), cv::INTER_LINEAR,
                      cv::BORDER_REPLICATE);
            column.copyTo(descriptors.col(c));
        }
        for (int i = 0; i < descriptors.rows; i++)
            cv::normalize(descriptors.row(i), descriptors.row(i));
        return descriptors;
    }

    static cv::Mat channel(const cv::Mat& head, int c)
    {
        return cv::Mat(head.size[2], head.size[3], CV_32F, const_cast<float*>(head.ptr<float>(0, c)));
    }

    cv::dnn::Net net;
};

}  // namespace

cv::Ptr<Method> makeSuperPoint(const std::string& model)
{
    if (model.empty())
        throw Absent{"no model given (--superpoint)"};
    const cv::Ptr<Method> method = cv::makePtr<SuperPoint>(model);
    const size_t slash = model.find_last_of('/') + 1;
    method->title = "SuperPoint (" + model.substr(slash, model.find_last_of('.') - slash) + ")";
    return method;
}

#else

cv::Ptr<Method> makeSuperPoint(const std::string&)
{
    throw Absent{"built without OpenCV's module dnn"};
}

#endif
