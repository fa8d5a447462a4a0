// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/ply.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "tests/api/surface/cube.h"
#include "tests/support/mesh_files.h"

namespace ccdt::api {
namespace {

using test::corners;
using test::expect_cube;
using test::expect_refused;
using test::faces;
using test::kCorners;
using test::kFaces;
using test::read_mesh;

const std::string kVertexElement = "element vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFaceElement = "element face 6\nproperty list uchar int vertex_indices\n";

std::string ply(std::string_view elements, std::string_view data, std::string_view format = "ascii") {
    return "ply\nformat " + std::string(format) + " 1.0\n" + std::string(elements) + "end_header\n" + std::string(data);
}

std::string with_ends(std::string text, std::string_view end) {
    for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + end.size()))
        text.replace(at, 1, end);
    return text;
}

TEST(Ply, ReadsAllVariantsOfText) {
    const std::string data = corners("\n") + faces("4", "\n");
    const std::string files[] = {
        ply(kVertexElement + kFaceElement, data),
        ply("comment face 7\nobj_info x\n" + kVertexElement + kFaceElement, data),
        with_ends(ply(kVertexElement + kFaceElement, data), "\r\n"),
        with_ends(ply(kVertexElement + kFaceElement, data), "\r"),
        ply(kVertexElement + kFaceElement, corners(" ") + faces("4", " ")),
        ply(kVertexElement + kFaceElement, corners("\n\n") + faces("4\n", "\n")),
        ply(kFaceElement + kVertexElement, faces("4", "\n") + corners("\n")),
        ply("element camera 2\nproperty float a\nproperty list int float b\n" + kVertexElement + kFaceElement +
                "element edge 1\nproperty int vertex1\n",
            "1 2 3 4\n5 0\n" + data + "6\n"),
        ply(kVertexElement + "property uchar red\nproperty uchar green\nproperty uchar blue\n" + kFaceElement,
            corners("\n1 2 3\n") + faces("4", "\n")),
        ply(kVertexElement + "property list uchar float weights\n" + kFaceElement,
            corners(" 2 5 6\n") + faces("4", "\n")),
        ply(kVertexElement +
                "element face 6\nproperty uchar red\nproperty list char uint vertex_index\nproperty float q\n",
            corners("\n") + faces("9 4", " .5\n")),
        ply("element vertex 8\nproperty int8 z\nproperty uint16 x\nproperty float64 y\n" + kFaceElement,
            "0 0 0 0 1 0 0 1 1 0 0 1 1 0 0 1 1 0 1 1 1 1 0 1\n" + faces("4", "\n")),
        ply(kVertexElement + "element face 6\nproperty list double float vertex_indices\n",
            corners("\n") + faces("4.0", "\n")),
    };
    for (const std::string& file : files) expect_cube(file);
}

/// Writes numbers of all types, with any order of bytes.
class Writer {
public:
    explicit Writer(bool is_big) : is_big_(is_big) {}

    template <class Number>
    void add(Number number) {
        auto bytes = std::bit_cast<std::array<char, sizeof(Number)>>(number);
        if (is_big_) std::ranges::reverse(bytes);
        text_.append(bytes.data(), bytes.size());
    }
    template <class Position>
    void add_corners() {
        for (const auto& [x, y, z] : kCorners) {
            for (const double ordinate : {x, y, z}) add(static_cast<Position>(ordinate));
        }
    }
    template <class Count, class Index>
    void add_faces() {
        for (const auto& face : kFaces) {
            add(static_cast<Count>(4));
            for (const int corner : face) add(static_cast<Index>(corner));
        }
    }
    const std::string& text() const { return text_; }

private:
    bool is_big_;
    std::string text_;
};

TEST(Ply, ReadsAllTypesOfBinaryNumbers) {
    const auto check = [](std::string_view position, std::string_view count, std::string_view index, auto write) {
        for (const bool is_big : {false, true}) {
            const std::string at(position), list = "property list " + std::string(count) + ' ' + std::string(index);
            const std::string vertex =
                "element vertex 8\nproperty " + at + " x\nproperty " + at + " y\nproperty " + at + " z\n";
            Writer writer(is_big);
            write(writer);
            const std::string file = ply(vertex + "element face 6\n" + list + " vertex_indices\n", writer.text(),
                                         is_big ? "binary_big_endian" : "binary_little_endian");
            expect_cube(file);
            expect_cube(file + "xyz", "bytes after the last element are ignored");
            expect_refused(file.substr(0, file.size() - 1), "face 5 of 6 is incomplete, because the file ends");
        }
    };
    const auto write = []<class Position, class Count, class Index>(Position, Count, Index) {
        return [](Writer& writer) {
            writer.add_corners<Position>();
            writer.add_faces<Count, Index>();
        };
    };
    check("float", "uchar", "int", write(float{}, std::uint8_t{}, std::int32_t{}));
    check("double", "char", "uint", write(double{}, std::int8_t{}, std::uint32_t{}));
    check("int16", "ushort", "short", write(std::int16_t{}, std::uint16_t{}, std::int16_t{}));
    check("uint16", "int16", "ushort", write(std::uint16_t{}, std::int16_t{}, std::uint16_t{}));
    check("uint8", "int32", "uint8", write(std::uint8_t{}, std::int32_t{}, std::uint8_t{}));
    check("int8", "float64", "int8", write(std::int8_t{}, double{}, std::int8_t{}));
    check("int32", "float", "float", write(std::int32_t{}, float{}, float{}));
}

TEST(Ply, ReadsBinaryDataThatBeginsLikeTheEndOfALine) {
    for (const std::string end : {"\n", "\r\n"}) {
        std::string file = with_ends(
            ply("element first 1\nproperty uchar a\n" + kVertexElement + kFaceElement, "", "binary_little_endian"),
            end);
        Writer writer(false);
        writer.add('\n');
        writer.add_corners<float>();
        writer.add_faces<std::uint8_t, std::int32_t>();
        expect_cube(file + writer.text());
    }
}

TEST(Ply, ReadsStripsOfTriangles) {
    // The sides of a cube without the top and the bottom, twice; -1 ends a strip, and repeated corners connect two.
    const std::string element = "element tristrips 1\nproperty list int int vertex_indices\n";
    const auto contents =
        read_mesh(ply(kVertexElement + element, corners("\n") + "22 0 4 1 5 2 6 3 7 0 4 -1 0 4 1 5 5 2 2 6 3 7 7\n"));
    ASSERT_TRUE(contents) << contents.error().message;
    using Triangle = std::array<std::uint32_t, 3>;
    ASSERT_EQ(contents->soup.triangles.size(), 8U + 4U);
    EXPECT_EQ(contents->soup.triangles[0], (Triangle{0, 4, 1}));
    EXPECT_EQ(contents->soup.triangles[1], (Triangle{1, 4, 5}));
    for (const auto& [a, b, c] : contents->soup.triangles) {
        const auto& v = contents->soup.vertices;
        const Point3 middle = 1.0 / 3 * (v[a] + v[b] + v[c]) - Point3(.5, .5, .5);
        EXPECT_LT(dot(middle, cross(v[b] - v[a], v[c] - v[a])), 0);  // the strip runs clockwise
    }
}

TEST(Ply, ReadsColoursByTheirTypes) {
    struct Case {
        const char *type, *values;
    };
    for (const auto& [type, values] : {Case{"uchar", "255 0 51"},
                                       {"ushort", "65535 0 13107"},
                                       {"float", "1 0 0.2"},
                                       {"double", "255 0 51"},
                                       {"int", "255 0 51"}}) {
        const std::string at(type);
        const auto contents = read_mesh(ply(kVertexElement + "property " + at + " red\nproperty " + at +
                                                " green\nproperty " + at + " blue\n" + kFaceElement,
                                            corners(' ' + std::string(values) + '\n') + faces("4", "\n")));
        ASSERT_TRUE(contents) << contents.error().message;
        const auto& colour = contents->soup.colours.at(7);
        EXPECT_EQ(colour[0], 1) << type;
        EXPECT_EQ(colour[1], 0) << type;
        EXPECT_NEAR(colour[2], 0.0331, 1e-4) << type;
    }
    const auto texture = read_mesh(ply(kVertexElement + "property float s\nproperty float t\n" + kFaceElement,
                                       corners(" .5 .25\n") + faces("4", "\n")));
    EXPECT_EQ(texture->soup.texture.at(7), (std::array<float, 2>{0.5F, 0.25F}));
}

TEST(Ply, WarnsOfWhatItIgnores) {
    expect_cube(ply("Created by a program\n" + kVertexElement + kFaceElement, corners("\n") + faces("4", "\n")),
                "unknown lines of the header are ignored: 1; the first is line 3");
    const std::string eight = "element face 8\nproperty list uchar int vertex_indices\n";
    expect_cube(ply(kVertexElement + eight, corners("\n") + faces("4", "\n") + "1 0\n2 0 1\n"),
                "fewer than three corners are ignored: 2; the first is face 6 (line 24)");
    expect_cube(
        ply(kVertexElement + kFaceElement + "property list uchar float texcoord\n", corners("\n") + faces("4", " 0\n")),
        "texture coordinates of faces are ignored");
}

TEST(Ply, NamesThePlaceOfAnError) {
    const std::string elements = kVertexElement + kFaceElement, data = corners("\n") + faces("4", "\n");
    expect_refused(ply(elements, data + "7\n"), "line 24: there is \"7\" after the last element");
    expect_refused(ply(elements, corners(" 7\n") + faces("4", "\n")), "after the last element");
    expect_refused(ply(elements, data.substr(0, data.size() - 3)), "face 5 of 6 is incomplete, because the file ends");
    expect_refused(ply(elements, "0 0 x\n"), "vertex 1 of 8 is incomplete");
    expect_refused(ply(elements, corners("\n") + faces("-4", "\n")), "face 0 of 6 has a list of invalid size");
    expect_refused(ply(elements, corners("\n") + faces("4", "\n", 1)), "face 1 (line 19) refers to vertex 8");
    expect_refused(ply(elements, corners("\n") + faces("4", "\n", -1)), "face 0 of 6 refers to an invalid vertex");
    expect_refused(ply(kFaceElement, faces("4", "\n")), "refers to vertex 7, but there are only 0 vertices");
    expect_refused(ply("element vertex 1\nproperty float x\n", "0\n"), "lack one of the properties x, y and z");
    expect_refused(ply(elements, data, "binary_pdp_endian"), "line 2: the format \"binary_pdp_endian\"");
    expect_refused("ply\n" + elements + "end_header\n" + data, "line 8: the header states no format");
    expect_refused(ply("element vertex 8\nproperty half x\n", ""), "line 4: \"half\" is not a type");
    expect_refused(ply("property float x\n", ""), "line 3: the property has no element");
    expect_refused(ply("element vertex 8\nelement vertex 8\n", ""), "line 4: there is another element \"vertex\"");
}

}  // namespace
}  // namespace ccdt::api
