// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/topology_reader.h"

#include <gtest/gtest.h>

#include <string>

namespace ccdt::api {
namespace {

/// Two rectangles that share an edge. The second one has a hole, and belongs to a MultiPolygon with a separate
/// triangle.
const std::string kArcs = R"([[[1,0],[1,1]],[[1,1],[0,1],[0,0],[1,0]],[[1,0],[4,0],[4,1],[1,1]],)"
                          R"([[2,0.25],[2,0.75],[3,0.5],[2,0.25]],[[9,9],[10,9],[9,10],[9,9]]])";
const std::string kTwo = R"({"type":"GeometryCollection","geometries":[)"
                         R"({"type":"Polygon","arcs":[[0,1]],"id":"w","properties":{"a":1}},{"type":null},)"
                         R"({"type":"MultiPolygon","arcs":[[[-1,2],[3]],[[4]]]}]})";

std::string topology(const std::string& objects, const std::string& arcs = kArcs, const std::string& more = "") {
    return R"({"type":"Topology",)" + more + R"("objects":{)" + objects + R"(},"arcs":)" + arcs + '}';
}

Result<PolygonInput> read(const std::string& text, const std::optional<std::string>& name = {}) {
    const auto document = JsonDocument::parse(text);
    EXPECT_TRUE(document) << document.error().message;
    const Input input{"/geometry", "/geometry", document->root()};
    EXPECT_TRUE(is_topology(document->root()));
    return find_object(input, name).and_then([&](const Input& object) { return read_topology(input, object); });
}

Error error_of(const std::string& text, const std::optional<std::string>& name = {}) {
    const auto polygon = read(text, name);
    EXPECT_FALSE(polygon);
    return polygon ? Error() : polygon.error();
}

TEST(Topology, JoinsArcsToRings) {
    const auto polygon = read(topology("\"two\":" + kTwo));
    ASSERT_TRUE(polygon) << polygon.error().message;
    ASSERT_EQ(polygon->parts.size(), 3U);
    EXPECT_EQ(polygon->parts[0].outer, (Ring{{1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}}));
    EXPECT_EQ(polygon->parts[1].outer, (Ring{{1, 1}, {1, 0}, {4, 0}, {4, 1}, {1, 1}}));
    EXPECT_EQ(polygon->parts[1].holes, (std::vector<Ring>{{{2, 0.25}, {2, 0.75}, {3, 0.5}, {2, 0.25}}}));
    EXPECT_EQ(polygon->features, (std::vector<std::size_t>{0, 1, 1}));
}

TEST(Topology, KeepsBothEndsOfArcsThatDoNotMeet) {
    const std::string arcs = "[[[0,0],[9,0]],[[0,9],[9,9]]]";
    const auto polygon = read(topology(R"("o":{"type":"Polygon","arcs":[[0,-2]]})", arcs));
    ASSERT_TRUE(polygon) << polygon.error().message;
    EXPECT_EQ(polygon->parts[0].outer, (Ring{{0, 0}, {9, 0}, {9, 9}, {0, 9}}));
}

TEST(Topology, DecodesQuantizedArcs) {
    const auto polygon = read(topology(R"("one":{"type":"Polygon","arcs":[[0]]})", "[[[10,20],[5,0],[0,-5,77],[-5,5]]]",
                                       R"("transform":{"scale":[0.5,2],"translate":[100,-7]},)"));
    ASSERT_TRUE(polygon) << polygon.error().message;
    EXPECT_EQ(polygon->parts[0].outer, (Ring{{105, 33}, {107.5, 33}, {107.5, 23}, {105, 33}}));
    EXPECT_TRUE(polygon->features.empty());
}

TEST(Topology, ReadsTheNamedObject) {
    const std::string objects = "\"two\":" + kTwo + R"(,"a/b":{"type":"Polygon","arcs":[[4]]})";
    EXPECT_EQ(read(topology(objects), "a/b")->parts.size(), 1U);
    const Error several = error_of(topology(objects));
    EXPECT_EQ(several.field, "/geometry/objects");
    EXPECT_EQ(several.message,
              "/geometry/objects has several members: choose one of them with the option object (two, a/b)");
    EXPECT_EQ(error_of(topology(objects), "three").field, "/geometry/objects");
    EXPECT_EQ(error_of(topology("")).field, "/geometry/objects");
}

TEST(Topology, LocatesRings) {
    const auto polygon = read(topology("\"two\":" + kTwo));
    EXPECT_EQ(polygon->pointer_to("/0/0/3"), "/geometry/objects/two/geometries/0/arcs/0");
    EXPECT_EQ(polygon->pointer_to("/1/1/2"), "/geometry/objects/two/geometries/2/arcs/0/1");
    EXPECT_EQ(polygon->pointer_to("/2"), "/geometry/objects/two/geometries/2/arcs/1");
}

TEST(Topology, LocatesErrorsByJsonPointer) {
    const auto with = [](const std::string& object, const std::string& arcs = kArcs, const std::string& more = "") {
        return error_of(topology("\"o\":" + object, arcs, more));
    };
    const std::string polygon = R"({"type":"Polygon","arcs":[[0]]})";
    EXPECT_EQ(with(R"({"type":"Polygon","arcs":[[0,5]]})").field, "/geometry/objects/o/arcs/0/1");
    EXPECT_EQ(with(R"({"type":"Polygon","arcs":[[0,-6]]})").field, "/geometry/objects/o/arcs/0/1");
    EXPECT_EQ(with(R"({"type":"Polygon","arcs":[[0.5]]})").field, "/geometry/objects/o/arcs/0/0");
    EXPECT_EQ(with(R"({"type":"Polygon","arcs":[["0"]]})").field, "/geometry/objects/o/arcs/0/0");
    EXPECT_EQ(with(R"({"type":"Polygon","arcs":[0]})").field, "/geometry/objects/o/arcs/0");
    EXPECT_EQ(with(R"({"type":"Polygon"})").field, "/geometry/objects/o/arcs");
    EXPECT_EQ(with(R"({"type":"LineString","arcs":[0]})").code, ErrorCode::Malformed);
    EXPECT_EQ(with("7").field, "/geometry/objects/o");
    EXPECT_EQ(with(polygon, "{}").field, "/geometry/arcs");
    EXPECT_EQ(with(polygon, "[7]").field, "/geometry/arcs/0");
    EXPECT_EQ(with(polygon, "[[[1,2],[3]]]").field, "/geometry/arcs/0/1");
    EXPECT_EQ(with(polygon, kArcs, R"("transform":7,)").field, "/geometry/transform");
    EXPECT_EQ(with(polygon, kArcs, R"("transform":{"scale":[1,1]},)").field, "/geometry/transform/translate");
    EXPECT_EQ(with(polygon, kArcs, R"("transform":{"scale":[1]},)").field, "/geometry/transform/scale");
}

TEST(Topology, RefusesObjectsWithoutPolygons) {
    EXPECT_EQ(error_of(topology(R"("o":{"type":"GeometryCollection","geometries":[]})")).code, ErrorCode::Unusable);
    EXPECT_EQ(error_of(topology(R"("o":{"type":null})")).code, ErrorCode::Unusable);
    EXPECT_EQ(error_of(topology(R"("o":{"type":"Polygon","arcs":[]})")).code, ErrorCode::Unusable);
}

TEST(Topology, LimitsTheCornersOfRepeatedArcs) {
    std::string arc = "[[[0,0]", ring = "[0";
    for (int i = 1; i < 2'000; ++i) arc += ",[" + std::to_string(i) + ",1]";
    for (int i = 1; i < 2'000; ++i) ring += ",0";
    const Error error = error_of(topology(R"("o":{"type":"Polygon","arcs":[)" + ring + "]]}", arc + "]]"));
    EXPECT_EQ(error.code, ErrorCode::LimitExceeded);
    EXPECT_EQ(error.field, "/geometry/objects/o/arcs/0");
}

}  // namespace
}  // namespace ccdt::api
