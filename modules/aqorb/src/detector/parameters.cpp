// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Checks, writes and reads parameters.

#include "precomp.hpp"

#include "detector/parameters.hpp"
#include "detector/types.hpp"

namespace cv
{
namespace aqorb
{

static void reject(const char* name, const String& accepted, double value)
{
    CV_Error_(Error::StsOutOfRange, ("%s must be %s, got %.17g", name, accepted.c_str(), value));
}

static void checkValue(const char* name, double value, const ValidRange& range)
{
    if (!range.has(value))
        reject(name, range.text, value);
}

void Parameters::check() const
{
#define AQORB_CHECK(property, type, name, key, byDefault, range, text) checkValue(#name, name, range);
    AQORB_PARAMETERS(AQORB_CHECK)
#undef AQORB_CHECK
}

void Parameters::checkTogether(int levelsInUse) const
{
    if (levelsInUse > 1 && scaleFactor <= 1)
        reject("scaleFactor", "above 1 with more than one level", scaleFactor);
    if (firstLevel >= nlevels)
        reject("firstLevel", format("below nlevels, which is %d", nlevels), firstLevel);
}

int Parameters::shortestSide() const
{
    return int(std::min(2 * std::max<int64>(edgeThreshold, FAST_RADIUS) + 1, int64(INT_MAX)));
}

Rect Parameters::keypointRegion(Size size) const
{
    const int border = edgeThreshold;
    return Rect(border, border, size.width - 2 * border, size.height - 2 * border);
}

void Parameters::write(FileStorage& fs) const
{
    // FileStorage has no bool.
#define AQORB_WRITE(property, type, name, key, ...) fs << #key << +name;
    AQORB_PARAMETERS(AQORB_WRITE)
#undef AQORB_WRITE
}

// FileStorage reads text as 0, and rounds or wraps numbers that do not fit an int, without an error.
template <typename T>
static void readValue(const FileNode& node, const char* key, const ValidRange& range, T& value)
{
    const FileNode found = node[key];
    if (found.empty())
        return;
    if (!found.isInt() && !found.isReal())
        CV_Error_(Error::StsParseError, ("%s must be a number", key));
    const double number = double(found);
    checkValue(key, number, range);
    if (!(number >= std::numeric_limits<T>::lowest() && number <= std::numeric_limits<T>::max()) ||
        double(T(number)) != number)
        reject(key, std::numeric_limits<T>::max() == 1 ? "0 or 1" : "a whole number of 32 bits", number);
    value = T(number);
}

void Parameters::read(const FileNode& node)
{
    if (node.isNone())
        return;
    if (!node.isMap())
        CV_Error_(Error::StsParseError,
                  ("node must be a map of the parameters; read(fileName) reads a file"));
#define AQORB_READ(property, type, name, key, byDefault, range, text) readValue(node, #key, range, name);
    AQORB_PARAMETERS(AQORB_READ)
#undef AQORB_READ
}

}  // namespace aqorb
}  // namespace cv
