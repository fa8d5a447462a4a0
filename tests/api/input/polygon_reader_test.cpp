// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/polygon_reader.h"

#include <gtest/gtest.h>

#include <string>

#include "api/json/json_document.h"

namespace ccdt::api {
namespace {

const std::string kSquare = "[[0,0],[1,0],[1,1],[0,0]]";

std::string geometry(const std::string& type, const std::string& coordinates) {
    return R"({"type":")" + type + R"(","coordinates":)" + coordinates + '}';
}

std::string collection(const std::string& geometries) {
    return R"({"type":"GeometryCollection","geometries":[)" + geometries + "]}";
}

Result<PolygonInput> read(const std::string& geojson) {
    const auto document = JsonDocument::parse(geojson);
    EXPECT_TRUE(document) << geojson;
    return read_geometry({"the body", "", document->root()});
}

/// Describes what is left out of a geometry.
std::string omitted_of(const std::string& geojson) {
    const auto polygon = read(geojson);
    if (!polygon) return polygon.error().message;
    std::string text;
    for (const auto& [kind, first, count] : polygon->omitted)
        text += std::to_string(count) + ' ' + std::string(kind) + ' ' + first + '\n';
    return text;
}

TEST(PolygonReader, LeavesOutEmptyGeometries) {
    const std::string polygon = geometry("Polygon", '[' + kSquare + ']');
    for (const std::string& empty : {geometry("Polygon", "[]"), geometry("MultiPolygon", "[]"),
                                     geometry("MultiPolygon", "[[]]"), geometry("Polygon", "[[]]")})
        EXPECT_EQ(omitted_of(collection(empty + ',' + polygon + ',' + empty)), "2 empty /geometries/0\n") << empty;
    EXPECT_EQ(omitted_of(collection(polygon + ',' + collection(""))), "");
    EXPECT_EQ(
        omitted_of(R"({"type":"FeatureCollection","features":[{"type":"Feature","geometry":null},)" + polygon + "]}"),
        "1 null /features/0/geometry\n");
}

TEST(PolygonReader, LeavesOutPointsAndLines) {
    EXPECT_EQ(omitted_of(collection(geometry("Point", "[1,2]") + ',' + geometry("LineString", "[[1,2],[2,3]]") + ',' +
                                    geometry("Polygon", '[' + kSquare + ']') + ',' + geometry("Point", "[3,4]"))),
              "2 Point /geometries/0\n1 LineString /geometries/1\n");
}

TEST(PolygonReader, RefusesDocumentsWithoutPolygons) {
    const auto points = read(collection(geometry("Polygon", "[]") + ',' + geometry("MultiPoint", "[[1,2]]")));
    ASSERT_FALSE(points);
    EXPECT_EQ(points.error().code, ErrorCode::Malformed);
    EXPECT_EQ(points.error().field, "/geometries/1");
    EXPECT_NE(points.error().message.find("not a MultiPoint"), std::string::npos) << points.error().message;
    for (const std::string& empty : {geometry("Polygon", "[]"), collection(""), collection(collection("")),
                                     std::string(R"({"type":"Feature","geometry":null})")})
        EXPECT_EQ(read(empty).error().code, ErrorCode::Unusable) << empty;
    EXPECT_EQ(read(geometry("polygon", '[' + kSquare + ']')).error().code, ErrorCode::Malformed);
    EXPECT_EQ(read(collection("null")).error().field, "/geometries/0");
}

TEST(PolygonReader, PointsToPartsBehindEmptyOnes) {
    const auto polygon =
        read(collection(geometry("MultiPolygon", "[[" + kSquare + "],[],[],[" + kSquare + "],[" + kSquare + "]]") +
                        ',' + geometry("MultiPolygon", "[[],[" + kSquare + "]]")));
    ASSERT_TRUE(polygon);
    ASSERT_EQ(polygon->parts.size(), 4U);
    EXPECT_EQ(polygon->pointer_to("/0/0/1"), "/geometries/0/coordinates/0/0/1");
    EXPECT_EQ(polygon->pointer_to("/1/0/1"), "/geometries/0/coordinates/3/0/1");
    EXPECT_EQ(polygon->pointer_to("/2/0"), "/geometries/0/coordinates/4/0");
    EXPECT_EQ(polygon->pointer_to("/3"), "/geometries/1/coordinates/1");
}

}  // namespace
}  // namespace ccdt::api
