// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Values of all parameters, and their checks.

#ifndef OPENCV_AQORB_PARAMETERS_HPP
#define OPENCV_AQORB_PARAMETERS_HPP

#include "detector/parameter_table.hpp"

#include <opencv2/aqorb.hpp>

#include <cfloat>
#include <cstring>
#include <limits>
#include <type_traits>

namespace cv
{
namespace aqorb
{

/** Stored type of a parameter: int for an enumeration. Python can pass a number that is no enumerator, and reading that
 number as an enumeration would be undefined behaviour. */
template <typename T> using Stored = typename std::conditional<std::is_enum<T>::value, int, T>::type;
template <typename T> Stored<T> toStored(const T& value)
{
    Stored<T> result;
    static_assert(sizeof(value) == sizeof(result), "the enumeration must be of the size of an int");
    std::memcpy(&result, &value, sizeof(result));
    return result;
}

//! Accepted values of a parameter, never infinity or NaN.
struct ValidRange
{
    double min, max;
    String text;  //!< as in "nfeatures must be <text>"
    bool acceptsMinusOne;

    bool has(double value) const
    {
        return (value >= min && value <= max) || (acceptsMinusOne && value == -1);
    }
    ValidRange orMinusOne() const { return ValidRange{min, max, text + ", or -1", true}; }
};

// Ranges for parameter_table.hpp.
inline ValidRange between(double min, double max)
{
    return ValidRange{min, max, format("from %g to %g", min, max), false};
}
inline ValidRange atLeast(double min)
{
    return ValidRange{min, DBL_MAX, format("at least %g", min), false};
}
inline ValidRange finiteAtLeast(double min)
{
    return ValidRange{min, DBL_MAX, format("finite and at least %g", min), false};
}
inline ValidRange positive()
{
    return ValidRange{std::numeric_limits<double>::denorm_min(), DBL_MAX, "finite and above 0", false};
}
//! The values 0 and 1 of an enumeration.
inline ValidRange oneOf(const String& twoNames)
{
    return ValidRange{0, 1, twoNames, false};
}
inline ValidRange any()
{
    return ValidRange{-DBL_MAX, DBL_MAX, "finite", false};
}

//! Parameters of AdaptiveQuadtreeORB, documented there and listed in parameter_table.hpp.
struct Parameters
{
#define AQORB_FIELD(property, type, name, key, byDefault, ...) Stored<type> name = byDefault;
    AQORB_PARAMETERS(AQORB_FIELD)
#undef AQORB_FIELD

    //! Throws if a single value is invalid.
    void check() const;
    //! Throws if a combination of values is invalid for a pyramid of levelsInUse levels.
    void checkTogether(int levelsInUse) const;

    //! Whether keypoints get Harris responses; else FAST scores.
    bool useHarris() const
    {
        return scoreType == ORB::HARRIS_SCORE;
    }
    //! Shortest side of a level that can have a keypoint.
    int shortestSide() const;
    //! Part of a level that may have keypoints: the level without its borders.
    Rect keypointRegion(Size size) const;

    void write(FileStorage& fs) const;
    //! Reads parameters. A missing key keeps the value; an invalid value throws.
    void read(const FileNode& node);
};

}  // namespace aqorb
}  // namespace cv

#endif
