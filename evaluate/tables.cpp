// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "results.hpp"

#include <fstream>

void writeTables(const Results&, const std::string&)
{
}
