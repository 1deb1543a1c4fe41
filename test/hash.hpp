// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef OPENCV_AQORB_TEST_HASH_HPP
#define OPENCV_AQORB_TEST_HASH_HPP

#include <opencv2/core.hpp>

#include <cstdint>
#include <string>
#include <vector>

// By which results are compared between versions and CPUs. Needs neither test framework, so that tools/ uses it, too.

namespace opencv_test
{

//! FNV-1a of 64 bits.
class Hash
{
public:
    void add(const void* data, size_t size)
    {
        const unsigned char* bytes = static_cast<const unsigned char*>(data);
        for (size_t i = 0; i < size; i++)
            state = (state ^ bytes[i]) * 0x100000001b3u;
    }
    //! The size and the pixels.
    void add(const cv::Mat& mat)
    {
        add(&mat.rows, sizeof(mat.rows));
        add(&mat.cols, sizeof(mat.cols));
        for (int y = 0; y < mat.rows; y++)
            add(mat.ptr(y), mat.cols * mat.elemSize());
    }
    void add(const std::vector<cv::KeyPoint>& keypoints)
    {
        static_assert(sizeof(cv::KeyPoint) == 5 * sizeof(float) + 2 * sizeof(int),
                      "a KeyPoint has no padding");
        add(keypoints.data(), keypoints.size() * sizeof(cv::KeyPoint));
    }
    //! 16 hexadecimal digits.
    std::string text() const { return cv::format("%08x%08x", unsigned(state >> 32), unsigned(state)); }

private:
    uint64_t state = 0xcbf29ce484222325u;
};

template <typename T> std::string hashOf(const T& what)
{
    Hash hash;
    hash.add(what);
    return hash.text();
}

}  // namespace opencv_test

#endif
