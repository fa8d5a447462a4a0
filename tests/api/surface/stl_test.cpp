// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/stl.h"

#include <gtest/gtest.h>

#include "tests/api/surface/cube.h"
#include "tests/support/mesh_files.h"

namespace ccdt::api {
namespace {

using test::expect_cube;
using test::expect_refused;
using test::kCorners;
using test::kFaces;
using test::read_mesh;

/// Returns the coordinates of the triangles of the cube [12][9].
std::vector<float> coordinates() {
    std::vector<float> values;
    for (const auto& face : kFaces) {
        for (const std::size_t k : {0, 1, 2, 0, 2, 3}) {
            const auto& [x, y, z] = kCorners[static_cast<std::size_t>(face[k])];
            for (const double ordinate : {x, y, z}) values.push_back(static_cast<float>(ordinate));
        }
    }
    return values;
}

/// Returns facets of the cube as text.
std::string facets(std::size_t begin = 0, std::size_t end = 12, std::string_view normal = "normal 0 0 1") {
    const auto values = coordinates();
    std::string text;
    for (std::size_t i = begin; i < end; ++i) {
        text += "facet " + std::string(normal) + "\nouter loop\n";
        for (std::size_t k = 0; k < 9; ++k)
            text += (k % 3 == 0 ? "vertex " : " ") + std::to_string(values[9 * i + k]) + (k % 3 == 2 ? "\n" : "");
        text += "endloop\nendfacet\n";
    }
    return text;
}

std::string upper(std::string text) {
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

std::string in_one_line(std::string text) {
    for (char& c : text) c = c == '\n' ? ' ' : c;
    return text;
}

TEST(Stl, ReadsAllVariantsOfText) {
    const std::string plain = "solid cube\n" + facets() + "endsolid cube\n";
    const std::string files[] = {
        plain,
        "solid\n" + facets() + "endsolid\n",
        "  solid facet of a solid # 1\n" + facets() + "endsolid facet of a solid # 1\n",
        "solid a\n" + facets(0, 5) + "endsolid a\nsolid b\nendsolid b\nsolid\n" + facets(5) + "endsolid",
        "solid\n" + facets(0, 12, "normal -nan(ind) -nan(ind) -nan(ind)") + "endsolid\n",
        "solid\n" + facets(0, 12, "normal") + "endsolid\n",
        upper(plain),
        in_one_line(plain),
        plain + "\x1A",
    };
    for (const std::string& file : files) expect_cube(file);
    expect_cube("solid cube\n" + facets(), "a solid has no end");
}

TEST(Stl, ReadsBinaryFilesThatLookLikeText) {
    std::string file = binary_stl(coordinates());
    for (const std::string_view head : {"", "solid part", "\n", "OFF 8 6 12\n", "v 0 0 0\n"}) {
        std::string named = file;
        named.replace(0, head.size(), head);
        expect_cube(named);
        expect_cube(named + '\0', "bytes after the last facet are ignored: 1; the first is byte 684");
        expect_cube(named + std::string(49, 'x'), "bytes after the last facet are ignored");
    }
    file.replace(0, 5, "solid");
    expect_cube(file + std::string(5000, 'x'), "bytes after the last facet are ignored");
    expect_refused(file.substr(0, file.size() - 1), "announces 12 facets, which need 684 bytes, but the file has 683");
    file[80] = 13;
    expect_refused(file, "announces 13 facets, which need 734 bytes, but the file has 684");
}

TEST(Stl, ReadsColoursOfBinaryFacets) {
    std::string file = binary_stl(coordinates());
    const auto set_attribute = [&file](std::size_t facet, unsigned value) {
        file[84 + 50 * facet + 48] = static_cast<char>(value & 255);
        file[84 + 50 * facet + 49] = static_cast<char>(value >> 8);
    };
    EXPECT_TRUE(read_mesh(file)->soup.colours.empty());
    set_attribute(1, 1U << 15 | 31U << 10);  // VisCAM: red
    const auto contents = read_mesh(file);
    using Colour = std::array<float, 3>;
    EXPECT_EQ(contents->soup.colours.at(0), (Colour{1, 1, 1}));
    EXPECT_EQ(contents->soup.colours.at(3), (Colour{1, 0, 0}));
    EXPECT_EQ(contents->soup.colours.at(35), (Colour{1, 1, 1}));
    file.replace(0, 10, std::string("COLOR=\xFF\0\xFF\xFF", 10));  // Magics: facets without a mark have a colour
    set_attribute(0, 1U << 15);
    set_attribute(1, 31);
    const auto object = read_mesh(file);
    EXPECT_EQ(object->soup.colours.at(0), (Colour{1, 0, 1}));
    EXPECT_EQ(object->soup.colours.at(3), (Colour{1, 0, 0}));
    EXPECT_EQ(object->soup.colours.at(35), (Colour{0, 0, 0}));
}

TEST(Stl, NamesThePlaceOfAnError) {
    expect_refused("solid\n" + facets(0, 2) + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0\n",
                   "line 20: the file ends instead of a number, in facet 2");
    expect_refused("solid\n" + facets() + "facets\n", "line 86: \"facets\" instead of facet or endsolid");
    expect_refused("solid\n" + facets() + "endsolid\nx", "line 87: \"x\" instead of solid");
    expect_refused("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n",
                   "line 6: \"endloop\" instead of vertex, in facet 0");
    expect_refused("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n",
                   "line 5: the file ends instead of vertex, in facet 0");
    expect_refused("solid a\nendsolid a\n", "it has no triangles");
}

}  // namespace
}  // namespace ccdt::api
