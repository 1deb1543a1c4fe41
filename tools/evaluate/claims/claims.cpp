// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "claims.hpp"
#include "subjects.hpp"

#include <opencv2/core.hpp>

#include <cmath>
#include <limits>

const std::vector<double> SCALES = {0.4, 0.5, 0.6, 0.75, 1.5, 2, 2.5}, ROLLED_SCALES = {0.5, 0.7, 1.4, 2};
const std::vector<int> OBJECT_NUMBERS = {250, 400, 500, 1000, 2000};

namespace
{

const double NOTHING = std::numeric_limits<double>::quiet_NaN();
const int ONE_NUMBER = 1000;  // where only one number of features is measured
const char* const DEGRADATIONS[] = {"dark", "gamma", "noise", "blur", "shrunk", "enlarged"};

std::string text(double value, int digits)
{
    return std::isnan(value) ? "" : cv::format("%.*f", digits, value);
}

//! What is asked of a value: at most or at least so much. Not-a-number asks for nothing.
struct Bound
{
    enum Side
    {
        AT_LEAST,
        AT_MOST,
        ABOVE
    } side;
    double asked, aim;
};

const Bound UNBOUND = {Bound::AT_LEAST, NOTHING, NOTHING};

std::string text(Bound::Side side, double limit, int digits)
{
    static const char* const WORDS[] = {"at least ", "at most ", "above "};
    return std::isnan(limit) ? "" : WORDS[side] + text(limit, digits);
}

bool keeps(double value, const Bound& bound)
{
    switch (bound.side)
    {
    case Bound::AT_LEAST:
        return value >= bound.asked;
    case Bound::AT_MOST:
        return value <= bound.asked;
    default:
        return value > bound.asked;
    }
}

class Judge
{
public:
    Judge(const Measurements& measured_, const Compared& names_) : measured(measured_), names(names_) {}

    std::vector<Claim> claims;

    void add(const std::string& what, int n, double here, double orb, double paper, int digits,
             const Bound& bound = UNBOUND, const std::string& remark = "")
    {
        if (std::isnan(here))
            return;
        Claim::Verdict verdict = Claim::NONE;
        if (!std::isnan(bound.asked))
            verdict = keeps(here, bound) ? Claim::HOLDS : Claim::FAILS;
        claims.push_back({what, n, text(here, digits), text(orb, digits), text(paper, digits),
                          text(bound.side, bound.asked, digits) + remark, text(bound.side, bound.aim, digits),
                          verdict, false});
    }

    //! A mean of all three methods.
    void mean(const std::string& what, const std::string& subject, int n, const std::string& quantity,
              int digits, const Bound& bound = UNBOUND,
              const Measurements::Filter& filter = Measurements::Filter())
    {
        add(what, n, measured.mean(subject, names.method, n, quantity, filter),
            measured.mean(subject, names.orb, n, quantity, filter),
            measured.mean(subject, names.paper, n, quantity, filter), digits, bound);
    }

    //! The mean as a multiple of cv::ORB's.
    void ratio(const std::string& what, const std::string& subject, int n, const std::string& quantity,
               const Bound& bound = UNBOUND, const Measurements::Filter& filter = Measurements::Filter())
    {
        const double orb = measured.mean(subject, names.orb, n, quantity, filter);
        add(what, n, measured.mean(subject, names.method, n, quantity, filter) / orb, 1,
            measured.mean(subject, names.paper, n, quantity, filter) / orb, 3, bound);
    }

    //! Distinct correct matches at one scale, at least as many as with the paper's selection.
    void scale(double scale, int n)
    {
        const std::string subject = subjectOfScale(scale);
        const double paper = measured.mean(subject, names.paper, n, "distinct") /
                             measured.mean(subject, names.orb, n, "distinct");
        const Bound bound = {Bound::AT_LEAST, std::max(1.3, paper), NOTHING};
        ratio(subject + ": distinct correct matches, times cv::ORB's", subject, n, "distinct", bound);
    }

    //! The geometric mean of the scales.
    void scales(int n)
    {
        const double orb = distinctAtScales(measured, names.orb, n);
        add("the geometric mean of the scales", n, distinctAtScales(measured, names.method, n) / orb, 1,
            distinctAtScales(measured, names.paper, n) / orb, 3, {Bound::AT_LEAST, 1.5, 1.65});
    }

    //! Homographies must not be worse than those of the paper's selection beyond chance.
    void area(const std::string& what, const std::string& subject, int n, bool isAsked)
    {
        const std::vector<double> here = measured.values(subject, names.method, n, "auc5");
        const std::vector<double> paper = measured.values(subject, names.paper, n, "auc5");
        if (here.empty() || here.size() != paper.size())
            return;
        const double error = standardError(differences(here, paper)), theirs = ::mean(paper);
        const Bound bound = {Bound::AT_LEAST, isAsked ? theirs - 2 * error : NOTHING, NOTHING};
        add(what, n, ::mean(here), measured.mean(subject, names.orb, n, "auc5"), theirs, 3, bound,
            cv::format(isAsked ? " (less 2 standard errors of %.3f)" : "standard error %.3f", error));
    }

    //! The sum of the inliers on the object, over all numbers of features.
    double inliers(const std::string& method) const
    {
        double sum = 0;
        for (const int n : OBJECT_NUMBERS)
            sum += n == 400 ? 0 : measured.mean("object", method, n, "inliers");
        return sum;
    }

    //! The error of one seed: the mean over the gaps of the median errors.
    std::vector<double> stereoErrors(const std::string& method, const std::string& quantity) const
    {
        std::vector<double> sums;
        for (int gap = 1; gap <= 3; gap++)
        {
            const std::vector<double> errors =
                measured.values("stereo", method, ONE_NUMBER, quantity, ofSets({std::to_string(gap)}));
            sums.resize(errors.size(), 0);
            for (size_t i = 0; i < errors.size(); i++)
                sums[i] += errors[i] / 3;
        }
        return sums;
    }

    //! Matches of the finest level between frames that are so many apart.
    void start(const std::string& what, int step, int n)
    {
        const Measurements::Filter filter = ofSets({std::to_string(step)});
        const double paper = measured.mean("start", names.paperSlam, n, "correct", filter);
        add(what, n, measured.mean("start", slamOf(names.method), n, "correct", filter),
            measured.mean("start", names.orb, n, "correct", filter), paper, 1,
            {Bound::AT_LEAST, paper, NOTHING});
    }

    void stereo(const std::string& what, const std::string& method, const std::string& paper,
                const std::string& quantity)
    {
        const std::vector<double> here = stereoErrors(method, quantity),
                                  theirs = stereoErrors(paper, quantity);
        if (here.empty() || here.size() != theirs.size())
            return;
        const double error = standardError(differences(here, theirs));
        const double withFrames = standardDeviation(differences(
            stereoErrors(method, quantity + ", resampled"), stereoErrors(paper, quantity + ", resampled")));
        // The frames of a short sequence decide more than the seeds.
        const Bound bound = {Bound::AT_MOST, ::mean(theirs) + 2 * withFrames, NOTHING};
        add(what + ", " + quantity, ONE_NUMBER, ::mean(here), ::mean(stereoErrors(names.orb, quantity)),
            ::mean(theirs), 4, bound,
            cv::format(" (incl. 2 standard errors of %.4f; %.4f of the seeds)", withFrames, error));
        for (int gap = 1; gap <= 3; gap++)
        {
            const Measurements::Filter filter = ofSets({std::to_string(gap)});
            add(what + cv::format(", %s, gap %d", quantity.c_str(), gap), ONE_NUMBER,
                measured.mean("stereo", method, ONE_NUMBER, quantity, filter),
                measured.mean("stereo", names.orb, ONE_NUMBER, quantity, filter),
                measured.mean("stereo", paper, ONE_NUMBER, quantity, filter), 4);
        }
    }

private:
    const Measurements& measured;
    const Compared& names;
};

//! What is asked for at n = 500, 1000 and 2000; nothing elsewhere.
Bound at(int n, Bound::Side side, const double (&asked)[3], const double (&aim)[3])
{
    const int index = n == 500 ? 0 : n == 1000 ? 1 : n == 2000 ? 2 : -1;
    return index < 0 ? UNBOUND : Bound{side, asked[index], aim[index]};
}

}  // namespace

std::string slamOf(const std::string& method)
{
    const std::string name = "aqorb";
    const bool isOne = method == name || method.compare(0, name.size() + 1, name + ":") == 0;
    return isOne ? "slam" + method.substr(name.size()) : "";
}

double distinctAtScales(const Measurements& measured, const std::string& method, int n)
{
    double sum = 0;
    for (const double scale : SCALES)
        sum += std::log(measured.mean(subjectOfScale(scale), method, n, "distinct"));
    return std::exp(sum / double(SCALES.size()));
}

std::vector<Claim> judge(const Measurements& measured, const Compared& compared,
                         const std::vector<int>& numbers)
{
    const Measurements::Filter papersSets = ofSets({"bikes", "leuven", "bark", "trees", "ubc"});
    Judge judge(measured, compared);
    const double none[] = {NOTHING, NOTHING, NOTHING};

    for (const int n : numbers)
        judge.ratio("distinct correct matches, times cv::ORB's", "sets", n, "distinct",
                    at(n, Bound::AT_LEAST, {1.55, 1.50, 1.45}, {1.62, 1.56, 1.49}));
    for (const int n : numbers)
        judge.ratio("the same on graf", "sets", n, "distinct", at(n, Bound::AT_LEAST, {1.3, 1.3, 1.3}, none),
                    ofSets({"graf"}));
    for (const int n : numbers)
        judge.mean("uniformity u of the paper's sets, grey", "sets", n, "uniformity", 2,
                   at(n, Bound::AT_MOST, {150, NOTHING, NOTHING}, {140, NOTHING, NOTHING}), papersSets);
    for (const int n : numbers)
        judge.mean("uniformity u of the paper's sets, in colour", "colour", n, "uniformity", 2,
                   at(n, Bound::AT_MOST, {151, NOTHING, NOTHING}, {140, NOTHING, NOTHING}), papersSets);
    for (const int n : numbers)
        judge.mean("occupancy", "sets", n, "occupancy", 3, at(n, Bound::AT_LEAST, {.58, .79, NOTHING}, none));
    for (const int n : numbers)
        judge.mean("places", "sets", n, "places", 1, at(n, Bound::AT_LEAST, {52, 78, 103}, none));
    for (const int n : numbers)
        judge.mean("precision", "sets", n, "precision", 3);
    for (const int n : numbers)
        judge.area("homography AUC@5", "sets", n, true);

    judge.ratio("rolled photographs: distinct correct matches, times cv::ORB's", "rolled", ONE_NUMBER,
                "distinct", {Bound::AT_LEAST, 1.50, 1.58});
    judge.mean("rolled photographs: places", "rolled", ONE_NUMBER, "places", 1);
    judge.mean("rolled photographs: precision", "rolled", ONE_NUMBER, "precision", 3);

    for (const double scale : SCALES)
        for (const int n : numbers)
            judge.scale(scale, n);
    for (const int n : numbers)
        judge.scales(n);
    for (const double scale : SCALES)
        for (const int n : numbers)
            judge.mean(subjectOfScale(scale) + ": precision", subjectOfScale(scale), n, "precision", 3);
    for (const double scale : ROLLED_SCALES)
        judge.ratio("rolled, " + subjectOfScale(scale) + ": distinct correct matches, times cv::ORB's",
                    "rolled, " + subjectOfScale(scale), ONE_NUMBER, "distinct");

    for (const int n : OBJECT_NUMBERS)
        judge.mean("inliers on a small object", "object", n, "inliers", 0,
                   {Bound::AT_LEAST,
                    n == 250   ? 10
                    : n == 500 ? 12
                               : NOTHING,
                    n == 500 ? 15 : NOTHING});
    const double orb = judge.inliers(compared.orb);
    const double here = judge.inliers(compared.method), dial = judge.inliers(compared.dial);
    judge.add("inliers on a small object, times cv::ORB's", 0, here / orb, 1,
              judge.inliers(compared.paper) / orb, 3, {Bound::AT_LEAST, .9, NOTHING});
    judge.add("the same at the dial's other end", 0, dial / orb, 1, NOTHING, 3, {Bound::ABOVE, 1, NOTHING});

    for (const char* const quantity : {"metres", "degrees"})
    {
        judge.stereo("stereo odometry, median error", compared.method, compared.paper, quantity);
        judge.stereo("stereo odometry with SlamExtractor", slamOf(compared.method), compared.paperSlam,
                     quantity);
    }

    for (const int n : numbers)
        judge.start("start with one camera: correct matches with the next frame", 1, n);
    for (const int n : numbers)
        judge.start("start with one camera: correct matches with the frame a second later", 10, n);

    for (const int n : numbers)
        judge.ratio("held-out pairs: distinct correct matches, times cv::ORB's", "held-out", n, "distinct");
    for (const int n : numbers)
        judge.mean("held-out pairs: places", "held-out", n, "places", 1);
    for (const int n : numbers)
        judge.mean("held-out pairs: precision", "held-out", n, "precision", 3);
    for (const int n : numbers)
        judge.area("held-out pairs: homography AUC@5", "held-out", n, false);

    for (const std::string degradation : DEGRADATIONS)
        judge.ratio(degradation + ": distinct correct matches, times cv::ORB's", degradation, ONE_NUMBER,
                    "distinct");
    for (const std::string degradation : DEGRADATIONS)
        judge.mean(degradation + ": places", degradation, ONE_NUMBER, "places", 1);

    const double paper = measured.mean("cost", compared.paper, ONE_NUMBER, "milliseconds");
    judge.add("CPU time of a frame, times that of the paper's selection", ONE_NUMBER,
              measured.mean("cost", compared.method, ONE_NUMBER, "milliseconds") / paper,
              measured.mean("cost", compared.orb, ONE_NUMBER, "milliseconds") / paper, 1, 3,
              {Bound::AT_MOST, 1.05, NOTHING});
    if (!judge.claims.empty() && judge.claims.back().what.compare(0, 3, "CPU") == 0)
        judge.claims.back().isTime = true;
    return judge.claims;
}
