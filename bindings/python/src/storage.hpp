// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// A detector's parameters in files and in cv2's storages.

#ifndef AQORB_PYTHON_STORAGE_HPP
#define AQORB_PYTHON_STORAGE_HPP

#include "detector.hpp"

#include <string>

namespace aqorb_python
{

//! All parameters as the text of a file, by which a detector is copied and pickled.
std::string toText(const Detector& self);
Detector fromText(const std::string& text);

void writeFile(const Detector& self, const FileNameObject& fileName);
void readFile(Detector& self, const FileNameObject& fileName);

void writeStorage(const Detector& self, const FileStorageObject& storage, const std::string& name);
void readNode(Detector& self, const FileNodeObject& node);

}  // namespace aqorb_python

#endif
