// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/off.h"

#include <gtest/gtest.h>

#include "tests/api/surface/cube.h"

namespace ccdt::api {
namespace {

using test::corners;
using test::expect_cube;
using test::expect_refused;
using test::faces;
using test::read_mesh;

TEST(Off, ReadsAllVariants) {
    const std::string files[] = {
        "OFF\n8 6 12\n" + corners("\n") + faces("4", "\n"),
        "OFF 8 6 12\n" + corners("\n") + faces("4", "\n"),
        "OFF8 6 12\n" + corners("\n") + faces("4", "\n"),
        "OFF\n8 6\n" + corners("\n") + faces("4", "\n"),
        "OFF\n8\n6\n12\n" + corners("\n") + faces("4", "\n"),
        "# first\nOFF # keyword\n# counts\n8 6 12 # counts\n\n" + corners(" # vertex\n\n") + faces("4", " # face\n"),
        "OFF 8 6 12 " + corners(" ") + faces("4", " "),
        "OFF\n8 6 12\n" + corners(" ") + '\n' + faces("4", "\n"),
        "OFF\n8 6 12\n" + corners("\n") + faces("4", " "),
        "OFF\n8 6 12\n" + corners("\n") + faces("4\n", "\n"),
        "OFF\r\n8 6 12\r\n" + corners("\r\n") + faces("4", "\r\n"),
        "OFF\r8 6 12\r" + corners("\r") + faces("4", "\r"),
        "OFF\n8 6 12\n" + corners("\n") + faces("4", " 255 0 0\n"),
        "OFF\n8 6 12\n" + corners("\n") + faces("4", " 1 0 0 0.5\n"),
        "OFF\n8 6 12\n" + corners("\n") + faces("4", " 3\n"),
        "OFF\n8 6 12\n" + corners("\n") + faces("4 \n", " 1 0 0\n"),
        "NOFF\n8 6 12\n" + corners(" 0 0 1\n") + faces("4", "\n"),
        "COFF\n8 6 12\n" + corners(" 255 0 0 255\n") + faces("4", "\n"),
        "CNOFF\n8 6 12\n" + corners(" 0 0 1 255 0 0\n") + faces("4", " 0 255 0\n"),
        "CNOFF\n8 6 12\n" + corners(" 0 0 1 1 0 0 1 ") + faces("4", " "),
        "STCNOFF 8 6 12\n" + corners(" 0 0 1 1 0 0 1 .5 .25\n") + faces("4", "\n"),
        "STOFF 8 6 12\n" + corners(" .5 .25 ") + faces("4", " "),
    };
    for (const std::string& file : files) expect_cube(file);
    expect_cube("off\n8 6 12\n" + corners("\n") + faces("4", "\n"));
    expect_refused("NCOFF 8 6 0\n" + corners(" 1 0 0 1 0 0 1 2\n") + faces("4", "\n"), "vertex 0");
    const std::string unknown = "their order is not known: 8; the first is vertex 0";
    expect_cube("NCOFF\n8 6 0\n" + corners(" 255 0 0 255 0 0 1\n") + faces("4", "\n"), unknown);
    expect_cube("NCOFF\n8 6 0\n" + corners(" 0 0 1 255 0 0\n") + faces("4", "\n"), unknown);
    expect_cube("NCSTOFF 8 6 0 " + corners(" 255 0 0 255 0 0 1 .5 .25 ") + faces("4", " "), unknown);
    expect_cube("OFF 8 6 12\n" + corners(" 255 0 0\n") + faces("4", "\n"), "numbers after the positions");
}

TEST(Off, ReadsColoursAndTextureCoordinates) {
    for (const char* colour : {"255 0 0 255", "255 0 0", "1 0 0 1", "1.0 0 0"}) {
        const auto contents =
            read_mesh("STCOFF 8 6 12\n" + corners(' ' + std::string(colour) + " .5 .25\n") + faces("4", "\n"));
        ASSERT_TRUE(contents) << contents.error().message;
        EXPECT_EQ(contents->soup.colours.at(7), (std::array<float, 3>{1, 0, 0})) << colour;
        EXPECT_EQ(contents->soup.texture.at(7), (std::array<float, 2>{0.5F, 0.25F})) << colour;
    }
}

TEST(Off, NamesThePlaceOfAnError) {
    const std::string start = "OFF 8 6 12\n" + corners("\n");
    expect_refused("4OFF 8 6 12\n", "vertices with other than three coordinates are not supported");
    expect_refused("nOFF 3\n8 6 12\n", "vertices with other than three coordinates are not supported");
    expect_refused("OFF BINARY\n", "binary OFF is not supported");
    expect_refused("OFF 8 x 12\n", "line 1: the numbers of vertices and faces do not follow");
    expect_refused(start + faces("4", "\n") + "4 0 1 2 3\n", "line 16: there is \"4\" after the last face");
    expect_refused(start + "4 0 1 2 3\n", "it ends before face 1");
    expect_refused(start + faces("5", "\n"), "it ends before face 3");
    expect_refused(start + faces("4", "\n").replace(4, 1, "8"), "face 0 (line 10) refers to vertex 8");
    expect_refused("OFF 3 1 0\n0 0 0\n1 0 q\n0 1 0\n3 0 1 2\n", "line 3: vertex 1 has \"q\" instead of a number");
    expect_refused("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n", "face 0 (line 5) refers to vertex \"-2\"");
}

}  // namespace
}  // namespace ccdt::api
