// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "detector.hpp"

#include "errors.hpp"

namespace aqorb_python
{

namespace
{

py::object inPython(const char* function)
{
    return py::module_::import("aqorb._storage").attr(function);
}

void readText(Detector::Library& library, const std::string& text)
{
    const cv::FileStorage memory(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    library.read(memory.root());
}

}  // namespace

std::string toText(const Detector& self, const std::string& name)
{
    cv::FileStorage memory(name, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    self.share()->write(memory);
    return memory.releaseAndGetString();
}

Detector fromText(const std::string& text)
{
    const cv::Ptr<Detector::Library> library = Detector::Library::create();
    readText(*library, text);
    return Detector(library);
}

void writeFile(const Detector& self, const FileNameObject& fileName)
{
    const py::object path = inPython("path_of")(fileName.object, "FileStorage");
    inPython("save")(path, py::bytes(toText(self, inPython("text_name")(path).cast<std::string>())));
}

void readFile(Detector& self, const FileNameObject& fileName)
{
    const std::string path = inPython("path_of")(fileName.object, "FileNode").cast<std::string>();
    std::string reason;
    cv::FileStorage storage;
    try
    {
        storage.open(path, cv::FileStorage::READ);
    }
    catch (const cv::Exception& exception)
    {
        reason = " (" + exception.err + ")";
    }
    if (!storage.isOpened())
        CV_Error_(cv::Error::StsError,
                  ("fileName must be a file that can be read, got '%s'%s", path.c_str(), reason.c_str()));
    self.change([&](Detector::Library& library) { library.read(storage.root()); });
}

void writeStorage(const Detector& self, const FileStorageObject& storage, const std::string& name)
{
    inPython("write")(toText(self), storage.object, name);
}

void readNode(Detector& self, const FileNodeObject& node)
{
    const std::string given = inPython("read")(toText(self), node.object).cast<std::string>();
    self.change([&](Detector::Library& library) { readText(library, given); });
}

}  // namespace aqorb_python
