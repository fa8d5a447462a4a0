// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/point_file_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "api/output/npy_header.h"

namespace ccdt::api {
namespace {

using Points = std::vector<Point>;

std::string array_of(std::size_t columns, std::vector<double> values) {
    return npy_header("<f8", values.size() / columns, columns) +
           std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
}

TEST(PointFileReader, ReadsTheColumnsXAndYOfCsv) {
    const Points expected{{0.5, -1e-3}, {2, 3}};
    EXPECT_EQ(read_point_file("x,y\r\n0.5,-1e-3\r\n2,3\r\n", {}), expected);
    EXPECT_EQ(read_point_file("x,y\n0.5,-0.001\n2,3", {}), expected);
    EXPECT_EQ(read_point_file("\"y\",name,x\n-1e-3,\"a \"\"b\"\",\nc\",0.5\n3,,2\n", {}), expected);
    EXPECT_EQ(read_point_file("x,y\r\n", {}), Points());
}

TEST(PointFileReader, IgnoresAByteOrderMark) {
    EXPECT_EQ(read_point_file("\xEF\xBB\xBFx,y\n1,2\n", {}), (Points{{1, 2}}));
    EXPECT_EQ(read_point_file("\xEF\xBB\xBF[[1,2]]", {}), (Points{{1, 2}}));
}

TEST(PointFileReader, ReadsTheFirstColumnsOfNpy) {
    EXPECT_EQ(read_point_file(array_of(2, {1, 2, 3, 4}), {}), (Points{{1, 2}, {3, 4}}));
    EXPECT_EQ(read_point_file(array_of(3, {1, 2, 9, 3, 4, 9}), {}), (Points{{1, 2}, {3, 4}}));
    EXPECT_EQ(read_point_file(array_of(2, {}), {}), Points());
}

TEST(PointFileReader, ReadsListsAnswersAndGeoJson) {
    const Points expected{{1, 2}, {3, 4}};
    EXPECT_EQ(read_point_file(" [[1,2],[3,4]]", {}), expected);
    EXPECT_EQ(read_point_file(R"({"sites":2,"points":[[1,2],[3,4]]})", {}), expected);
    EXPECT_EQ(read_point_file(R"({"type":"MultiPoint","coordinates":[[1,2],[3,4]]})", {}), expected);
}

TEST(PointFileReader, ReadsThreeCoordinatesOfPointsInSpace) {
    const std::vector<Point3> expected{{1, 2, 3}, {4, 5, 6}};
    EXPECT_EQ(read_point_file3("z,face,x,y\n3,0,1,2\n6,0,4,5\n", {}), expected);
    EXPECT_EQ(read_point_file3(array_of(4, {1, 2, 3, 9, 4, 5, 6, 9}), {}), expected);
    EXPECT_EQ(read_point_file3("[[1,2,3],[4,5,6]]", {}), expected);
    EXPECT_EQ(read_point_file3(R"({"seed":1,"points":[[1,2,3],[4,5,6]]})", {}), expected);
}

TEST(PointFileReader, ReadsTheVerticesOfAPly) {
    const std::vector<Point3> expected{{1, 2, 3}, {4, 5, 6}};
    const std::string text =
        "ply\r\nformat ascii 1.0\ncomment x\nelement vertex 2\nproperty uchar red\nproperty float z\n"
        "property float x\nproperty double y\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"
        "7 3 1 2\n8 6 4 5\n";
    EXPECT_EQ(read_point_file3(text, {}), expected);
    EXPECT_EQ(read_point_file(text, {}), (Points{{1, 2}, {4, 5}}));
    std::string binary =
        "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty uchar red\n"
        "property double y\nproperty double z\nend_header\n";
    const auto append = [&](auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
    for (const Point3 p : expected) {
        append(static_cast<float>(p.x));
        append('r');
        append(p.y);
        append(p.z);
    }
    EXPECT_EQ(read_point_file3(binary, {}), expected);
    const auto message_of = [](const std::string& file) { return read_point_file3(file, {}).error().message; };
    EXPECT_NE(message_of(binary.substr(0, binary.size() - 1)).find("vertex 1 of 2 is incomplete"), std::string::npos);
    EXPECT_NE(message_of("ply\nformat ascii 1.0\nelement vertex 1\n").find("no end"), std::string::npos);
    EXPECT_NE(message_of(text.substr(0, text.size() - 2)).find("vertex 1 of 2 is incomplete"), std::string::npos);
    EXPECT_NE(message_of(text.substr(0, text.size() - 2) + "nan").find("vertex 1 of the PLY has no finite y"),
              std::string::npos);
    EXPECT_EQ(read_point_file3(binary, {.max_sites = 1}).error().code, ErrorCode::LimitExceeded);
}

TEST(PointFileReader, TellsPointsInSpaceByThePlyOrTheColumnZ) {
    EXPECT_TRUE(is_point_file3("ply\nformat ascii 1.0\n"));
    EXPECT_TRUE(is_point_file3("x,y,z\r\n1,2,3\r\n"));
    EXPECT_FALSE(is_point_file3("x,y,radius\n1,2,3\n"));
    EXPECT_FALSE(is_point_file3("[[1,2,3]]"));
    EXPECT_FALSE(is_point_file3(""));
}

TEST(PointFileReader, RefusesPointsInSpaceWithoutAThirdCoordinate) {
    const auto message_of = [](const std::string& file) { return read_point_file3(file, {}).error().message; };
    EXPECT_NE(message_of("x,y\n1,2\n").find("x, y and z"), std::string::npos);
    EXPECT_NE(message_of(array_of(2, {1, 2})).find("three columns"), std::string::npos);
    EXPECT_NE(message_of("[[1,2,3],[1,2]]").find("/1 must be a position [x, y, z]"), std::string::npos);
    EXPECT_NE(message_of("[[1,2,\"3\"]]").find("/0 must be a position [x, y, z]"), std::string::npos);
    EXPECT_NE(message_of("[[1,2,3,4]]").find("/0 must be a position [x, y, z]"), std::string::npos);
    EXPECT_NE(message_of(R"({"points":{}})").find("/points must be a list"), std::string::npos);
    EXPECT_NE(message_of("x,y,z\n1,2,inf\n").find("line 2: z must be a finite number"), std::string::npos);
    EXPECT_NE(message_of(array_of(3, {1, 2, NAN})).find("row 0"), std::string::npos);
    Limits one;
    one.max_sites = 1;
    EXPECT_EQ(read_point_file3("[[1,2,3],[4,5,6]]", one).error().code, ErrorCode::LimitExceeded);
}

TEST(PointFileReader, ReadsSequencesOfFeatures) {
    const std::string one = R"({"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}})";
    for (const std::string& text : {one + "\n" + one + "\n", "\x1E" + one + "\n\x1E" + one + "\n"}) {
        const auto points = read_point_file(text, {});
        ASSERT_TRUE(points) << points.error().message;
        EXPECT_EQ(*points, (std::vector<Point>{{1, 2}, {1, 2}}));
    }
}

TEST(PointFileReader, ReadsOtherNumbersOfNpy) {
    const auto points = read_point_file(npy_header("<f2", 1, 2) + std::string("\x00\x3c\x00\xc0", 4), {});
    ASSERT_TRUE(points) << points.error().message;
    EXPECT_EQ(*points, (std::vector<Point>{{1, -2}}));
}

TEST(PointFileReader, NamesTheLineRowOrPointerOfAFault) {
    struct Case {
        std::string file;
        std::string_view named;
    };
    const std::string header = array_of(2, {}), texts = npy_header("<U4", 1, 2);
    const Case cases[] = {
        {"", "the file is empty"},
        {"%PDF-1.7", "seems to be PDF; points are read from CSV"},
        {"a,b\n1,2\n", "line 1"},
        {"x\n1\n", "line 1"},
        {"x,y\n1,2\n1,2,3\n", "line 3 has 3 columns; the first line has 2"},
        {"x,y\n1,2\n\n", "line 3 has 1 columns"},
        {"x,y,t\n1,2,\"a\nb\"\n1,z,c\n", "line 4: y must be a finite number, not 'z'"},
        {"x,y\n1,inf\n", "line 2: y must be a finite number"},
        {"x,y\n1,\"2\n", "line 2: a quoted field has no end"},
        {"x,y\n1,\"2\"3\n", "line 2: there is text after a quoted field"},
        {"\x93NUMPY\x02", "ends within its header"},
        {header.substr(0, 9), "ends within its header"},
        {header.substr(0, 60), "ends within its header"},
        {array_of(1, {1, 2}), "at least two columns"},
        {texts + "12345678", "an array of numbers"},
        {array_of(2, {1, 2}) + "x", "has 17 bytes of data"},
        {npy_header("<f8", 0, 2) + "12345678", "has 8 bytes of data"},
        {npy_header("<f8", 1, 3) + std::string(16, '\0'), "has 16 bytes of data"},
        {array_of(2, {1, 2, 3, NAN}), "row 1 of the NPY file is not finite"},
        {R"({"points":[[1,2],[3]]})", "/points/1"},
        {R"({"sets":[]})", "/type is missing"},
        {"[[1,2]", "JSON"},
    };
    for (const auto& [file, named] : cases) {
        const auto points = read_point_file(file, {});
        ASSERT_FALSE(points) << file;
        EXPECT_EQ(points.error().code, ErrorCode::Malformed) << file;
        EXPECT_NE(points.error().message.find(named), std::string::npos) << points.error().message;
    }
}

TEST(PointFileReader, LimitsTheNumberOfPoints) {
    const Limits two{.max_sites = 2};
    for (const std::string& file :
         {std::string("x,y\n1,2\n3,4\n5,6\n"), array_of(2, {1, 2, 3, 4, 5, 6}), std::string("[[1,2],[3,4],[5,6]]")}) {
        const auto points = read_point_file(file, two);
        ASSERT_FALSE(points);
        EXPECT_EQ(points.error().code, ErrorCode::LimitExceeded);
        EXPECT_NE(points.error().message.find("max-sites"), std::string::npos);
    }
}

}  // namespace
}  // namespace ccdt::api
