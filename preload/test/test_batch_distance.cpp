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

typedef void (*BatchDistance)(InputArray, InputArray, OutputArray, int, OutputArray, int, int, InputArray,
                              int, bool);

//! Leaves matching to OpenCV during its lifetime.
class OriginalScope
{
public:
    OriginalScope() { setenv("AQORB_DISABLE_MATCHER", "1", 1); }
    ~OriginalScope() { unsetenv("AQORB_DISABLE_MATCHER"); }
};

TEST(Aqorb_Preload_BatchDistance, takes_the_place_of_opencvs)
{
    Dl_info info;
    ASSERT_NE(0, dladdr(reinterpret_cast<void*>(BatchDistance(&cv::batchDistance)), &info));
    EXPECT_NE(std::string::npos, std::string(info.dli_fname).find("aqorb_preload")) << info.dli_fname;
}

//! Result of a call: its matrices, or an exception.
struct Outcome
{
    Mat dist, nidx;
    bool throws;
};

struct Call
{
    Mat src1, src2, mask, dist, nidx;  // dist and nidx: the outputs before the call
    int dtype, normType, K, update;
    bool crosscheck, hasIndices;
};

Outcome run(const Call& call)
{
    Outcome outcome = {call.dist.clone(), call.nidx.clone(), false};
    try
    {
        cv::batchDistance(call.src1, call.src2, outcome.dist, call.dtype,
                          call.hasIndices ? OutputArray(outcome.nidx) : OutputArray(noArray()), call.normType,
                          call.K, call.mask, call.update, call.crosscheck);
    }
    catch (const cv::Exception&)
    {
        outcome.throws = true;
    }
    return outcome;
}

Call randomCall(RNG& rng)
{
    Call call;
    const int bytes = rng.uniform(0, 2) ? 32 : rng.uniform(1, 70);
    const int type = rng.uniform(0, 8) ? CV_8UC1 : CV_32FC1, rows = rng.uniform(1, 60),
              trains = rng.uniform(1, 60);
    call.src1 = Mat(rows, bytes, type);
    call.src2 = Mat(trains, bytes, type);
    rng.fill(call.src1, RNG::UNIFORM, 0, rng.uniform(2, 256));
    rng.fill(call.src2, RNG::UNIFORM, 0, rng.uniform(2, 256));
    const int norms[] = {NORM_HAMMING, NORM_HAMMING, NORM_HAMMING2, NORM_L1, NORM_L2, NORM_L2SQR},
              dtypes[] = {-1, CV_32S, CV_32F};
    call.normType = norms[rng.uniform(0, 6)];
    call.dtype = dtypes[rng.uniform(0, 3)];
    call.K = rng.uniform(-1, 8);
    call.hasIndices = rng.uniform(0, 10) ? call.K > 0 : call.K <= 0;
    call.crosscheck = rng.uniform(0, 4) == 0;
    if (call.crosscheck && rng.uniform(0, 4))
        call.K = 1, call.hasIndices = true;
    call.update = 0;
    if (rng.uniform(0, 3) == 0)
    {
        call.mask = Mat(rows, trains, CV_8UC1);
        rng.fill(call.mask, RNG::UNIFORM, 0, 3);
        if (rng.uniform(0, 4))
            call.crosscheck = false;
    }
    if (rng.uniform(0, 3) == 0 && call.K > 0)
    {
        // Lists as an earlier call leaves them, or in no order.
        call.update = rng.uniform(0, 2) ? 1 << 18 : -5;
        const bool isHamming = call.normType == NORM_HAMMING || call.normType == NORM_HAMMING2;
        const int columns = std::min(call.K, trains);
        const int type32 = call.dtype == CV_32F || (call.dtype == -1 && !isHamming) ? CV_32FC1 : CV_32SC1;
        call.dist = Mat(rows, columns, type32);
        call.nidx = Mat(rows, columns, CV_32SC1);
        rng.fill(call.dist, RNG::UNIFORM, 0, 200);
        rng.fill(call.nidx, RNG::UNIFORM, 0, 200);
        if (rng.uniform(0, 2))
            cv::sort(call.dist, call.dist, SORT_EVERY_ROW | SORT_ASCENDING);
        if (rng.uniform(0, 4))
            call.crosscheck = false;
    }
    return call;
}

::testing::AssertionResult sameMat(const Mat& a, const Mat& b)
{
    if (a.size() != b.size() || a.type() != b.type())
        return ::testing::AssertionFailure()
               << a.size() << " and " << b.size() << ", types " << a.type() << " and " << b.type();
    return a.empty() || norm(a, b, NORM_INF) == 0 ? ::testing::AssertionSuccess()
                                                  : ::testing::AssertionFailure() << a << "\n"
                                                                                  << b;
}

TEST(Aqorb_Preload_BatchDistance, gives_opencvs_results)
{
    int thrown = 0;
    for (int seed = 1; seed <= 6000; seed++)
    {
        RNG rng(seed);
        const Call call = randomCall(rng);
        const Outcome ours = run(call);
        Outcome opencvs;
        {
            const OriginalScope scope;
            opencvs = run(call);
        }
        const std::string text =
            format("seed %d: norm %d, dtype %d, K %d, update %d%s%s", seed, call.normType, call.dtype, call.K,
                   call.update, call.crosscheck ? ", crosscheck" : "", call.mask.empty() ? "" : ", mask");
        ASSERT_EQ(opencvs.throws, ours.throws) << text;
        thrown += ours.throws;
        if (ours.throws)
            continue;
        ASSERT_TRUE(sameMat(opencvs.dist, ours.dist)) << text;
        ASSERT_TRUE(sameMat(opencvs.nidx, ours.nidx)) << text;
    }
    EXPECT_LT(thrown, 4500);
}

}  // namespace
