// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/option_reader.h"

#include <gtest/gtest.h>

#include <array>

namespace ccdt::api {
namespace {

Input text(std::string_view value) {
    return {"option", "option", value};
}

/// A JSON value with the document that contains it.
struct Json {
    explicit Json(std::string_view source) : document(*JsonDocument::parse(source)) {}
    operator Input() const { return {"option", "/option", document.root()}; }

    JsonDocument document;
};

TEST(OptionReader, ReadsIntegersFromText) {
    EXPECT_EQ(*read_integer(text("0"), 0, 10), 0U);
    EXPECT_EQ(*read_integer(text("9007199254740991"), 0, kMaxInteger), kMaxInteger);
    for (const auto* wrong :
         {"", " 1", "1 ", "+1", "-1", "12abc", "3.7", "1e3", "0x10", "11", "nan", "99999999999999999999999"}) {
        const auto value = read_integer(text(wrong), 0, 10);
        ASSERT_FALSE(value) << wrong;
        EXPECT_EQ(value.error().code, ErrorCode::Malformed);
        EXPECT_EQ(value.error().field, "option");
        EXPECT_EQ(value.error().message, "option must be an integer from 0 to 10");
    }
}

TEST(OptionReader, ReadsIntegersFromJson) {
    EXPECT_EQ(*read_integer(Json("7"), 0, 10), 7U);
    EXPECT_EQ(*read_integer(Json("7.0"), 0, 10), 7U);
    EXPECT_EQ(*read_integer(Json("9007199254740991"), 0, kMaxInteger), kMaxInteger);
    for (const auto* wrong :
         {"-1", "3.7", "1e30", "9007199254740992", "18446744073709551617", "\"7\"", "true", "null", "[7]", "{}"}) {
        EXPECT_FALSE(read_integer(Json(wrong), 0, kMaxInteger)) << wrong;
    }
}

TEST(OptionReader, ReadsLists) {
    const auto numbers = [](const Input& input) {
        const auto members = read_list(input, 3, "value");
        std::vector<double> read;
        for (const Input& member : *members) read.push_back(*read_number(member, {}));
        return read;
    };
    EXPECT_EQ(numbers(text("1, 2.5 ,3")), (std::vector<double>{1, 2.5, 3}));
    EXPECT_EQ(numbers(Json("[1,2.5,3]")), (std::vector<double>{1, 2.5, 3}));
    EXPECT_TRUE(numbers(text("")).empty() && numbers(Json("[]")).empty());
    EXPECT_TRUE(numbers(text("1,2,3,4")).empty() && numbers(Json("[1,2,3,4]")).empty());
    EXPECT_EQ(read_list(text("1,x"), 3, "value")->back().name, "option: value 2");
    EXPECT_EQ(read_list(Json("[1,2]"), 3, "value")->back().field, "/option/1");
    EXPECT_FALSE(read_list(Json("{}"), 3, "value"));
}

TEST(OptionReader, ReadsNumbers) {
    constexpr Interval allowed = {.min = 0.1, .max = 16};
    EXPECT_EQ(*read_number(text("0.1"), allowed), 0.1);
    EXPECT_EQ(*read_number(text("1e1"), allowed), 10);
    EXPECT_EQ(*read_number(Json("16"), allowed), 16);
    for (const auto* wrong : {"", "0.09", "16.1", "nan", "inf", "-1", "1,5", "2x", "1e999", "0x1p1"}) {
        const auto value = read_number(text(wrong), allowed);
        ASSERT_FALSE(value) << wrong;
        EXPECT_EQ(value.error().message, "option must be a number from 0.1 to 16");
    }
    EXPECT_FALSE(read_number(Json("\"1\""), allowed));
    EXPECT_FALSE(read_number(text("0"), kPositive));
    EXPECT_FALSE(read_number(text("inf"), kPositive));
    EXPECT_EQ(*read_number(text("1e-300"), kPositive), 1e-300);
}

TEST(OptionReader, ReadsBooleans) {
    EXPECT_TRUE(*read_boolean(text("true")));
    EXPECT_TRUE(*read_boolean(text("1")));
    EXPECT_FALSE(*read_boolean(text("false")));
    EXPECT_FALSE(*read_boolean(text("0")));
    EXPECT_TRUE(*read_boolean(Json("true")));
    for (const auto* wrong : {"", "True", "yes", "on", "2"}) EXPECT_FALSE(read_boolean(text(wrong))) << wrong;
    for (const auto* wrong : {"1", "0", "\"true\"", "null"}) EXPECT_FALSE(read_boolean(Json(wrong))) << wrong;
}

TEST(OptionReader, ReadsChoices) {
    constexpr std::array<Choice<int>, 2> choices = {{{"linear", 7}, {"perceptual", -3}}};
    EXPECT_EQ(*read_choice<int>(text("perceptual"), choices), -3);
    EXPECT_EQ(*read_choice<int>(Json("\"linear\""), choices), 7);
    EXPECT_EQ(read_choice<int>(text("loud"), choices).error().message,
              "option is 'loud', but must be 'linear' or 'perceptual'");
    EXPECT_FALSE(read_choice<int>(Json("1"), choices));
}

TEST(OptionReader, PrefixesErrorsOfCoreWithAPointer) {
    const auto field = [](std::string name, std::string_view pointer) {
        return error_below({ErrorCode::Malformed, "", std::move(name)}, pointer).field;
    };
    EXPECT_EQ(field("", "/density"), "/density");
    EXPECT_EQ(field("values", "/density"), "/density/values");
    EXPECT_EQ(field("/0/3", "/sets"), "/sets/0/3");
    EXPECT_EQ(field("sites", ""), "/sites");
    EXPECT_EQ(field("", ""), "");
}

TEST(OptionReader, DistinguishesTooManySitesFromInvalidNumbers) {
    const Limits limits = {.max_sites = 100};
    EXPECT_EQ(*read_sites(text("100"), limits), 100U);
    EXPECT_EQ(read_sites(text("0"), limits).error().code, ErrorCode::Malformed);
    const auto many = read_sites(text("101"), limits);
    EXPECT_EQ(many.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(many.error().message, "option is 101; this server's limit (max-sites) is 100");
}

struct Target {
    bool flag = false;
};

constexpr std::array<OptionRule<Target>, 1> kRules = {{
    {"flag", [](const Input& i, const Limits&, Target& t) { return assign(t.flag, read_boolean(i)); }},
}};

Result<void> read_flags(const std::vector<TextOption>& options) {
    Target target;
    return read_options<Target>(kRules, inputs_of(options), {}, target);
}

TEST(OptionReader, NamesUnknownAndRepeatedOptions) {
    EXPECT_TRUE(read_flags({{"flag", "1"}}));
    EXPECT_EQ(read_flags({{"flga", "1"}}).error().message, "unknown option 'flga'; the options are flag");
    EXPECT_EQ(read_flags({{"flga", "1"}}).error().field, "flga");
    EXPECT_EQ(read_flags({{"flag", "1"}, {"flag", "1"}}).error().message, "flag is given twice");
}

TEST(OptionReader, ReportsAllErrors) {
    const auto read = read_flags({{"flag", "x"}, {"flga", "1"}, {"flag", "1"}});
    EXPECT_EQ(read.error().message, "flag must be true or false");
    ASSERT_EQ(read.error().others.size(), 2U);
    EXPECT_EQ(read.error().others[0].field, "flga");
    EXPECT_EQ(read.error().others[1].message, "flag is given twice");
    EXPECT_EQ(read_flags(std::vector<TextOption>(1000, {"x", "1"})).error().others.size(), 9U);
}

TEST(OptionReader, KeepsMessagesShort) {
    const auto read = read_flags({{std::string(1'000'000, 'x'), "1"}});
    EXPECT_LT(read.error().message.size(), 200U);
    EXPECT_LT(read.error().field.size(), 200U);
}

}  // namespace
}  // namespace ccdt::api
