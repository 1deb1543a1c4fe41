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

std::string messageOf(const py::error_already_set& error)
{
    return py::str(error.value());
}

// The path in the encoding of file names, from whatever open() takes as one.
std::string toPath(const FileNameObject& fileName, const char* accepted)
{
    const py::object path = py::reinterpret_steal<py::object>(PyOS_FSPath(fileName.object.ptr()));
    if (!path)
    {
        const py::error_already_set error;
        if (!error.matches(PyExc_TypeError))
            throw error;
        throwTypeError("fileName", brief(fileName.object), accepted);
    }
    PyObject* bytes = nullptr;
    if (!PyUnicode_FSConverter(path.ptr(), &bytes))
    {
        const py::error_already_set error;  // a ValueError: the path has a zero in it, for example
        CV_Error_(cv::Error::StsBadArg, ("fileName must be a path of the system, got %s (%s)",
                                         brief(fileName.object).c_str(), messageOf(error).c_str()));
    }
    return py::reinterpret_steal<py::bytes>(bytes);
}

[[noreturn]] void failToOpen(const std::string& path, const char* verb, const std::string& reason)
{
    CV_Error_(cv::Error::StsError, ("fileName must be a file that can be %s, got '%s'%s", verb, path.c_str(),
                                    reason.empty() ? "" : (" (" + reason + ")").c_str()));
}

// cv2's storages cannot be had as OpenCV's own objects without linking to cv2, so that the parameters go through a
// storage in memory.
cv::FileStorage memoryToWrite(const std::string& name = ".yml")
{
    return cv::FileStorage(name, cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
}

cv::FileStorage memoryToRead(cv::FileStorage& written)
{
    return cv::FileStorage(written.releaseAndGetString(), cv::FileStorage::READ | cv::FileStorage::MEMORY);
}

// The detector's parameters as nodes, which are numbers and text only.
cv::FileStorage parameters(const Detector& detector)
{
    cv::FileStorage memory = memoryToWrite();
    detector.share()->write(memory);
    return memoryToRead(memory);
}

}  // namespace

std::string toText(const Detector& self, const std::string& name)
{
    cv::FileStorage memory = memoryToWrite(name);
    self.share()->write(memory);
    return memory.releaseAndGetString();
}

Detector fromText(const std::string& text)
{
    const cv::Ptr<Detector::Library> library = Detector::Library::create();
    const cv::FileStorage memory(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    library->read(memory.root());
    return Detector(library);
}

// By Python, because cv::FileStorage does not tell that a disk is full. The name's end chooses the format.
void writeFile(const Detector& self, const FileNameObject& fileName)
{
    const std::string path = toPath(fileName, "a str, a path or a cv2.FileStorage");
    const size_t end = path.size() > 3 ? path.size() - 3 : path.size();
    const bool isPacked = path.compare(end, std::string::npos, ".gz") == 0;
    py::object content = py::bytes(toText(self, isPacked ? path.substr(0, end) : path));
    if (isPacked)
        content = py::module_::import("gzip").attr("compress")(content);
    try
    {
        const py::object file = py::module_::import("io").attr("open")(py::bytes(path), "wb");
        file.attr("write")(content);
        file.attr("close")();
    }
    catch (const py::error_already_set& error)
    {
        if (!error.matches(PyExc_OSError))
            throw;
        failToOpen(path, "written", messageOf(error));
    }
}

void readFile(Detector& self, const FileNameObject& fileName)
{
    const std::string path = toPath(fileName, "a str, a path or a cv2.FileNode");
    cv::FileStorage storage;
    try
    {
        storage.open(path, cv::FileStorage::READ);
    }
    catch (const cv::Exception& exception)
    {
        failToOpen(path, "read", exception.err);
    }
    if (!storage.isOpened())
        failToOpen(path, "read", "");
    self.change([&](Detector::Library& library) { library.read(storage.root()); });
}

void writeStorage(const Detector& self, const FileStorageObject& storage, const std::string& name)
{
    if (!storage.object.attr("isOpened")().cast<bool>())
        CV_Error(cv::Error::StsBadArg,
                 "fs must be a storage that is open to write, got one that is not open");
    const py::object write = storage.object.attr("write");
    if (!name.empty())
        storage.object.attr("startWriteStruct")(name, int(cv::FileNode::MAP));
    const cv::FileStorage written = parameters(self);
    for (const cv::FileNode& node : written.root())
    {
        if (node.isInt())
            write(node.name(), int(node));
        else if (node.isReal())
            write(node.name(), double(node));
        else
            write(node.name(), std::string(node));
    }
    if (!name.empty())
        storage.object.attr("endWriteStruct")();
}

void readNode(Detector& self, const FileNodeObject& node)
{
    if (!node.object.attr("isMap")().cast<bool>())
        CV_Error_(cv::Error::StsBadArg,
                  ("fn must be a map of the parameters, got %s", node.object.attr("isNone")().cast<bool>()
                                                                     ? "a node that does not exist"
                                                                     : "a node that is no map"));
    const cv::FileStorage known = parameters(self);
    cv::FileStorage memory = memoryToWrite();
    for (const cv::FileNode& parameter : known.root())
    {
        const std::string key = parameter.name();
        const py::object value = node.object.attr("getNode")(key);
        if (parameter.isString() || value.attr("isNone")().cast<bool>())
            continue;
        if (value.attr("isInt")().cast<bool>() || value.attr("isReal")().cast<bool>())
            memory.write(key, value.attr("real")().cast<double>());
        else  // text, for the library to say which parameter should have been a number
            memory.write(key, std::string("no number"));
    }
    const cv::FileStorage given = memoryToRead(memory);
    self.change([&](Detector::Library& library) { library.read(given.root()); });
}

}  // namespace aqorb_python
