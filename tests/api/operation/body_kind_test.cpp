// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/operation/body_kind.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ccdt::api {
namespace {

using namespace std::string_literals;

std::string padded(std::string bytes, std::size_t size) {
    bytes.resize(size, '\0');
    return bytes;
}

/// Returns a binary body without line ends and zeros.
std::string stripped(std::string_view start) {
    std::string body(40, '\x01');
    std::ranges::copy(start, body.begin());
    return body;
}

TEST(BodyKind, NamesTheKindOfAFile) {
    const std::vector<std::pair<std::string, std::string>> kinds = {
        {"", "empty"},
        {"\xEF\xBB\xBF \r\n", "empty"},
        {"\x89PNG\r\n\x1a\n", "a picture (PNG)"},
        {"\xff\xd8\xff\xe0", "a picture (JPEG)"},
        {"RIFF....WEBPVP8 ", "a picture (WebP)"},
        {"\0\0\0\x0c"
         "ftypheic"s,
         "a picture (HEIC)"},
        {"....ftypmif3avif", "a HEIF or AVIF with minimized properties (mif3)"},
        {"....ftypmp42", "a video"},
        {"solid cube\nfacet", "a mesh (STL)"},
        {"v 0 0 0\n", "a mesh (OBJ)"},
        {"SOLID cube\nFACET", "a mesh (STL)"},
        {"\x93NUMPY\x01\x00", "a NumPy array"},
        {"%PDF-1.7", "PDF"},
        {"\x1f\x8b\x08", "gzip"},
        {"SQLite format 3\0"s, "an SQLite database"},
        {padded("SQLite format 3", 68) + "GPKG", "a GeoPackage"},
        {stripped("\x89PNG\x1a"),
         "a damaged PNG without its line ends and zeros, which curl -d removes from a file (use "
         "--data-binary)"},
        {stripped("\xff\xd8\xff\xe0"),
         "a picture (JPEG) without its line ends and zeros, which curl -d removes from a file (use --data-binary)"},
        {"fgb\x03"
         "fgb\0"s,
         "FlatGeobuf"},
        {"PAR1", "Parquet, such as GeoParquet"},
        {padded("\0\0\x27\x0a"s, 100),
         "a .shp or .shx file, which is read in a zip archive with the other files of the shapefile"},
        {padded("\x03\x7b\x05\x1f\x02\0\0\0\x41\0\x10"s, 80),
         "a .dbf file, which is read in a zip archive with the other files of the shapefile"},
        {"\x01\x03\0\0\0\x01\0\0\0"s, "well-known binary (WKB)"},
        {"\0\0\0\0\x06\0\0\0\x01"s, "well-known binary (WKB)"},
        {"\x01\x06\0\0\x20\xe6\x10"s, "well-known binary (WKB)"},
        {"0103000000010000000500", "well-known binary (WKB)"},
        {"MULTIPOLYGON (((0 0, 1 0)))", "well-known text (WKT)"},
        {"Polygon((0 0, 1 0))", "well-known text (WKT)"},
        {"SRID=4326;POINT(0 0)", "well-known text (WKT)"},
        {"<?xml version=\"1.0\"?>\n<kml xmlns=\"\">", "KML"},
        {"\xEF\xBB\xBF<?xml version=\"1.0\"?><wfs:FeatureCollection>", "GML"},
        {"<!DOCTYPE html><html><svg>", "HTML"},
        {"<?xml version=\"1.0\"?><!-- --><svg>", "SVG"},
        {"<?xml version=\"1.0\"?><other/>", "XML"},
        {"x,y\n1,2\n", "CSV"},
        {"lon;lat;n\r\n1;2;3", "CSV"},
        {"\xff\xfe{\0\"\0"s, "text in UTF-16, not in UTF-8"},
        {"{\0\"\0a\0"s, "text in UTF-16, not in UTF-8"},
        {"\0{\0\"\0a"s, "text in UTF-16, not in UTF-8"},
        {"\xff\xfe\0\0{\0\0\0"s, "text in UTF-32, not in UTF-8"},
        {"Dear Sir,\nplease", "text"},
        {"  0\nSECTION\n", "DXF"},
        {"AC1032\0"s, "DWG"},
        {"# Blender MTL\nnewmtl a\n", "text"},
        {"newmtl a\nKd 1 1 1\n", "the materials of an OBJ (MTL), without its mesh"},
        {"# vtk DataFile Version 3.0\n", "VTK"},
        {"$MeshFormat\n4.1 0 8\n", "a mesh of Gmsh"},
        {"\0\0\0\x0d\x0a\x09OSMHeader"s, "a file of OpenStreetMap"},
        {"{\"sites\":1", "JSON"},
        {"\x02\xf0\x0f", "binary data of an unknown kind"},
    };
    for (const auto& [bytes, kind] : kinds) EXPECT_EQ(kind_of_body(bytes), kind) << bytes.substr(0, 30);
}

TEST(BodyKind, IsPartOfErrors) {
    const auto message = [](const std::string& body) {
        const auto document = parse_sample_document(body);
        return document ? std::string() : document.error().message;
    };
    EXPECT_EQ(message("{}"), "");
    EXPECT_EQ(message("{\"sites\":1"), "the body is not valid JSON: error at byte 11: the text ends");
    EXPECT_NE(message("PAR1").find("the body seems to be Parquet"), std::string::npos);
    EXPECT_NE(message("PAR1").find("accepted are options in JSON, a map"), std::string::npos);
    EXPECT_EQ(message("\n").find("the body is empty; accepted are"), 0U);
    EXPECT_NE(message(R"({"asset":{"version":"2.0"}})").find("a glTF without meshes"), std::string::npos);
    EXPECT_NE(message(R"([{"type":"Feature"}])").find("a list of GeoJSON objects"), std::string::npos);
    EXPECT_NE(message(R"({"rings":[[[0,0],[1,0],[1,1]]]})").find("JSON of Esri"), std::string::npos);
    EXPECT_NE(message(R"({"generator":"Overpass API","elements":[]})").find("OpenStreetMap"), std::string::npos);
    EXPECT_EQ(parse_sample_document("PAR1").error().code, ErrorCode::Unsupported);
    EXPECT_EQ(parse_sample_document("nul").error().code, ErrorCode::Malformed);
}

}  // namespace
}  // namespace ccdt::api
