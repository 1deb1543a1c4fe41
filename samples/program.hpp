// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// How every sample takes its arguments, reads and writes images, and ends. cv::CommandLineParser ignores
// options that it does not know, reads 12abc as 12 and takes a fixed number of files.

#ifndef AQORB_SAMPLES_PROGRAM_HPP
#define AQORB_SAMPLES_PROGRAM_HPP

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/filesystem.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

enum ExitCode
{
    DONE = 0,
    FAILED = 1,        // a file cannot be read or written, or there is no result
    BAD_ARGUMENTS = 2  // as Python's argparse
};

//! Ends the program with one sentence.
struct Failure
{
    int exitCode;
    cv::String message;
};

struct Option
{
    cv::String name;
    cv::String value;  // the default; FLAG: the option takes no value
    cv::String help;
};

const char* const FLAG = "\n";  // no option has this default

//! What a program says about itself.
struct Program
{
    cv::String name, about;
    cv::String files;  // as in the line of usage, for example "[IMAGE]"
    size_t fewestFiles, mostFiles;
    std::vector<Option> options;
    cv::String example;
};

//! The arguments that a program was called with.
struct Arguments
{
    std::vector<cv::String> files;
    std::map<cv::String, cv::String> values;  // of options, by name; FLAG: not given

    //! The file of this index, or the default where there are fewer.
    cv::String file(size_t index, const cv::String& fallback) const
    {
        return index < files.size() ? files[index] : fallback;
    }

    bool has(const cv::String& flag) const { return values.at(flag) != FLAG; }

    cv::String text(const cv::String& option) const { return values.at(option); }

    int wholeNumber(const cv::String& option, int low, int high) const
    {
        const cv::String value = text(option);
        char* end = nullptr;
        errno = 0;
        const long number = std::strtol(value.c_str(), &end, 10);
        if (value.empty() || *end || errno || number < low || number > high)
            throw Failure{BAD_ARGUMENTS, cv::format("--%s=%s: a whole number from %d to %d is accepted",
                                                    option.c_str(), value.c_str(), low, high)};
        return int(number);
    }

    int featureCount(const cv::String& option = "nfeatures") const { return wholeNumber(option, 1, 1000000); }
};

inline void printHelp(const Program& program)
{
    std::printf("Usage: %s [OPTION ...] %s\n\n%s\n\nOptions:\n", program.name.c_str(), program.files.c_str(),
                program.about.c_str());
    for (const Option& option : program.options)
    {
        const bool isFlag = option.value == FLAG;
        const cv::String label = "--" + option.name + (isFlag ? "" : "=VALUE");
        const cv::String value =
            isFlag ? "" : " (default: " + (option.value.empty() ? "none" : option.value) + ")";
        std::printf("  %-20s %s%s\n", label.c_str(), option.help.c_str(), value.c_str());
    }
    std::printf("  %-20s print this text\n\nExample:\n  %s\n\n", "--help", program.example.c_str());
    std::printf("Exit code: 0 done; 1 a file cannot be read or written, or there is no result;\n"
                "2 an argument is not accepted.\n");
}

inline Arguments parseArguments(const Program& program, int argc, char** argv)
{
    Arguments arguments;
    for (const Option& option : program.options)
        arguments.values[option.name] = option.value;
    for (int i = 1; i < argc; i++)
    {
        const cv::String argument = argv[i];
        if (argument.compare(0, 2, "--") != 0)
        {
            if (argument.size() > 1 && argument[0] == '-')
                throw Failure{BAD_ARGUMENTS, argument + ": unknown option; see --help"};
            arguments.files.push_back(argument);
            continue;
        }
        const size_t equals = argument.find('=');
        const cv::String name = argument.substr(2, equals == cv::String::npos ? equals : equals - 2);
        const auto value = arguments.values.find(name);
        if (value == arguments.values.end())
            throw Failure{BAD_ARGUMENTS, argument + ": unknown option; see --help"};
        bool isFlag = false;
        for (const Option& option : program.options)
            isFlag |= option.name == name && option.value == FLAG;
        if (isFlag && equals != cv::String::npos)
            throw Failure{BAD_ARGUMENTS, argument + ": the option takes no value"};
        if (!isFlag && equals == cv::String::npos && i + 1 == argc)
            throw Failure{BAD_ARGUMENTS, argument + ": the option needs a value, " + argument + "=VALUE"};
        if (isFlag)
            value->second = "";
        else
            value->second = equals == cv::String::npos ? argv[++i] : argument.substr(equals + 1);
    }
    if (arguments.files.size() > program.mostFiles)
        throw Failure{BAD_ARGUMENTS,
                      arguments.files[program.mostFiles] + ": one argument too many; see --help"};
    if (arguments.files.size() < program.fewestFiles)
        throw Failure{BAD_ARGUMENTS, "the arguments " + program.files + " are needed; see --help"};
    return arguments;
}

//! Runs a program and gives its exit code.
inline int runProgram(const Program& program, void (*run)(const Arguments&), int argc, char** argv)
{
    // The one sentence below is enough. OpenCV would add several lines of its own.
    if (!std::getenv("OPENCV_LOG_LEVEL"))
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    for (int i = 1; i < argc; i++)
        if (argv[i] == cv::String("--help") || argv[i] == cv::String("-h"))
        {
            printHelp(program);
            return DONE;
        }
    try
    {
        run(parseArguments(program, argc, argv));
        return DONE;
    }
    catch (const Failure& failure)
    {
        std::fprintf(stderr, "%s: %s\n", program.name.c_str(), failure.message.c_str());
        return failure.exitCode;
    }
    catch (const std::exception& exception)
    {
        std::fprintf(stderr, "%s: %s\n", program.name.c_str(), exception.what());
        return FAILED;
    }
}

//! The path of a file, or of one of OpenCV's sample files.
inline cv::String findFile(const cv::String& name)
{
    const cv::String path = cv::samples::findFile(name, false, true);
    if (path.empty())
        throw Failure{FAILED, name + ": no such file, nor one of OpenCV's samples in the folder that the "
                                     "variable OPENCV_SAMPLES_DATA_PATH names"};
    return path;
}

//! Ends the program where an image is too small to hold features.
inline void requireSize(const cv::String& name, const cv::Mat& image, int smallestSide = 32)
{
    if (std::min(image.cols, image.rows) < smallestSide)
        throw Failure{FAILED, cv::format("%s: has %dx%d pixels; at least %dx%d are accepted", name.c_str(),
                                         image.cols, image.rows, smallestSide, smallestSide)};
}

//! Reads an image file, or one of OpenCV's sample images.
inline cv::Mat readImage(const cv::String& name, int flags = cv::IMREAD_GRAYSCALE, int smallestSide = 32)
{
    cv::Mat image;
    try
    {
        image = cv::imread(findFile(name), flags);
    }
    catch (const cv::Exception&)  // larger than OpenCV reads
    {
    }
    if (image.empty())
        throw Failure{FAILED, name + ": not an image that OpenCV can read"};
    requireSize(name, image, smallestSide);
    return image;
}

//! Writes a picture and says where it is.
inline void writePicture(const cv::String& path, const cv::Mat& picture, int quality = 85)
{
    bool written = false;
    try
    {
        written = cv::imwrite(path, picture, {cv::IMWRITE_JPEG_QUALITY, quality});
    }
    catch (const cv::Exception&)  // no such format, or too large for it
    {
    }
    if (!written)
        throw Failure{FAILED, cv::format("%s: a picture of %dx%d pixels cannot be written there; a name in "
                                         "an existing folder that ends in .png or .jpg is accepted",
                                         path.c_str(), picture.cols, picture.rows)};
    std::printf("Picture: %s\n", cv::utils::fs::canonical(path).c_str());
}

//! The path of a file in an existing folder.
inline cv::String pathIn(const cv::String& folder, const cv::String& file)
{
    if (!cv::utils::fs::isDirectory(folder))
        throw Failure{FAILED, "--out=" + folder + ": an existing folder is accepted"};
    return cv::utils::fs::join(folder, file);
}

#endif
