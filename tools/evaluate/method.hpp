// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#ifndef AQORB_EVALUATE_METHOD_HPP
#define AQORB_EVALUATE_METHOD_HPP

#include "../../test/features.hpp"

#include <opencv2/aqorb.hpp>

#include <functional>
#include <string>

using opencv_test::Features;

//! A detector with its descriptor, as one row of the tables.
class Method
{
public:
    virtual ~Method() = default;
    //! The features of a colour image; n of them are asked for.
    virtual Features compute(const cv::Mat& image, int n) = 0;
    //! The norm that compares its descriptors.
    virtual int norm() const { return cv::NORM_HAMMING; }

    std::string name;   //!< in CSV files and on the command line
    std::string title;  //!< in tables
};

//! The image itself if it is grey.
cv::Mat grayOf(const cv::Mat& image);

//! A cv::Feature2D that is created for a number of features.
class Feature2DMethod : public Method
{
public:
    typedef std::function<cv::Ptr<cv::Feature2D>(int n)> Create;
    explicit Feature2DMethod(const Create& create_) : create(create_) {}
    Features compute(const cv::Mat& image, int n) override;
    int norm() const override { return create(1)->defaultNorm(); }

private:
    Create create;
    cv::Ptr<cv::Feature2D> detector;  // the last one created, for detectorN features
    int detectorN = -1;
};

//! Thrown for a method whose library or model is absent.
struct Absent
{
    std::string reason;
};

//! Changes the settings of a detector: key=value, separated by ':'. Raises cv::Exception for an unknown one.
void applySettings(cv::aqorb::AdaptiveQuadtreeORB& detector, const std::string& settings);

// Each of these has a file in methods/. They throw Absent.
cv::Ptr<Method> makeOrb();
cv::Ptr<Method> makeOrbSlam();
//! Takes settings as key=value, separated by ':'. Settings that are not named keep their defaults.
cv::Ptr<Method> makeAqorb(const std::string& settings);
//! SlamExtractor; takes the same settings.
cv::Ptr<Method> makeSlam(const std::string& settings);
cv::Ptr<Method> makeFigure2();
cv::Ptr<Method> makeSift();
cv::Ptr<Method> makeBrisk();
cv::Ptr<Method> makeAkaze();
cv::Ptr<Method> makeSsc();
cv::Ptr<Method> makeSurf();
cv::Ptr<Method> makeSuperPoint(const std::string& model);

//! The names of all methods.
std::vector<std::string> allMethods();

//! A method that differs from aqorb in one ingredient.
struct Ablation
{
    std::string name;
    std::string but;  //!< the difference, in words
};

//! aqorb itself, and aqorb without each of its ingredients.
std::vector<Ablation> ablationMethods();

/** The method of a name: one of allMethods, slam, or aqorb:key=value:... or slam:key=value:...
 with the keys in methods/aqorb.cpp.
 Throws Absent, or cv::Exception for a name that is none.
 @param superPoint ONNX file; empty: SuperPoint is absent */
cv::Ptr<Method> makeMethod(const std::string& name, const std::string& superPoint);

#endif
