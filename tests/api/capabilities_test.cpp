// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/capabilities.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "api/sample/plane/sample_parser.h"
#include "tests/api/files.h"
#include "tests/support/halftone_requests.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::json;

Json capabilities(const Limits& limits = {}) {
    return Json::parse(capabilities_json(limits));
}

/// Returns the OpenAPI document of the service.
const Json& openapi() {
    static const Json document = Json::parse(std::ifstream(CCDT_OPENAPI));
    return document;
}

/// Returns a node of the OpenAPI document, or the node that it refers to.
const Json& resolve(const Json& node) {
    if (!node.contains("$ref")) return node;
    return openapi().at(Json::json_pointer(node.at("$ref").get<std::string>().substr(1)));
}

/// Adds the properties of a schema and of the schemas that it includes.
void add_properties(const Json& schema, Json& properties) {
    if (schema.contains("allOf")) {
        for (const Json& part : schema.at("allOf")) add_properties(resolve(part), properties);
    }
    if (schema.contains("properties")) properties.update(schema.at("properties"));
}

Json properties_of(const std::string& schema) {
    Json properties = Json::object();
    add_properties(openapi().at("components").at("schemas").at(schema), properties);
    return properties;
}

std::vector<std::string> all(const Json& list, const std::string& member) {
    std::vector<std::string> values;
    for (const Json& each : list) values.push_back(each.at(member));
    return values;
}

Json row_of(const Json& list, const std::string& name) {
    const auto names = all(list, "name");
    return list.at(static_cast<std::size_t>(std::ranges::find(names, name) - names.begin()));
}

struct Endpoint {
    std::string name;
    std::string schema;

    friend void PrintTo(const Endpoint& endpoint, std::ostream* out) { *out << endpoint.name; }
};

class Documented : public testing::TestWithParam<Endpoint> {};

TEST_P(Documented, HaveTheFormatsThatAreDocumented) {
    const Json formats = capabilities().at(GetParam().name).at("formats");
    const Json documented = resolve(properties_of(GetParam().schema).at("format")).at("enum");
    auto names = all(formats, "name");
    const Json endpoint = capabilities().at(GetParam().name);
    if (endpoint.contains("masks")) std::ranges::copy(all(endpoint.at("masks"), "name"), std::back_inserter(names));
    EXPECT_EQ(names, documented.get<std::vector<std::string>>());
    const Json& answers = openapi().at("paths").at('/' + GetParam().name).at("post").at("responses").at("200");
    std::set<std::string> types;
    for (const auto& [type, content] : resolve(answers).at("content").items()) types.insert(type);
    auto made = all(formats, "media_type");
    if (endpoint.contains("devices"))
        std::ranges::copy(all(endpoint.at("devices").at("formats"), "media_type"), std::back_inserter(made));
    for (const auto* kind : {"surfaces", "volumes"}) {
        if (endpoint.contains(kind))
            std::ranges::copy(all(endpoint.at(kind).at("formats"), "media_type"), std::back_inserter(made));
    }
    if (properties_of(GetParam().schema).contains("split")) made.emplace_back("application/zip");
    EXPECT_EQ(types, std::set<std::string>(made.begin(), made.end()));
}

TEST_P(Documented, ListDocumentedOptions) {
    std::set<std::string> documented;
    const Json properties = properties_of(GetParam().schema);
    for (const auto& [name, schema] : properties.items()) documented.insert(name);
    documented.erase("image");  // the picture itself is not an option
    const Json options = capabilities().at(GetParam().name).at("options");
    EXPECT_EQ(options.get<std::set<std::string>>(), documented);
}

INSTANTIATE_TEST_SUITE_P(Endpoints, Documented,
                         testing::Values(Endpoint{"halftone", "HalftoneRequest"}, Endpoint{"sample", "SampleRequest"},
                                         Endpoint{"analyze", "AnalyzeRequest"}),
                         [](const auto& each) { return each.param.name; });

TEST(Capabilities, ListDocumentedMethods) {
    const auto names = all(capabilities().at("sample").at("methods"), "name");
    for (const auto* schema : {"SampleRequest", "Origin"}) {
        const Json method = resolve(properties_of(schema).at("method"));
        EXPECT_EQ(names, method.at("enum").get<std::vector<std::string>>()) << schema;
    }
}

/// Returns the error for an unknown value of an option, which lists the valid values.
std::string error_for(const std::string& option) {
    const auto request = parse_halftone(fixture("rgba.png"), {{option, "?"}}, "", {});
    return request ? "" : request.error().message;
}

TEST(Capabilities, MatchDocumentedEnumerations) {
    int words = 0;
    const Json properties = properties_of("HalftoneRequest");
    for (const auto& [option, node] : properties.items()) {
        const Json& schema = resolve(node);
        if (!schema.contains("enum") || option == "format") continue;
        std::string expected = option + " is '?', but must be";
        for (const Json& word : schema.at("enum"))
            expected += (word == schema.at("enum").front() ? " '" : " or '") + word.get<std::string>() + "'";
        EXPECT_EQ(error_for(option), expected);
        ++words;
    }
    EXPECT_GE(words, 5);
}

TEST(Capabilities, ReportLimits) {
    const Json json = capabilities({.max_sites = 40'000, .max_pixels = 99, .max_faces = 77});
    EXPECT_EQ(json.at("limits"), Json::parse(R"({"max_sites":40000,"max_pixels":99,"max_faces":77})"));
    const Json methods = json.at("sample").at("methods");
    const auto method = [&](const std::string& name) { return row_of(methods, name); };
    EXPECT_EQ(method("ccdt").at("max_sites"), 40'000);
    EXPECT_EQ(method("cvt").at("max_sites"), 40'000);
    EXPECT_EQ(method("ccvt").at("max_sites"), 20'000);
    EXPECT_GT(method("ccdt").at("seconds_per_site").at("best"), method("ccdt").at("seconds_per_site").at("draft"));
    EXPECT_EQ(method("odt").at("options"), Json::parse(R"(["iterations","tolerance"])"));
}

TEST(Capabilities, ReportWhetherServerOffersDocumentation) {
    for (const bool offered : {false, true})
        EXPECT_EQ(Json::parse(capabilities_json({}, OfferedPictures::None, offered)).at("documentation"), offered);
}

TEST(Capabilities, ListPresets) {
    const auto presets = [](const OfferedPresets& offered) {
        return Json::parse(capabilities_json({}, OfferedPictures::None, false, offered)).at("presets");
    };
    EXPECT_EQ(presets({}), Json::parse(R"({"names": [], "required": false})"));
    EXPECT_EQ(presets({{"a", "b"}, true}), Json::parse(R"({"names": ["a", "b"], "required": true})"));
}

TEST(Capabilities, ReportWhetherServerOffersPictures) {
    const auto offered = [](OfferedPictures pictures) {
        return Json::parse(capabilities_json({}, pictures)).at("halftone").at("pictures");
    };
    EXPECT_EQ(offered(OfferedPictures::None), "none");
    EXPECT_EQ(offered(OfferedPictures::Unsigned), "unsigned");
    EXPECT_EQ(offered(OfferedPictures::Signed), "signed");
}

TEST(Capabilities, ListDevicesWithDocumentedNamesFormatsAndOptions) {
    const Json devices = capabilities().at("halftone").at("devices");
    const Json documented = properties_of("DeviceOptions");
    EXPECT_EQ(all(devices.at("types"), "name"), documented.at("device").at("enum").get<std::vector<std::string>>());
    EXPECT_EQ(all(devices.at("formats"), "name"), documented.at("format").at("enum").get<std::vector<std::string>>());
    std::set<std::string> names;
    for (const auto& [name, schema] : documented.items()) names.insert(name);
    EXPECT_EQ(devices.at("options").get<std::set<std::string>>(), names);
}

TEST(Capabilities, ListColoursOfDevicesAsSentAndAsSeen) {
    const Json types = capabilities().at("halftone").at("devices").at("types");
    for (const Json& type : types) EXPECT_EQ(type.at("sent").size(), type.at("seen").size()) << type;
    EXPECT_EQ(row_of(types, "1bit").at("sent"), Json::parse(R"(["#000000","#ffffff"])"));
    EXPECT_EQ(row_of(types, "gray4").at("seen"), Json::parse(R"(["#000000","#555555","#aaaaaa","#ffffff"])"));
    EXPECT_EQ(row_of(types, "bwr").at("sent"), Json::parse(R"(["#000000","#ffffff","#ff0000"])"));
    EXPECT_EQ(row_of(types, "bwr").at("seen"), Json::parse(R"(["#0a070e","#adb2ae","#55180e"])"));
    EXPECT_EQ(row_of(types, "custom").at("sent"), Json::array());
}

TEST(Capabilities, ListPixelSetsWithDocumentedFormatsAndOptions) {
    const Json pixels = capabilities().at("sample").at("pixels");
    const Json documented = properties_of("PixelRequest");
    EXPECT_EQ(all(pixels.at("formats"), "name"), documented.at("format").at("enum").get<std::vector<std::string>>());
    std::set<std::string> names;
    for (const auto& [name, schema] : documented.items()) names.insert(name);
    EXPECT_EQ(pixels.at("options").get<std::set<std::string>>(), names);
}

TEST(Capabilities, ListChoicesWithDocumentedFormatsAndOptions) {
    const Json choices = capabilities().at("sample").at("choices");
    const Json documented = properties_of("ChoiceOptions");
    EXPECT_EQ(all(choices.at("formats"), "name"), documented.at("format").at("enum").get<std::vector<std::string>>());
    std::set<std::string> names;
    for (const auto& [name, schema] : documented.items()) names.insert(name);
    EXPECT_EQ(choices.at("options").get<std::set<std::string>>(), names);
}

TEST(Capabilities, ListSurfacesWithDocumentedFormatsAndOptions) {
    const Json surfaces = capabilities().at("sample").at("surfaces");
    const Json documented = properties_of("SurfaceOptions");
    EXPECT_EQ(all(surfaces.at("formats"), "name"), documented.at("format").at("enum").get<std::vector<std::string>>());
    std::set<std::string> names;
    for (const auto& [name, schema] : documented.items()) names.insert(name);
    EXPECT_EQ(surfaces.at("options").get<std::set<std::string>>(), names);
    EXPECT_EQ(all(surfaces.at("inputs"), "name"),
              (std::vector<std::string>{"stl", "obj", "ply", "off", "gltf", "glb"}));
    EXPECT_EQ(row_of(surfaces.at("formats"), "obj").at("needs"), Json::parse(R"(["mesh"])"));
    EXPECT_EQ(row_of(surfaces.at("formats"), "glb").at("needs"), Json::array());
}

TEST(Capabilities, ListVolumesWithDocumentedFormatsAndOptions) {
    const Json volumes = capabilities().at("sample").at("volumes");
    const Json documented = properties_of("VolumeOptions");
    std::set<std::string> names;
    for (const auto& [name, schema] : documented.items()) names.insert(name);
    EXPECT_EQ(volumes.at("options").get<std::set<std::string>>(), names);
    EXPECT_EQ(all(volumes.at("formats"), "name"), documented.at("format").at("enum").get<std::vector<std::string>>());
    EXPECT_EQ(all(volumes.at("inputs"), "name"), (std::vector<std::string>{"npy", "tiff"}));
    EXPECT_EQ(row_of(volumes.at("formats"), "msh").at("needs"), Json::parse(R"(["mesh"])"));
}

TEST(Capabilities, ReportDrawnFormatsAndTheirLargestSize) {
    const Json formats = capabilities().at("halftone").at("formats");
    const auto format = [&](const std::string& name) { return row_of(formats, name); };
    for (const auto* name : {"png", "svg", "webp", "jpeg", "tiff", "pdf", "eps", "hpgl"})
        EXPECT_EQ(format(name).at("drawn"), true) << name;
    for (const auto* name : {"json", "csv", "npy"}) EXPECT_EQ(format(name).at("drawn"), false) << name;
    EXPECT_EQ(format("webp").at("max_side"), 16'383);
    EXPECT_EQ(format("jpeg").at("max_side"), 65'500);
    for (const auto* name : {"png", "svg", "json"}) EXPECT_EQ(format(name).at("max_side"), Json()) << name;
    for (const auto* name : {"pdf", "eps", "hpgl", "gcode", "dxf"})
        EXPECT_EQ(format(name).at("needs"), Json::parse(R"(["width_mm"])")) << name;
    EXPECT_EQ(format("svg").at("needs"), Json::array());
}

}  // namespace
}  // namespace ccdt::api
