// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "test_precomp.hpp"

#include "detector/parameter_table.hpp"

namespace opencv_test
{
namespace
{

void writeAs(const std::string& name, const Algorithm& algorithm, FileStorage& fs)
{
    fs << name << "{";
    algorithm.write(fs);
    fs << "}";
}

std::string written(const Algorithm& algorithm)
{
    FileStorage fs("memory.yml", FileStorage::WRITE | FileStorage::MEMORY);
    writeAs("detector", algorithm, fs);
    return fs.releaseAndGetString();
}

void readFrom(Algorithm& algorithm, const std::string& text)
{
    FileStorage fs(text, FileStorage::READ | FileStorage::MEMORY);
    algorithm.read(fs["detector"]);
}

std::string withValue(const std::string& key, const std::string& value)
{
    return "%YAML:1.0\n---\ndetector:\n   " + key + ": " + value + "\n";
}

// Another value, which is valid for every parameter.
int another(int value)
{
    return value + 1;
}
double another(double value)
{
    return std::max(value, 0.) + 1. / 3;  // with more digits than a float has
}
bool another(bool value)
{
    return !value;
}
template <typename Enumeration> Enumeration another(Enumeration value)
{
    return Enumeration(1 - value);
}

//! No parameter has its default.
Ptr<AdaptiveQuadtreeORB> unusual()
{
    const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create();
#define AQORB_SET(property, ...) detector->set##property(another(detector->get##property()));
    AQORB_PARAMETERS(AQORB_SET)
#undef AQORB_SET
    return detector;
}

TEST(Aqorb_IO, every_parameter_makes_the_round_trip)
{
    const Ptr<AdaptiveQuadtreeORB> source = unusual(), target = AdaptiveQuadtreeORB::create();
    readFrom(*target, written(*source));
#define AQORB_EXPECT(property, ...) EXPECT_EQ(source->get##property(), target->get##property());
    AQORB_PARAMETERS(AQORB_EXPECT)
#undef AQORB_EXPECT
}

TEST(Aqorb_IO, keys_are_those_of_orb_in_newer_opencv_then_ours)
{
    const std::string text = written(*unusual());
    FileStorage fs(text, FileStorage::READ | FileStorage::MEMORY);
    const FileNode node = fs["detector"];
    EXPECT_EQ("Feature2D.AdaptiveQuadtreeORB", (std::string)node["name"]);
    size_t position = 0;
    for (const char* key :
         {"nfeatures", "scaleFactor", "nlevels", "edgeThreshold", "firstLevel", "wta_k", "scoreType",
          "patchSize", "fastThreshold", "adaptiveThreshold", "minThresholdRatio", "selectionType",
          "strengthWeight", "rankRadius", "octaveSuppression", "subPixel"})
    {
        const size_t next = text.find(std::string(" ") + key + ":", position);
        ASSERT_NE(std::string::npos, next) << key << " is missing or not in its place";
        position = next;
    }
    EXPECT_EQ(3, (int)node["format"]);  // as every Algorithm of OpenCV 4
    EXPECT_EQ(501, (int)node["nfeatures"]);
    EXPECT_EQ(3, (int)node["wta_k"]);
    EXPECT_EQ(32, (int)node["patchSize"]);
}

TEST(Aqorb_IO, every_format_of_file_storage_serves)
{
    for (const char* name : {"memory.yml", "memory.xml", "memory.json"})
    {
        FileStorage out(name, FileStorage::WRITE | FileStorage::MEMORY);
        unusual()->write(out);
        const Ptr<AdaptiveQuadtreeORB> target = AdaptiveQuadtreeORB::create();
        FileStorage in(out.releaseAndGetString(), FileStorage::READ | FileStorage::MEMORY);
        target->read(in.root());
        EXPECT_EQ(written(*unusual()), written(*target)) << name;
    }
}

TEST(Aqorb_IO, a_missing_key_keeps_its_value)
{
    const Ptr<AdaptiveQuadtreeORB> detector = unusual();
    readFrom(*detector, withValue("patchSize", "77"));
    EXPECT_EQ(77, detector->getPatchSize());
    EXPECT_EQ(501, detector->getMaxFeatures());
    EXPECT_FALSE(detector->getSubPixel());
    readFrom(*detector, withValue("cellSize", "3"));  // of version 0.3
    EXPECT_EQ(77, detector->getPatchSize());
}

TEST(Aqorb_IO, a_bad_value_throws_and_changes_nothing)
{
    // Of the ranges only some, as setters check them in the same way.
    const char* bad[][2] = {
        {"nfeatures", "-1"},         {"nfeatures", "many"},         {"nfeatures", "1.5"},
        {"nfeatures", "1e12"},       {"scaleFactor", ".nan"},       {"wta_k", "5"},
        {"scoreType", "2"},          {"selectionType", "0.5"},      {"selectionType", "quadtree"},
        {"strengthWeight", "1e4"},   {"octaveSuppression", ".inf"}, {"subPixel", "2"},
        {"adaptiveThreshold", "yes"}};
    const Ptr<AdaptiveQuadtreeORB> detector = unusual();
    const std::string before = written(*detector);
    for (const char** entry : bad)
    {
        // The good value before the bad one must not be kept, either.
        const std::string text = withValue("fastThreshold", "99") + "   " + entry[0] + ": " + entry[1] + "\n";
        const std::string message = messageOf([&] { readFrom(*detector, text); });
        EXPECT_EQ(0u, message.find(entry[0] + std::string(" must be "))) << entry[1] << ": " << message;
        EXPECT_EQ(before, written(*detector)) << entry[0];
    }
}

TEST(Aqorb_IO, works_with_files_and_algorithm_load)
{
    const std::string text = written(*unusual());
    const Ptr<AdaptiveQuadtreeORB> detector = Algorithm::loadFromString<AdaptiveQuadtreeORB>(text);
    ASSERT_TRUE(detector);
    EXPECT_EQ(text, written(*detector));

    // Such a file holds the parameters themselves, where load looks for a map of them.
    const std::string file = tempfile(".yml");
    const auto saves = [&](const Algorithm& algorithm)
    { return messageOf([&] { algorithm.save(file); }).empty(); };
    EXPECT_EQ(saves(*ORB::create()), saves(*detector));
    detector->write(file);
    const Ptr<ORB> again = AdaptiveQuadtreeORB::create();
    again->read(file);
    EXPECT_EQ(text, written(*again));
    const std::string message = messageOf([&] { Algorithm::load<AdaptiveQuadtreeORB>(file); });
    EXPECT_NE(std::string::npos, message.find("read(fileName)")) << message;

    // A file may hold several detectors, which are found by name.
    {
        FileStorage fs(file, FileStorage::WRITE);
        writeAs("first", *AdaptiveQuadtreeORB::create(44), fs);
        writeAs("second", *unusual(), fs);
    }
    EXPECT_EQ(44, Algorithm::load<AdaptiveQuadtreeORB>(file, "first")->getMaxFeatures());
    EXPECT_EQ(text, written(*Algorithm::load<AdaptiveQuadtreeORB>(file, "second")));
    std::remove(file.c_str());
}

TEST(Aqorb_IO, what_was_read_is_what_is_used)
{
    const Mat image = makeScene(Size(200, 150));
    const Ptr<AdaptiveQuadtreeORB> target = AdaptiveQuadtreeORB::create();
    detectAndCompute(*target, image);
    readFrom(*target, written(*unusual()));
    const Features expected = detectAndCompute(*unusual(), image);
    EXPECT_FALSE(expected.keypoints.empty());
    EXPECT_TRUE(sameFeatures(expected, detectAndCompute(*target, image)));
}

TEST(Aqorb_IO, a_storage_node_that_is_no_map)
{
    // XML reads an empty map as nothing at all: all keys are missing, which is no error.
    const char* good[] = {
        "<?xml version=\"1.0\"?>\n<opencv_storage>\n<detector>\n</detector>\n</opencv_storage>\n",
        "%YAML:1.0\n---\ndetector:\n   {}\n"};
    for (const char* text : good)
    {
        const Ptr<AdaptiveQuadtreeORB> detector = AdaptiveQuadtreeORB::create(77);
        EXPECT_NO_THROW(readFrom(*detector, text)) << text;
        EXPECT_EQ(77, detector->getMaxFeatures());
    }
    for (const std::string value : {"5", "text", "[ 1, 2 ]"})
    {
        const std::string text = "%YAML:1.0\n---\ndetector: " + value + "\n";
        const std::string message = messageOf([&] { readFrom(*AdaptiveQuadtreeORB::create(), text); });
        EXPECT_NE(std::string::npos, message.find("must be a map of the parameters")) << text << message;
    }
}

}  // namespace
}  // namespace opencv_test
