// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The values of all parameters, and their checks.

#ifndef OPENCV_AQORB_PARAMETERS_HPP
#define OPENCV_AQORB_PARAMETERS_HPP

#include "parameter_table.hpp"

#include <opencv2/aqorb.hpp>

#include <cfloat>
#include <cstring>
#include <limits>
#include <type_traits>

namespace cv
{
namespace aqorb
{

/** What a parameter is kept as: an enumeration by its number. It need not be an enumerator, because a caller in Python
 can pass any number, and to read such an enumeration would be undefined behaviour. */
template <typename T> using Stored = typename std::conditional<std::is_enum<T>::value, int, T>::type;
template <typename T> Stored<T> toStored(const T& value)
{
    Stored<T> result;
    static_assert(sizeof(value) == sizeof(result), "the enumeration must be of the size of an int");
    std::memcpy(&result, &value, sizeof(result));
    return result;
}

//! The values of a parameter that are accepted. Infinity and NaN are never accepted.
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

// The ranges of the table.
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
inline ValidRange oneOf(const String& twoNames)
{
    return ValidRange{0, 1, twoNames, false};
}
inline ValidRange any()
{
    return ValidRange{-DBL_MAX, DBL_MAX, String(), false};
}

//! The parameters of AdaptiveQuadtreeORB, as documented there and listed in parameter_table.hpp.
struct Parameters
{
#define AQORB_FIELD(property, type, name, key, byDefault, ...) Stored<type> name = byDefault;
    AQORB_PARAMETERS(AQORB_FIELD)
#undef AQORB_FIELD

    //! Throws if a value is invalid whatever the others are.
    void check() const;
    //! Throws if values are invalid in combination, for a pyramid of levelsInUse levels.
    void checkTogether(int levelsInUse) const;

    //! Whether Harris responses count; else FAST scores do.
    bool useHarris() const
    {
        return scoreType == ORB::HARRIS_SCORE;
    }
    //! The shortest side of a level that can have a keypoint.
    int shortestSide() const;
    //! Where a level of this size may have keypoints: between the borders.
    Rect keypointRegion(Size size) const;

    void write(FileStorage& fs) const;
    //! A parameter whose key is missing keeps its value. Throws for an invalid value and then changes nothing.
    void read(const FileNode& node);
};

}  // namespace aqorb
}  // namespace cv

#endif
