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

//! FNV-1a of 64 bits. Numbers are hashed from their lowest byte on, whatever the order of the CPU is.
class Hash
{
public:
    //! Bytes.
    void add(const void* data, size_t size)
    {
        const unsigned char* bytes = static_cast<const unsigned char*>(data);
        for (size_t i = 0; i < size; i++)
            state = (state ^ bytes[i]) * 0x100000001b3u;
    }
    //! The size and the pixels.
    void add(const cv::Mat& mat)
    {
        addNumbers(&mat.rows, 1);
        addNumbers(&mat.cols, 1);
        for (int y = 0; y < mat.rows; y++)
            addNumbers(mat.ptr(y), size_t(mat.cols) * mat.channels(), mat.elemSize1());
    }
    void add(const std::vector<cv::KeyPoint>& keypoints)
    {
        static_assert(sizeof(cv::KeyPoint) == 5 * sizeof(float) + 2 * sizeof(int),
                      "a KeyPoint has no padding");
        addNumbers(keypoints.data(), keypoints.size() * 7, sizeof(float));
    }
    template <typename T> void addNumbers(const T* numbers, size_t count)
    {
        addNumbers(numbers, count, sizeof(T));
    }
    //! 16 hexadecimal digits.
    std::string text() const { return cv::format("%08x%08x", unsigned(state >> 32), unsigned(state)); }

private:
    void addNumbers(const void* numbers, size_t count, size_t size)
    {
        const uint16_t one = 1;
        const bool lowestFirst = *reinterpret_cast<const unsigned char*>(&one) == 1;
        const unsigned char* bytes = static_cast<const unsigned char*>(numbers);
        for (size_t i = 0; i < count * size; i++)
            add(&bytes[lowestFirst ? i : i - i % size + (size - 1 - i % size)], 1);
    }

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
