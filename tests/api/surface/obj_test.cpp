// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/obj.h"

#include <gtest/gtest.h>

#include "tests/api/surface/cube.h"

namespace ccdt::api {
namespace {

using test::expect_cube;
using test::expect_refused;
using test::kCorners;
using test::kFaces;
using test::read_mesh;

/// Returns the vertices of the cube.
/// @param begin  text before the coordinates
/// @param end    text after the coordinates, without the end of the line
std::string vertices(std::string_view end = "", std::string_view begin = "v ") {
    std::string text;
    for (const auto& [x, y, z] : kCorners)
        text += std::string(begin) + std::to_string(int(x)) + ' ' + std::to_string(int(y)) + ' ' +
                std::to_string(int(z)) + std::string(end) + '\n';
    return text;
}

std::string faces(std::string_view end = "\n") {
    return test::faces("f", end, 1);
}

std::string with_ends(std::string text, std::string_view end) {
    for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + end.size()))
        text.replace(at, 1, end);
    return text;
}

TEST(Obj, ReadsAllVariants) {
    std::string negative, slashes, later = faces() + vertices(), continued, empty;
    for (const auto& face : kFaces) {
        negative += 'f', slashes += 'f', continued += "f \\\n", empty += 'f';
        for (const int corner : face) {
            negative += ' ' + std::to_string(corner - 8);
            slashes += ' ' + std::to_string(corner + 1) + "//" + std::to_string(corner + 1);
            continued += ' ' + std::to_string(corner + 1) + "\\  \n";
            empty += ' ' + std::to_string(corner + 1) + '/';
        }
        negative += '\n', slashes += '\n', continued += '\n', empty += '\n';
    }
    const std::string files[] = {
        vertices() + faces(),
        vertices() + negative,
        vertices() + "vn 0 0 1\n" + slashes,
        vertices() + continued,
        vertices() + empty,
        later,
        vertices("", "  v\t") + test::faces("\t f", "\n", 1),
        vertices(" # vertex") + faces(" # face 7 8 9\n"),
        vertices("# vertex") + faces("#face\n"),
        "# C:\\models\\\n" + vertices() + faces(),
        vertices(" 1") + faces(),
        vertices(" 1.0") + "g a b\no name\ns off\nusemtl wood#1\nmtllib C:\\models\\\n" + faces(),
        vertices(".0e0") + faces(),
        with_ends(vertices() + faces(), "\r\n"),
        with_ends(vertices() + faces(), "\r"),
        with_ends(vertices() + faces(), "\f"),
        with_ends(vertices() + faces(), std::string_view("\0", 1)),
        "\xEF\xBB\xBF" + vertices() + faces(),
        vertices() + faces() + "\x1A",
        vertices() + "v 1.#QNAN -1.#IND nan(ind)\n" + faces(),  // no face uses this vertex
    };
    for (const std::string& file : files) expect_cube(file);
}

TEST(Obj, ReadsNumbersInAllForms) {
    const auto contents = read_mesh("v .25 +1.5 -.5\nv 1e2 1.E+1 -0\nv 1e-400 4.9e-324 0.1\nf 1 2 3\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.vertices, (std::vector<Point3>{{.25, 1.5, -.5}, {100, 10, 0}, {0, 4.9e-324, 0.1}}));
}

TEST(Obj, KeepsAllDigitsOfCoordinates) {
    const auto contents = read_mesh(
        "v 500000.123 4649776.224 312.5\nv 3923201.0123456 300101.7654321 5002777.5\n"
        "v 1 0 0\nf 1 2 3\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.vertices[0], (Point3{500000.123, 4649776.224, 312.5}));
    EXPECT_EQ(contents->soup.vertices[1], (Point3{3923201.0123456, 300101.7654321, 5002777.5}));
}

TEST(Obj, ReadsColoursAfterCoordinates) {
    for (const char* colour : {" 1 .5 0", " 1 .5 0 1", " 255 127.5 0"}) {
        const std::string file = vertices(colour) + faces();
        expect_cube(file);
        const auto contents = read_mesh(file);
        ASSERT_EQ(contents->soup.colours.size(), 24U) << colour;
        EXPECT_EQ(contents->soup.colours[0][0], 1);
        EXPECT_NEAR(contents->soup.colours[0][1], 0.21404, 1e-4);
        EXPECT_EQ(contents->soup.colours[0][2], 0);
    }
    const auto some = read_mesh("v 0 0 0\nv 1 0 0 0 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_EQ(some->soup.colours, (std::vector<std::array<float, 3>>{{1, 1, 1}, {0, 0, 0}, {1, 1, 1}}));
}

TEST(Obj, DividesByTheFourthCoordinateWithAWarning) {
    const auto contents = read_mesh("v 0 0 0 1\nv 2 0 0 2\nv 0 4 0 4\nf 1 2 3\n");
    ASSERT_TRUE(contents) << contents.error().message;
    EXPECT_EQ(contents->soup.vertices, (std::vector<Point3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(contents->warnings,
              std::vector<std::string>{"coordinates are divided by the fourth one: 2; the first is line 2"});
}

TEST(Obj, WarnsOfWhatItIgnores) {
    expect_cube(vertices() + "l 1 2\np 1\n" + faces(), "points and lines, which have no area, are ignored: 2");
    expect_cube(vertices() + faces() + "f 1 2\nf 3\n", "fewer than three corners are ignored: 2; the first is face 6");
    expect_cube(vertices() + faces() + "curv 0 1 1 2\nend\n", "statements of curves are ignored: 2");
    expect_cube(vertices() + faces() + "xyz 1 2\n",
                "unknown statements are ignored: 1; the first is \"xyz\" in line 15");
}

TEST(Obj, IgnoresTextureCoordinatesIfSomeAreMissing) {
    for (const char* corner : {"/1", "/9", "/-3", "/0", "/x"}) {
        std::string text = vertices() + "vt 0 0\nvt 1 1\n";
        for (const auto& face : kFaces) {
            text += 'f';
            for (const int vertex : face) text += ' ' + std::to_string(vertex + 1) + (vertex == 3 ? corner : "/2");
            text += '\n';
        }
        const bool is_right = std::string_view(corner) == "/1";
        expect_cube(text, is_right ? "" : "texture coordinates are ignored, because faces refer to missing ones");
        EXPECT_EQ(read_mesh(text)->soup.texture.empty(), !is_right) << corner;
    }
}

TEST(Obj, IsRecognisedByItsVertices) {
    expect_cube("cstype bezier\n" + vertices() + faces(), "statements of curves are ignored");
    expect_cube("call other.obj\n\n# comment\n" + vertices() + faces(), "unknown statements are ignored");
}

TEST(Obj, NamesThePlaceOfAnError) {
    expect_refused("v 0 0\n", "line 1: a vertex has 2 numbers");
    expect_refused("v 0 0 0\nv 1 2 3 4 5\n", "line 2: a vertex has 5 numbers");
    expect_refused("v 0 0 0\nv 0,5 1 2\nv 1 1 1\nf 1 2 3\n", "line 2: \"0,5\" is not a number");
    expect_refused(vertices() + "f 1 2 9\n", "face 0 (line 9) refers to vertex 9, but there are only 8");
    expect_refused(vertices() + "f 1 2 -9\n", "face 0 (line 9) has the corner \"-9\", which refers to no vertex");
    expect_refused(vertices() + "f 1 2 0\n", "face 0 (line 9) has the corner \"0\"");
    expect_refused(vertices() + faces() + "v -1.#IND 1.#QNAN 1.#INF\nf 9 1 2\n", "vertex 8 (line 15) is not finite");
    expect_refused(vertices() + faces() + "v 0 0 0 0\nf 9 1 2\n", "vertex 8 (line 15) is not finite");
    expect_refused(vertices() + "f 1 2 x\n", "has the corner \"x\"");
    expect_refused(vertices() + "f 1/ 4 2/ 4 3/ 4\n",
                   "face 0 (line 9) has the corner \"4\", which follows a slash and a blank");
}

}  // namespace
}  // namespace ccdt::api
