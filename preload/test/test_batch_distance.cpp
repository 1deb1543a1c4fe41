// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Run with libaqorb_preload.so preloaded.

#include <gtest/gtest.h>

#include <opencv2/aqorb.hpp>

#include <dlfcn.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace
{

using namespace cv;

TEST(Aqorb_Preload_BatchDistance, takes_the_place_of_opencvs)
{
    Dl_info info;
    ASSERT_NE(0, dladdr(reinterpret_cast<void*>(&cv::batchDistance), &info));
    EXPECT_NE(std::string::npos, std::string(info.dli_fname).find("aqorb_preload")) << info.dli_fname;
}

struct Call
{
    Mat src1, src2, mask, dist, nidx;  // dist and nidx: the outputs before the call
    int dtype, normType, K, update;
    bool crosscheck, hasIndices;
};

//! Calls cv::batchDistance on copies of the outputs. Returns whether it gives a result instead of an exception.
bool run(const Call& call, Mat& dist, Mat& nidx)
{
    dist = call.dist.clone();
    nidx = call.nidx.clone();
    try
    {
        cv::batchDistance(call.src1, call.src2, dist, call.dtype,
                          call.hasIndices ? OutputArray(nidx) : OutputArray(noArray()), call.normType, call.K,
                          call.mask, call.update, call.crosscheck);
        return true;
    }
    catch (const cv::Exception&)
    {
        return false;
    }
}

Mat randomMat(RNG& rng, int rows, int cols, int type, int end)
{
    Mat mat(rows, cols, type);
    rng.fill(mat, RNG::UNIFORM, 0, end);
    return mat;
}

Call randomCall(RNG& rng)
{
    const int norms[] = {NORM_HAMMING, NORM_HAMMING, NORM_HAMMING2, NORM_L1, NORM_L2, NORM_L2SQR};
    const int dtypes[] = {-1, CV_32S, CV_32F};
    const int bytes = rng.uniform(0, 2) ? 32 : rng.uniform(1, 70);
    const int type = rng.uniform(0, 8) ? CV_8UC1 : CV_32FC1, rows = rng.uniform(1, 60),
              trains = rng.uniform(1, 60);
    Call call;
    call.src1 = randomMat(rng, rows, bytes, type, rng.uniform(2, 256));
    call.src2 = randomMat(rng, trains, bytes, type, rng.uniform(2, 256));
    call.normType = norms[rng.uniform(0, 6)];
    call.dtype = dtypes[rng.uniform(0, 3)];
    call.K = rng.uniform(-1, 8);
    call.crosscheck = rng.uniform(0, 4) == 0;
    if (call.crosscheck && rng.uniform(0, 4))
        call.K = 1;
    call.hasIndices = rng.uniform(0, 10) ? call.K > 0 : call.K <= 0;
    call.update = 0;
    if (rng.uniform(0, 3) == 0)
    {
        call.mask = randomMat(rng, rows, trains, CV_8UC1, 3);
        call.crosscheck &= rng.uniform(0, 4) == 0;
    }
    if (rng.uniform(0, 3) == 0 && call.K > 0)
    {
        // Lists as an earlier call leaves them, or in no order.
        call.update = rng.uniform(0, 2) ? 1 << 18 : -5;
        const bool isHamming = call.normType == NORM_HAMMING || call.normType == NORM_HAMMING2;
        const int columns = std::min(call.K, trains);
        const int type32 = call.dtype == CV_32F || (call.dtype == -1 && !isHamming) ? CV_32FC1 : CV_32SC1;
        call.dist = randomMat(rng, rows, columns, type32, 200);
        call.nidx = randomMat(rng, rows, columns, CV_32SC1, 200);
        if (rng.uniform(0, 2))
            cv::sort(call.dist, call.dist, SORT_EVERY_ROW | SORT_ASCENDING);
        call.crosscheck &= rng.uniform(0, 4) == 0;
    }
    return call;
}

bool isSame(const Mat& a, const Mat& b)
{
    return a.size() == b.size() && a.type() == b.type() && (a.empty() || norm(a, b, NORM_INF) == 0);
}

TEST(Aqorb_Preload_BatchDistance, gives_opencvs_results)
{
    int results = 0;
    for (int seed = 1; seed <= 6000; seed++)
    {
        RNG rng(seed);
        const Call call = randomCall(rng);
        Mat dist, nidx, expectedDist, expectedNidx;
        const bool isResult = run(call, dist, nidx);
        setenv("AQORB_DISABLE_MATCHER", "1", 1);
        const bool isExpected = run(call, expectedDist, expectedNidx);
        unsetenv("AQORB_DISABLE_MATCHER");
        SCOPED_TRACE(format("seed %d: norm %d, dtype %d, K %d, update %d%s%s", seed, call.normType,
                            call.dtype, call.K, call.update, call.crosscheck ? ", crosscheck" : "",
                            call.mask.empty() ? "" : ", mask"));
        ASSERT_EQ(isExpected, isResult);
        results += isResult;
        if (!isResult)
            continue;
        ASSERT_TRUE(isSame(expectedDist, dist)) << expectedDist << "\n" << dist;
        ASSERT_TRUE(isSame(expectedNidx, nidx)) << expectedNidx << "\n" << nidx;
    }
    EXPECT_GT(results, 1500);
}

}  // namespace
