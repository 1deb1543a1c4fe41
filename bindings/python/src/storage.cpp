// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "storage.hpp"

#include "errors.hpp"

namespace aqorb_python
{

namespace
{

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
    if (!PyUnicode_FSConverter(path.ptr(), &bytes))  // a ValueError: the path has a zero in it
        throw py::error_already_set();
    return py::reinterpret_steal<py::bytes>(bytes);
}

cv::FileStorage open(const std::string& path, int mode, const char* verb)
{
    std::string reason;
    try
    {
        const cv::FileStorage storage(path, mode);
        if (storage.isOpened())
            return storage;
    }
    catch (const cv::Exception& exception)
    {
        reason = ": " + exception.err;
    }
    CV_Error_(cv::Error::StsError, ("fileName: '%s' cannot be %s%s", path.c_str(), verb, reason.c_str()));
}

// cv2's storages cannot be had as OpenCV's own objects without linking to cv2, so that the parameters go through a
// storage in memory.
cv::FileStorage memoryToWrite()
{
    return cv::FileStorage(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
}

cv::FileStorage memoryToRead(cv::FileStorage& written)
{
    return cv::FileStorage(written.releaseAndGetString(), cv::FileStorage::READ | cv::FileStorage::MEMORY);
}

// The detector's parameters as nodes, which are numbers and text only.
cv::FileStorage parameters(const Detector& detector)
{
    cv::FileStorage memory = memoryToWrite();
    detector.get().write(memory);
    return memoryToRead(memory);
}

}  // namespace

std::string toText(const Detector& self)
{
    cv::FileStorage memory = memoryToWrite();
    self.get().write(memory);
    return memory.releaseAndGetString();
}

Detector fromText(const std::string& text)
{
    const cv::Ptr<Detector::Library> library = Detector::Library::create();
    const cv::FileStorage memory(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    library->read(memory.root());
    return Detector(library);
}

void writeFile(const Detector& self, const FileNameObject& fileName)
{
    const std::string path = toPath(fileName, "a str, a path or a cv2.FileStorage");
    cv::FileStorage storage = open(path, cv::FileStorage::WRITE, "written");
    self.get().write(storage);
}

void readFile(Detector& self, const FileNameObject& fileName)
{
    const std::string path = toPath(fileName, "a str, a path or a cv2.FileNode");
    const cv::FileStorage storage = open(path, cv::FileStorage::READ, "read");
    self.change().read(storage.root());
}

void writeStorage(const Detector& self, const FileStorageObject& storage, const std::string& name)
{
    if (!storage.object.attr("isOpened")().cast<bool>())
        CV_Error(cv::Error::StsBadArg,
                 "fs: got a storage that is not open; one that is open to write is accepted");
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
                  ("fn: got %s; a map of the parameters is accepted",
                   node.object.attr("isNone")().cast<bool>() ? "a node that does not exist"
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
    self.change().read(given.root());
}

}  // namespace aqorb_python
