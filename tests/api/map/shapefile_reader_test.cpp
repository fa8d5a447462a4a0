// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/shapefile_reader.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "api/input/polygon_reader.h"
#include "tests/api/files.h"
#include "tests/support/shapefiles.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::ordered_json;
using Files = std::vector<std::pair<std::string, std::string>>;

constexpr std::size_t kMax = std::size_t{1} << 20;

/// Returns a closed clockwise square with this side around a point.
Ring square(double side, Point at = {}) {
    const double a = side / 2;
    return {
        {at.x - a, at.y - a}, {at.x - a, at.y + a}, {at.x + a, at.y + a}, {at.x + a, at.y - a}, {at.x - a, at.y - a}};
}

Ring hole(double side, Point at = {}) {
    Ring ring = square(side, at);
    return {ring.rbegin(), ring.rend()};
}

Result<std::string> read(const std::string& archive, std::string_view object = {}, std::size_t most = kMax) {
    std::string text;
    const auto take = [&text](std::string_view piece) {
        text += piece;
        return true;
    };
    return read_shapefile(archive, {object, most}, take).map([&] { return text; });
}

Json features_of(const std::string& archive, std::string_view object = {}, std::size_t most = kMax) {
    const auto text = read(archive, object, most);
    EXPECT_TRUE(text) << text.error().message;
    return text ? Json::parse(*text)["features"] : Json();
}

Error error_of(const std::string& archive, std::string_view object = {}, std::size_t most = kMax) {
    const auto text = read(archive, object, most);
    EXPECT_FALSE(text);
    return text ? Error() : text.error();
}

std::string message_of(const Files& files) {
    const Error error = error_of(zip_of(files));
    EXPECT_EQ(error.code, ErrorCode::Unusable);
    return error.message;
}

const std::string kOne = shp_of({{square(2)}});

/// Returns the property of the only record of a table with one field.
Json property(TableField field, std::string text, int language = 0, const std::string& cpg = "") {
    Files files = {{"a.shp", kOne}, {"a.dbf", dbf_of({std::move(field)}, {{std::move(text)}}, language)}};
    if (!cpg.empty()) files.emplace_back("a.cpg", cpg);
    return features_of(zip_of(files))[0]["properties"].front();
}

TEST(Shapefile, ReadsFilesWrittenByGdal) {
    const Json features = features_of(polygon_file("two-countries.zip"));
    ASSERT_EQ(features.size(), 3U);
    EXPECT_EQ(features[0]["properties"].dump(), R"({"name":"Italia","people":59.07,"since":"1861-03-17","dense":1})");
    EXPECT_EQ(features[1]["properties"]["name"],
              "S\xC3\xBC"
              "dafrika");
    EXPECT_TRUE(features[1]["properties"]["dense"].is_null());
    EXPECT_TRUE(features[2]["geometry"].is_null());
    for (const auto& [feature, name] : {std::pair(0, "Italy-110m.geojson"), {1, "South-Africa-50m.geojson"}}) {
        const Json original = Json::parse(polygon_file(name));
        const Json& given = original.contains("geometry") ? original["geometry"] : original;
        const Json& shape = features[static_cast<std::size_t>(feature)]["geometry"];
        ASSERT_EQ(shape["coordinates"].size(), given["coordinates"].size()) << name;
        // GDAL may begin a ring at any of its corners.
        for (std::size_t part = 0; part < given["coordinates"].size(); ++part) {
            ASSERT_EQ(shape["coordinates"][part].size(), given["coordinates"][part].size());
            for (std::size_t ring = 0; ring < given["coordinates"][part].size(); ++ring) {
                auto corners = shape["coordinates"][part][ring].get<std::vector<Json>>();
                auto wanted = given["coordinates"][part][ring].get<std::vector<Json>>();
                EXPECT_TRUE(std::ranges::is_permutation(corners, wanted)) << name << ' ' << part << ' ' << ring;
            }
        }
    }
}

TEST(Shapefile, GroupsHolesByTheRingsAroundThem) {
    // A square with a hole, in which there is a square with a hole; and another square with a hole.
    const Json one = features_of(zip_of(
        {{"a.shp", shp_of({{hole(4), square(10), square(1, {20, 0}), square(2), hole(1), hole(0.5, {20, 0})}})}}));
    EXPECT_TRUE(one[0]["properties"].is_null());
    const Json& parts = one[0]["geometry"]["coordinates"];
    EXPECT_EQ(one[0]["geometry"]["type"], "MultiPolygon");
    ASSERT_EQ(parts.size(), 3U);
    EXPECT_EQ(parts[0].size(), 2U);
    EXPECT_EQ(parts[0][0][0], Json::parse("[-5.0,-5.0]"));
    EXPECT_EQ(parts[0][1].back(), Json::parse("[-2.0,-2.0]"));
    EXPECT_EQ(parts[1].size(), 2U);
    EXPECT_EQ(parts[1][1][0], Json::parse("[19.75,-0.25]"));
    EXPECT_EQ(parts[2][1].back(), Json::parse("[-0.5,-0.5]"));
}

TEST(Shapefile, GroupsManyHoles) {
    constexpr int kSide = 100;
    std::vector<Ring> rings;
    for (int i = 0; i < kSide * kSide; ++i) {
        const Point at{static_cast<double>(i % kSide), static_cast<double>(i / kSide)};
        rings.push_back(hole(0.2, at));
        rings.push_back(square(0.5, at));
    }
    const std::vector<Ring> huge = {{{-1e308, -1e308}, {-1e308, 1e308}, {1e308, 1e308}, {1e308, -1e308}}, hole(1)};
    const Json shapes = features_of(zip_of({{"a.shp", shp_of({rings, huge})}}), {}, std::size_t{16} << 20);
    const Json& parts = shapes[0]["geometry"]["coordinates"];
    ASSERT_EQ(parts.size(), rings.size() / 2);
    for (const Json& part : parts) {
        ASSERT_EQ(part.size(), 2U);
        EXPECT_NEAR(part[1][0][0].get<double>(), part[0][0][0].get<double>() + 0.15, 1e-9);
        EXPECT_NEAR(part[1][0][1].get<double>(), part[0][0][1].get<double>() + 0.15, 1e-9);
    }
    EXPECT_EQ(shapes[1]["geometry"]["coordinates"].size(), 2U);
}

TEST(Shapefile, TakesAHoleOutsideOfAllRingsForAPart) {
    const Json shapes = features_of(zip_of({{"a.shp", shp_of({{hole(4)}, {square(1), hole(1, {9, 9})}})}}));
    EXPECT_EQ(shapes[0]["geometry"]["type"], "Polygon");
    EXPECT_EQ(shapes[1]["geometry"]["coordinates"].size(), 2U);
}

/// Returns the numbers of rings of the parts of a shape.
std::vector<std::size_t> rings_of(const std::vector<Ring>& rings) {
    const Json shapes = features_of(zip_of({{"a.shp", shp_of({rings})}}));
    const Json& geometry = shapes[0]["geometry"];
    if (geometry["type"] == "Polygon") return {geometry["coordinates"].size()};
    std::vector<std::size_t> counts;
    for (const Json& part : geometry["coordinates"]) counts.push_back(part.size());
    return counts;
}

TEST(Shapefile, TakesARingInANotchForAPart) {
    const Ring notched = {{0, 0}, {0, 9}, {3, 9}, {3, 3}, {9, 3}, {9, 0}, {0, 0}};
    EXPECT_EQ(rings_of({notched, hole(2, {6, 6})}), (std::vector<std::size_t>{1, 1}));
    EXPECT_EQ(rings_of({notched, hole(2, {1.5, 1.5})}), (std::vector<std::size_t>{2}));
    // A ring that fills the notch, or a part of it, and touches the outer ring from outside or inside.
    EXPECT_EQ(rings_of({notched, {{3, 3}, {9, 3}, {3, 9}, {3, 3}}}), (std::vector<std::size_t>{1, 1}));
    EXPECT_EQ(rings_of({notched, {{3, 3}, {9, 3}, {9, 9}, {3, 9}, {3, 3}}}), (std::vector<std::size_t>{1, 1}));
    EXPECT_EQ(rings_of({notched, {{0, 0}, {9, 0}, {3, 3}, {0, 9}, {0, 0}}}), (std::vector<std::size_t>{2}));
    EXPECT_EQ(rings_of({notched, {{0.1, 0.1}, {0.7, 0.1}, {0.1, 0.7}, {0.1, 0.1}}}), (std::vector<std::size_t>{2}));
}

TEST(Shapefile, GroupsNestedRings) {
    std::vector<Ring> rings;  // island, lake, island in the lake, and so on
    for (int size = 20; size > 0; size -= 4) {
        rings.push_back(square(size));
        rings.push_back(hole(size - 2));
    }
    EXPECT_EQ(rings_of(rings), (std::vector<std::size_t>(5, 2)));
    EXPECT_EQ(rings_of({rings.rbegin(), rings.rend()}), (std::vector<std::size_t>(5, 2)));
    // An island that touches all sides of its lake; a lake as large as its island.
    const Ring diamond = {{-1, 0}, {0, 1}, {1, 0}, {0, -1}, {-1, 0}};
    EXPECT_EQ(rings_of({square(4), hole(2), diamond}), (std::vector<std::size_t>{2, 1}));
    EXPECT_EQ(rings_of({square(2), hole(2)}), (std::vector<std::size_t>{2}));
    // Very large and very small coordinates.
    for (const double scale : {1e308, 1e-308, 1e-320}) {
        std::vector<Ring> scaled = {square(1), hole(0.5), square(0.25), {{2, 0}, {3, 0}, {3, 1}, {2, 0}}};
        for (Ring& ring : scaled) {
            for (Point& p : ring) p = scale / 4 * p;
        }
        EXPECT_EQ(rings_of(scaled), (std::vector<std::size_t>{2, 1, 1})) << scale;
    }
}

TEST(Shapefile, ReadsPolygonsWithHeightsAndMeasures) {
    const Json flat = features_of(zip_of({{"a.shp", kOne}}));
    for (const int type : {15, 25}) EXPECT_EQ(features_of(zip_of({{"a.shp", shp_of({{square(2)}}, type)}})), flat);
}

TEST(Shapefile, KeepsEveryBitOfCoordinates) {
    const Ring ring = {{0.1, 1.0 / 3}, {-1e-308, 1e308}, {5e-324, 0.30000000000000004}};
    const Json shape = features_of(zip_of({{"a.shp", shp_of({{ring}})}}))[0]["geometry"]["coordinates"][0];
    for (std::size_t i = 0; i < ring.size(); ++i) {
        EXPECT_EQ(shape[i][0].get<double>(), ring[i].x);
        EXPECT_EQ(shape[i][1].get<double>(), ring[i].y);
    }
}

TEST(Shapefile, ReadsValuesByTheirTypes) {
    EXPECT_EQ(property({"n", 'N', 8}, "   -12.5").dump(), "-12.5");
    EXPECT_EQ(property({"n", 'F', 24}, "1.5000000000e+003"), 1500);
    EXPECT_TRUE(property({"n", 'N', 5}, "*****").is_null());
    EXPECT_TRUE(property({"n", 'N', 5}, "     ").is_null());
    EXPECT_EQ(property({"n", 'N', 5}, "1,5"), "1,5");
    EXPECT_EQ(property({"n", 'N', 3}, "nan"), "nan");
    EXPECT_EQ(property({"d", 'D', 8}, "20240229"), "2024-02-29");
    EXPECT_EQ(property({"l", 'L', 1}, "T"), true);
    EXPECT_EQ(property({"l", 'L', 1}, "n"), false);
    EXPECT_TRUE(property({"l", 'L', 1}, "?").is_null());
    EXPECT_TRUE(property({"l", 'L', 1}, std::string(1, '\0')).is_null());
    EXPECT_TRUE(property({"d", 'D', 8}, std::string(8, '\0')).is_null());
    EXPECT_EQ(property({"c", 'C', 9}, "a \"b\" \\"), "a \"b\" \\");
    EXPECT_TRUE(property({"c", 'C', 9}, "").is_null());
}

TEST(Shapefile, ReadsTextsByTheirCodePage) {
    const std::string sharp =
        "stra\xDF"
        "e";
    const std::string utf8 =
        "stra\xC3\x9F"
        "e";
    EXPECT_EQ(property({"c", 'C', 9}, utf8, 0, "UTF-8\r\n"), utf8);
    EXPECT_EQ(property({"c", 'C', 9}, sharp, 0, "ISO-8859-1"), utf8);
    EXPECT_EQ(property({"c", 'C', 9}, sharp, 0, "ANSI 1252"), utf8);
    EXPECT_EQ(property({"c", 'C', 9}, sharp, 87), utf8);
    EXPECT_EQ(property({"c", 'C', 9}, "\x80 5", 3), "\xE2\x82\xAC 5");
    EXPECT_EQ(property({"c", 'C', 9}, utf8, 87, "UTF-8"), utf8);  // the .cpg file counts
    // Text truncated within a character.
    EXPECT_EQ(property({"c", 'C', 5}, "stra\xC3", 0, "UTF-8"), "stra\xEF\xBF\xBD");
    EXPECT_EQ(property({"c", 'C', 5}, "a\x82", 0, "CP932"), "a\xEF\xBF\xBD");
    EXPECT_EQ(property({"c", 'C', 5}, "a\x81z", 0, "1252"), "a\xEF\xBF\xBDz");
}

TEST(Shapefile, ReadsTextsOfManyLanguages) {
    struct Case {
        std::string text, cpg;
        int language;
        std::string utf8;
    };
    const std::vector<Case> cases = {
        {"\x93\x8C\x8B\x9E", "SJIS", 19, "\u6771\u4EAC"},
        {"\x93\x8C\x8B\x9E", "Shift_JIS", 123, "\u6771\u4EAC"},
        {"\xB1\xB1\xBE\xA9", "GBK", 77, "\u5317\u4EAC"},
        {"\xB1\xB1\xBE\xA9", "GB2312", 122, "\u5317\u4EAC"},
        {"\xA5\x78\xA5\x5F", "BIG5", 79, "\u53F0\u5317"},
        {"\xA5\x78\xA5\x5F", "Big5-HKSCS", 79, "\u53F0\u5317"},
        {"\xBC\xAD\xBF\xEF", "949", 78, "\uC11C\uC6B8"},
        {"\xBC\xAD\xBF\xEF", "KS_C_5601-1987", 78, "\uC11C\uC6B8"},
        {"\xA3\xF3"
         "d\x9F",
         "1250", 200, "\u0141\u00F3d\u017A"},
        {"\xCC\xEE\xF1", "CP1251", 201, "\u041C\u043E\u0441"},
        {"K\x94ln", "IBM850", 2, "K\u00F6ln"},
        {"\x8C\xAE\xE1", "866", 38, "\u041C\u043E\u0441"},
        {"\xD0stanbul", "ANSI 1254", 202, "\u011Estanbul"},
        {"\xA3\xF3", "ISO 8859-2", 200, "\u0141\u00F3"},
        {"Z\x9Frich", "MACINTOSH", 4, "Z\u00FCrich"},
    };
    for (const auto& [text, cpg, language, utf8] : cases) {
        EXPECT_EQ(property({"c", 'C', 9}, text, 0, cpg), utf8) << cpg;
        EXPECT_EQ(property({"c", 'C', 9}, text, language), utf8) << language;
    }
}

/// Returns the collection that is made from a shapefile with one record.
Json collection_of(const std::vector<TableField>& fields, const std::vector<std::string>& values,
                   const std::string& cpg = "", const std::string& prj = "") {
    Files files = {{"a.shp", kOne}, {"a.dbf", dbf_of(fields, {values})}};
    if (!cpg.empty()) files.emplace_back("a.cpg", cpg);
    if (!prj.empty()) files.emplace_back("a.PRJ", prj);
    const auto text = read(zip_of(files));
    return text ? Json::parse(*text) : Json(text.error().message);
}

TEST(Shapefile, LeavesOutFieldsThatCannotBeRead) {
    const Json unnamed = collection_of({{"name", 'C', 9}, {"n", 'N', 4}, {"plain", 'C', 5}}, {"stra\xDF", "7", "a"});
    EXPECT_EQ(unnamed["features"][0]["properties"].dump(), R"({"n":7,"plain":"a"})");
    EXPECT_EQ(unnamed["unreadable"].size(), 1U);
    EXPECT_NE(unnamed["unreadable"]["name"].get<std::string>().find("names no encoding"), std::string::npos);
    const Json unknown = collection_of({{"n\xE4me", 'C', 9}, {"n\xE5me", 'N', 1}}, {"a", "1"}, "EBCDIC-37");
    EXPECT_EQ(unknown["features"][0]["properties"], Json::object());
    EXPECT_NE(unknown["unreadable"].front().get<std::string>().find("EBCDIC-37, is not supported"), std::string::npos);
    const Json twice =
        collection_of({{"n", 'N', 1}, {"n", 'C', 1}, {"n", 'C', 1}, {"m", 'N', 1}}, {"1", "2", "3", "4"});
    EXPECT_EQ(twice["features"][0]["properties"].dump(), R"({"m":4})");
    EXPECT_NE(twice["unreadable"]["n"].get<std::string>().find("two fields"), std::string::npos);
    const Json binary = collection_of({{"i", 'I', 4}, {"n", 'N', 1}}, {std::string("\5\0\0\0", 4), "1"});
    EXPECT_EQ(binary["features"][0]["properties"].dump(), R"({"n":1})");
    EXPECT_NE(binary["unreadable"]["i"].get<std::string>().find("fields of the type I are not"), std::string::npos);
    EXPECT_FALSE(collection_of({{"name", 'C', 9}}, {"plain"}).contains("unreadable"));
}

TEST(Shapefile, KeepsAllDigitsOfIntegers) {
    EXPECT_EQ(collection_of({{"id", 'N', 19}}, {"9007199254740993"})["features"][0]["properties"].dump(),
              R"({"id":9007199254740993})");
    EXPECT_EQ(property({"n", 'N', 8}, "-0042"), -42);
    EXPECT_EQ(property({"n", 'N', 8}, "+7"), 7);
    EXPECT_EQ(property({"n", 'N', 8}, "000"), 0);
}

TEST(Shapefile, NamesTheReferenceSystem) {
    const std::string wkt = R"(GEOGCS["WGS 84",UNIT["Degree",0.017]])";
    EXPECT_EQ(collection_of({{"n", 'N', 1}}, {"1"}, "", wkt)["crs"]["properties"]["name"], wkt);
    EXPECT_FALSE(collection_of({{"n", 'N', 1}}, {"1"}).contains("crs"));
}

TEST(Shapefile, LeavesOutDeletedRecords) {
    std::string table = dbf_of({{"n", 'N', 1}}, {{"1"}, {"2"}});
    table[table.size() - 4] = '*';
    const Json features = features_of(zip_of({{"a.shp", shp_of({{square(1)}, {square(2)}})}, {"a.dbf", table}}));
    ASSERT_EQ(features.size(), 1U);
    EXPECT_EQ(features[0]["properties"]["n"], 2);
}

TEST(Shapefile, ChoosesTheOneThatIsAskedFor) {
    const std::string archive = zip_of({{"x/a.SHP", kOne},
                                        {"x/a.DBF", dbf_of({{"n", 'N', 1}}, {{"7"}})},
                                        {"x/b.shp", shp_of({{square(2)}, {square(3)}})},
                                        {"__MACOSX/x/._a.shp", "attributes"},
                                        {"readme.txt", "text"}});
    EXPECT_EQ(features_of(archive, "a")[0]["properties"]["n"], 7);
    EXPECT_EQ(features_of(archive, "x/b").size(), 2U);
    const Error several = error_of(archive);
    EXPECT_EQ(several.code, ErrorCode::Unusable);
    EXPECT_EQ(several.field, "object");
    EXPECT_NE(several.message.find("x/a, x/b"), std::string::npos) << several.message;
    const Error other = error_of(archive, "c");
    EXPECT_EQ(other.field, "object");
    EXPECT_NE(other.message.find("x/a, x/b"), std::string::npos) << other.message;
}

TEST(Shapefile, FindsFilesWhoseNamesDifferInCase) {
    const auto table = [](const std::string& value) { return dbf_of({{"n", 'N', 1}}, {{value}}); };
    const std::string mixed = zip_of({{"Map\\Roads.shp", kOne}, {"MAP\\ROADS.DBF", table("7")}});
    EXPECT_EQ(features_of(mixed, "Roads")[0]["properties"]["n"], 7);
    const std::string both = zip_of({{"A.dbf", table("1")}, {"A.shp", kOne}, {"a.shp", kOne}, {"a.dbf", table("2")}});
    EXPECT_EQ(features_of(both, "A")[0]["properties"]["n"], 1);
    EXPECT_EQ(features_of(both, "a")[0]["properties"]["n"], 2);
}

TEST(Shapefile, RefusesInvalidArchives) {
    EXPECT_EQ(error_of("").code, ErrorCode::Unusable);
    EXPECT_EQ(error_of("{}").code, ErrorCode::Unusable);
    EXPECT_NE(message_of({{"readme.txt", "text"}}).find("no shapefile"), std::string::npos);
    const std::string whole = zip_of({{"a.shp", kOne}});
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_EQ(error_of(whole.substr(0, size)).code, ErrorCode::Unusable) << size;
}

TEST(Shapefile, RefusesDamagedMembers) {
    std::string damaged = zip_of({{"a.shp", kOne}});
    damaged[200] = static_cast<char>(damaged[200] ^ 1);
    EXPECT_NE(error_of(damaged).message.find("CRC"), std::string::npos);
    std::string encrypted = zip_of({{"a.shp", kOne}});
    for (const std::size_t flags : {std::size_t{6}, encrypted.find("PK\x01\x02") + 8}) encrypted[flags] = 1;
    EXPECT_NE(error_of(encrypted).message.find("encrypted"), std::string::npos);
    std::string packed = zip_of({{"a.shp", kOne}});
    for (const std::size_t method : {std::size_t{8}, packed.find("PK\x01\x02") + 10}) packed[method] = 12;
    EXPECT_NE(error_of(packed).message.find("deflate"), std::string::npos);
}

TEST(Shapefile, LimitsSizes) {
    const std::string archive = zip_of({{"a.shp", kOne}});
    const Error inflated = error_of(archive, {}, kOne.size() - 1);
    EXPECT_EQ(inflated.code, ErrorCode::LimitExceeded);
    EXPECT_NE(inflated.message.find("max-body"), std::string::npos);
    EXPECT_TRUE(read(archive, {}, kOne.size()));
    const std::string many = zip_of({{"a.shp", shp_of(std::vector<std::vector<Ring>>(100))}});
    const Error text = error_of(many, {}, 2'000);
    EXPECT_EQ(text.code, ErrorCode::LimitExceeded);
    EXPECT_NE(text.message.find("GeoJSON"), std::string::npos);
    EXPECT_EQ(error_of(zip_of(Files(1001, {"a", ""}))).code, ErrorCode::LimitExceeded);

    // A record that claims more corners than its size allows.
    std::string shp = kOne;
    shp[100 + 8 + 40 + 2] = 0x10;
    EXPECT_EQ(error_of(zip_of({{"a.shp", shp}})).code, ErrorCode::LimitExceeded);
}

TEST(Shapefile, RefusesDamagedShapes) {
    EXPECT_NE(message_of({{"a.shp", "no shapes"}}).find(".shp"), std::string::npos);
    EXPECT_NE(message_of({{"a.shp", kOne.substr(0, kOne.size() - 1)}}).find("truncated"), std::string::npos);
    for (const std::size_t at : {107, 108, 108 + 36, 108 + 40, 108 + 44}) {
        std::string shp = kOne;
        shp[at] = 77;
        EXPECT_NE(message_of({{"a.shp", shp}}).find("record 1"), std::string::npos) << at;
    }
    const Ring endless = {{0, 0}, {0, std::numeric_limits<double>::infinity()}, {1, 1}};
    EXPECT_NE(message_of({{"a.shp", shp_of({{square(1)}, {endless}})}}).find("record 2"), std::string::npos);
    EXPECT_NE(message_of({{"a.shp", shp_of({{square(1)}}, 1)}}).find("Point"), std::string::npos);
    EXPECT_NE(message_of({{"a.shp", shp_of({{square(1)}}, 31)}}).find("MultiPatch"), std::string::npos);
}

TEST(Shapefile, RefusesDamagedTables) {
    const auto message = [](const std::string& table) { return message_of({{"a.shp", kOne}, {"a.dbf", table}}); };
    const std::string table = dbf_of({{"n", 'N', 4}}, {{"1"}});
    EXPECT_NE(message("no table").find("damaged"), std::string::npos);
    EXPECT_NE(message(table.substr(0, table.size() - 1)).find("truncated"), std::string::npos);
    EXPECT_NE(message(dbf_of({{"n", 'N', 4}}, {{"1"}, {"2"}})).find("2 records"), std::string::npos);
    std::string wide = table;
    wide[32 + 16] = 99;
    EXPECT_NE(message(wide).find("damaged"), std::string::npos);
}

}  // namespace
}  // namespace ccdt::api
