// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/request.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/cli/arguments.h"

namespace ccdt::server {
namespace {

/// A command with its arguments.
struct Line {
    Line(std::string_view name, const std::vector<const char*>& texts)
        : command(*find_command(name)), options(options_of(command)), arguments(*parse_arguments(options, texts)) {}

    Result<ApiRequest> build(const std::string* input) const { return build_request(command, arguments, input); }

    std::string format_for(const std::string& output) const {
        const auto format = find_format(command, arguments, output);
        return format ? std::string((*format)->name) : format.error().message;
    }

    const Command& command;
    std::vector<Option> options;
    Arguments arguments;
};

TEST(Request, PassesOptionsBesideAnInput) {
    const std::string input = "bytes";
    const Line line("halftone", {"--sites=20", "--palette=#f00,#00f", "--no-antialias"});
    const auto request = line.build(&input);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->body, input);
    ASSERT_EQ(request->options.size(), 3U);
    EXPECT_EQ(request->options[2].name, "antialias");
    EXPECT_EQ(request->options[2].value, "false");
}

TEST(Request, BuildsAJsonBodyWithoutAMap) {
    const Line line("sample", {"--domain", R"({"type":"torus","width":1,"height":2})", "--sites=20", "--mesh",
                               "--classes=a,b", "--seed=abc", "--method=ccdt"});
    const auto request = line.build(nullptr);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->body,
              R"({"domain":{"type":"torus","width":1,"height":2},"sites":20,"mesh":true,"classes":"a,b","seed":"abc",)"
              R"("method":"ccdt"})");
    EXPECT_TRUE(request->options.empty());
}

TEST(Request, PutsAMapIntoABodyIfAnOptionRequiresIt) {
    const std::string map = R"({"type":"Polygon","coordinates":[]})";
    EXPECT_EQ(Line("sample", {"--sites=20"}).build(&map)->body, map);
    const std::string no_map = "1},";
    EXPECT_NE(Line("sample", {"--fixed=[]"}).build(&no_map).error().message.find("seems to be text"),
              std::string::npos);
    EXPECT_EQ(Line("sample", {"--sites=20", "--fixed=[[1,2]]"}).build(&map)->body,
              R"({"geometry":)" + map + R"(,"sites":20,"fixed":[[1,2]]})");
}

TEST(Request, ListsThePointsOfAFile) {
    const std::string file = "x,y\n0.5,0.25\n1e-3,1\n";
    EXPECT_EQ(Line("analyze", {"--spectrum"}).build(&file)->body,
              R"({"points":[[0.5,0.25],[0.001,1]],"spectrum":true})");
    EXPECT_EQ(Line("analyze", {"--sets=[[[1,2],[3,4]]]"}).build(nullptr)->body, R"({"sets":[[[1,2],[3,4]]]})");
}

TEST(Request, RefusesValuesThatAreNotJson) {
    const auto request = Line("sample", {"--domain={\"a\":1}}"}).build(nullptr);
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().field, "domain");
    EXPECT_NE(request.error().message.find("domain is not valid JSON"), std::string::npos) << request.error().message;
}

TEST(Request, ChoosesTheFormatByTheSuffix) {
    const Line halftone("halftone", {});
    EXPECT_EQ(halftone.format_for("a.png"), "png");
    EXPECT_EQ(halftone.format_for("a.b/c.SVG"), "svg");
    EXPECT_EQ(halftone.format_for("a.tif"), "tiff");
    EXPECT_EQ(halftone.format_for("a.plt"), "hpgl");
    EXPECT_EQ(halftone.format_for("a.hpgl"), "hpgl");
    EXPECT_EQ(halftone.format_for("-"), "png");
    EXPECT_EQ(halftone.format_for("/dev/null"), "png");
    EXPECT_EQ(Line("halftone", {"--format=csv"}).format_for("a.txt"), "csv");
    EXPECT_EQ(Line("halftone", {"--device=bwr"}).format_for("a.bmp"), "bmp");
    EXPECT_EQ(Line("sample", {}).format_for("-"), "json");
    EXPECT_EQ(Line("sample", {}).format_for("a.geojson"), "geojson");
    EXPECT_EQ(Line("analyze", {}).format_for("a.svg"), "svg");
    for (const auto& [name, output] : {std::pair("halftone", "a.gif"), {"analyze", "a.csv"}, {"sample", "a"}})
        EXPECT_NE(Line(name, {}).format_for(output).find("the suffix names no format"), std::string::npos) << output;
    EXPECT_NE(Line("halftone", {"--device=bwr"}).format_for("a.svg").find(".png, .bmp"), std::string::npos);
}

TEST(Request, ReadsNoLargeFileOfAnUnknownKind) {
    const auto is_read = [](std::string head) {
        head.resize(1'000);
        return check_head(*find_command("sample"), head).has_value();
    };
    EXPECT_TRUE(is_read(std::string("SQLite format 3").append(53, '\0') + "GPKG"));
    EXPECT_TRUE(is_read({'i', 0, 'd', 0, ',', 0}));
    EXPECT_FALSE(is_read("\1"));
    EXPECT_FALSE(is_read(""));
}

TEST(Request, DescribesErrorsByOptionsAndFlags) {
    const auto options = options_of(*find_command("sample"));
    const auto describe = [&](std::string message, std::string field) {
        const auto [option, text] =
            describe_error({ErrorCode::Malformed, std::move(message), std::move(field)}, options);
        return option + "|" + text;
    };
    EXPECT_EQ(describe("sites must be 1", "sites"), "--sites|--sites must be 1");
    EXPECT_EQ(describe("/sites must be 1", "/sites"), "--sites|--sites must be 1");
    EXPECT_EQ(describe("/domain/width must be 1", "/domain/width"), "--domain|--domain/width must be 1");
    EXPECT_EQ(describe("width_mm is missing", "width_mm"), "--width-mm|--width-mm is missing");
    EXPECT_EQ(describe("a side is too long", "/width"), "--width|--width: a side is too long");
    EXPECT_EQ(describe("/features/0 must be an object", "/features/0"), "|/features/0 must be an object");
    EXPECT_EQ(describe("the body is not valid JSON", ""), "|the input is not valid JSON");
    EXPECT_EQ(describe("there are 3; this server's limit (max-sites) is 2", ""),
              "|there are 3; the limit (--max-sites) is 2");
}

}  // namespace
}  // namespace ccdt::server
