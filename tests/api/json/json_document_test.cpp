// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/json/json_document.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ccdt::api {
namespace {

TEST(JsonDocument, KeepsValuesInOrder) {
    const auto document = JsonDocument::parse(R"({"a":[1,-2.5,true,null,"x"],"b":{},"c":[[],[3]]})");
    ASSERT_TRUE(document);
    const JsonValue root = document->root();
    ASSERT_TRUE(root.is_object());
    EXPECT_EQ(root.size(), 3U);
    const auto members = root.members();
    EXPECT_EQ(members[0].name, "a");
    EXPECT_EQ(members[1].name, "b");
    EXPECT_EQ(members[2].name, "c");
    std::vector<JsonValue> elements;
    for (const JsonValue element : members[0].value) elements.push_back(element);
    ASSERT_EQ(elements.size(), 5U);
    EXPECT_EQ(elements[0].number(), 1);
    EXPECT_EQ(elements[1].number(), -2.5);
    EXPECT_TRUE(elements[2].boolean());
    EXPECT_FALSE(elements[3].is_number() || elements[3].is_boolean() || elements[3].is_string());
    EXPECT_EQ(elements[4].text(), "x");
    EXPECT_EQ(members[1].value.size(), 0U);
    EXPECT_EQ(members[2].value.size(), 2U);
}

TEST(JsonDocument, FindsMembersByName) {
    const auto document = JsonDocument::parse(R"({"a":{"b":1},"b":2})");
    EXPECT_EQ(document->root().find("b")->number(), 2);
    EXPECT_FALSE(document->root().find("c"));
}

TEST(JsonDocument, RefusesInvalidJson) {
    for (const auto* wrong : {"", " ", "{", "[1,]", "{\"a\"}", "nul", "01", "1 2", "\"\x80\"", "[1e999]", "NaN",
                              "{'a':1}", "[1]x", "\"\\ud800\""}) {
        const auto document = JsonDocument::parse(wrong);
        ASSERT_FALSE(document) << wrong;
        EXPECT_EQ(document.error().code, ErrorCode::Malformed);
        EXPECT_NE(document.error().message.find("not valid JSON"), std::string::npos);
    }
}

TEST(JsonDocument, RefusesTextAfterTheValue) {
    for (const char c : {'\0', '\v', '\f', '\x01', '\x7f', '\xa0', '}', ','}) {
        for (const std::string& text : {std::string("{}") + c, std::string("1") + c, std::string("[1]") + c + " [2]"})
            EXPECT_FALSE(JsonDocument::parse(text)) << static_cast<int>(c);
    }
    EXPECT_TRUE(JsonDocument::parse(" \t\r\n{} \t\r\n"));
    EXPECT_EQ(JsonDocument::parse(std::string("[1]\0", 4)).error().message,
              "the body is not valid JSON: error at byte 4");
}

TEST(JsonDocument, ExplainsErrorsThatAreNotSeenInTheText) {
    const auto reason = [](const std::string& text) {
        const std::string message = JsonDocument::parse(text).error().message;
        return message.substr(message.find("byte"));
    };
    EXPECT_EQ(reason(R"({"a":[1)"), "byte 8: the text ends");
    EXPECT_EQ(reason("[\"Gr\xfc\xdf\"]"), "byte 5: the text is not in UTF-8");
    EXPECT_EQ(reason("[1e400]"), "byte 6: the number is too large");
    EXPECT_EQ(reason("[0, NaN]"), "byte 5: numbers must be finite");
    EXPECT_EQ(reason("[0, -Infinity]"), "byte 6: numbers must be finite");
    for (const char* unknown : {"[0, x]", "[0, None]"}) EXPECT_EQ(reason(unknown), "byte 5") << unknown;
}

TEST(JsonDocument, LimitsTheDepth) {
    const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
    EXPECT_TRUE(JsonDocument::parse(nested(JsonDocument::kMaxDepth)));
    EXPECT_FALSE(JsonDocument::parse(nested(JsonDocument::kMaxDepth + 1)));
    const auto million = JsonDocument::parse(std::string(1'000'000, '['));
    ASSERT_FALSE(million);
    EXPECT_EQ(million.error().code, ErrorCode::Malformed);
    EXPECT_NE(million.error().message.find("deeper"), std::string::npos);
}

TEST(JsonDocument, LimitsTheNumberOfValues) {
    std::string text = "[";
    for (std::size_t i = 0; i < JsonDocument::kMaxValues; ++i) text += "0,";
    text += "0]";
    const auto document = JsonDocument::parse(text);
    ASSERT_FALSE(document);
    EXPECT_EQ(document.error().code, ErrorCode::LimitExceeded);
}

TEST(JsonDocument, RefusesDuplicateMembers) {
    EXPECT_TRUE(JsonDocument::parse(R"({"a":{"a":1},"b":{"a":1}})"));
    for (const auto* wrong : {R"({"a":1,"a":1})", R"([{"b":{"x":1,"y":2,"x":3}}])", R"({"a":1,"\u0061":2})"}) {
        const auto document = JsonDocument::parse(wrong);
        ASSERT_FALSE(document) << wrong;
        EXPECT_EQ(document.error().code, ErrorCode::Malformed);
        EXPECT_NE(document.error().message.find("twice"), std::string::npos);
    }
}

TEST(JsonPointer, EscapesNames) {
    EXPECT_EQ(pointer_below("", "a/b~c"), "/a~1b~0c");
    EXPECT_EQ(pointer_below("/polygon", std::size_t{17}), "/polygon/17");
}

std::string rewritten(const Result<JsonDocument>& document) {
    if (!document) return document.error().message;
    std::string text;
    append_json(text, document->root());
    return text;
}

TEST(JsonDocument, KeepsAllDigitsOfIntegers) {
    const std::string integers =
        "[9007199254740992,9007199254740993,-9007199254740993,18446744073709551615,18446744073709551617,"
        "-123456789012345678901234567890]";
    const auto document = JsonDocument::parse(integers);
    EXPECT_EQ(rewritten(document), integers);
    for (const JsonValue value : document->root()) EXPECT_TRUE(value.is_number() && !value.is_string());
    EXPECT_EQ((*++document->root().begin()).number(), 9007199254740992);
    EXPECT_EQ(rewritten(JsonDocument::parse("[1.0,1e20,-0.5]")), "[1,1e+20,-0.5]");
}

TEST(JsonDocument, ReadsSequencesAsFeatures) {
    const std::string both = R"({"type":"FeatureCollection","features":[{"a":1},{"b":[2,"}\n{"]}]})";
    const std::string a = R"({"a":1})", b = R"({"b":[2,"}\n{"]})";
    for (const std::string& text : {a + "\n" + b, a + "\r\n" + b + "\r\n", "\n" + a + "\n\n \n" + b + "\n\n",
                                    "\xEF\xBB\xBF" + a + "\n" + b, "\x1E" + a + "\n\x1E" + b + "\n",
                                    "\x1E\x1E" + a + "\x1E" + b, "\xEF\xBB\xBF\x1E" + a + "\x1E" + b,
                                    R"({
  "a": 1
})" + std::string("\n") + b})
        EXPECT_EQ(rewritten(JsonDocument::parse_features(text)), both) << text;
    EXPECT_EQ(rewritten(JsonDocument::parse_features("\x1E" + a + "\n")),
              R"({"type":"FeatureCollection","features":[{"a":1}]})");
    EXPECT_EQ(rewritten(JsonDocument::parse_features(a + "\r\n")), a);
    EXPECT_EQ(rewritten(JsonDocument::parse_features("[1]")), "[1]");
}

TEST(JsonDocument, ReportsErrorsInSequences) {
    const auto message = [](std::string_view text) { return rewritten(JsonDocument::parse_features(text)); };
    EXPECT_EQ(message("{\"a\":1}\n{\"b\":x}"), "the body is not valid JSON: error at byte 14");
    EXPECT_EQ(message("{\"a\":1}\n{\"b\":1"), "the body is not valid JSON: error at byte 15: the text ends");
    EXPECT_EQ(message("{\"a\":1}\nx"), "the body is not valid JSON: error at byte 9");
    EXPECT_EQ(message("\x1E{\"a\":1}\n\x1E{\"a\":1,\"a\":2}"), "a JSON object has the member 'a' twice");
    EXPECT_EQ(message("{}\n[]"), "the body is not valid JSON: error at byte 4");
    EXPECT_FALSE(JsonDocument::parse("{}\n{}"));
}

}  // namespace
}  // namespace ccdt::api
