// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/presets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace ccdt::server {
namespace {

Presets example() {
    return Presets::
        parse(R"({"poster": {"sites": 20000, "color": "cmyk", "invert": true, "fixed": [[0, 0.5]]}, "map-1": {"sites": "POP"}})")
            .value();
}

/// Returns the expanded query, or the error.
/// @param form  fields of a form, as in a query
std::string expanded(const std::string& query, bool only = false, const std::string& form = {}) {
    ComputeRequest request{"/sample", query, {}, {}, {}};
    std::vector<FormPart> fields;
    for (const auto& [name, value] : parse_query(form)) {
        fields.push_back({name, request.body.size(), value.size()});
        request.body += value;
    }
    const auto result = example().expand(request, fields, only);
    EXPECT_EQ(std::ranges::count(fields, "preset", &FormPart::name), 0);
    return result ? request.query : result.error().field + ": " + result.error().message;
}

TEST(Presets, ReplaceTheParameterByItsOptions) {
    EXPECT_EQ(expanded("preset=poster"), "sites=20000&color=cmyk&invert=true&fixed=%5B%5B0%2C0.5%5D%5D");
    EXPECT_EQ(expanded("seed=7&preset=map-1&format=svg"), "sites=POP&seed=7&format=svg");
    EXPECT_EQ(expanded("preset=map%2D1", true), "sites=POP");
    EXPECT_EQ(example().names(), (std::vector<std::string>{"map-1", "poster"}));
}

TEST(Presets, AreOverriddenByTheQuery) {
    EXPECT_EQ(expanded("sites=9&preset=map-1"), "sites=9");
    EXPECT_EQ(expanded("s%69tes=9&preset=map-1"), "sites=9");
}

TEST(Presets, MayBeFieldsOfForms) {
    EXPECT_EQ(expanded("seed=7", false, "image=...&preset=map-1"), "sites=POP&seed=7");
    EXPECT_EQ(expanded("", false, "preset=map-1&sites=9"), "");
    EXPECT_EQ(expanded("", true, "image=...&preset=map-1"), "sites=POP");
    EXPECT_EQ(expanded("preset=map-1", false, "preset=map-1"), "preset: preset is given more than once");
}

TEST(Presets, LeaveOtherQueriesUnchanged) {
    for (const char* query : {"", "sites=%39&&a", "presets=poster"}) EXPECT_EQ(expanded(query), query);
}

TEST(Presets, RefuseUnknownAndRepeatedNames) {
    EXPECT_EQ(expanded("preset=postr"), "preset: there is no preset 'postr'; did you mean poster?");
    EXPECT_EQ(expanded("preset="), "preset: there is no preset ''");
    EXPECT_EQ(expanded("preset=poster&preset=poster"), "preset: preset is given more than once");
    ComputeRequest request{"/sample", "preset=a", {}, {}, {}};
    std::vector<FormPart> fields;
    EXPECT_EQ(Presets().expand(request, fields, false).error().message, "this server has no presets (presets)");
}

TEST(Presets, MayBeTheOnlyOptions) {
    EXPECT_EQ(expanded("", true), "preset: this server needs preset=NAME (presets-only)");
    EXPECT_EQ(expanded("preset=poster&seed=1", true),
              "seed: this server accepts no options besides a preset (presets-only)");
    EXPECT_EQ(expanded("seed=1&preset=poster", true),
              "seed: this server accepts no options besides a preset (presets-only)");
}

TEST(Presets, AreRefusedInOtherForms) {
    const std::pair<const char*, const char*> wrongs[] = {
        {"", ""},
        {"[]", "presets must be members of an object"},
        {R"({"a b": {"sites": 1}})", "the name of a preset must have"},
        {R"({"a": 3})", "a must be an object with options"},
        {R"({"a": {}})", "a must be an object with options"},
        {R"({"a": {"siets": 3}})", "a: there is no option 'siets'; did you mean sites?"},
        {R"({"a": {"preset": "b"}})", "a: there is no option 'preset'"},
    };
    for (const auto& [json, message] : wrongs) {
        const auto presets = Presets::parse(json);
        ASSERT_FALSE(presets) << json;
        EXPECT_EQ(presets.error().message.find(message), 0u) << presets.error().message;
    }
}

}  // namespace
}  // namespace ccdt::server
