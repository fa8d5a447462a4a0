// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/json/feature_texts.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace ccdt::api {
namespace {

using Texts = std::vector<std::string_view>;

Texts texts_of(std::string_view file) {
    const auto found = find_features(file);
    Texts texts;
    if (!found) return {"none"};
    for (const TextRange each : found->features) texts.push_back(each.in(file));
    return texts;
}

TEST(FeatureTexts, FindsTheElementsOfTheMemberFeatures) {
    EXPECT_EQ(texts_of(R"({"type":"x","features":[{"a":1},{"b":"]}\""} , 3 ],"features2":[4]})"),
              (Texts{R"({"a":1})", R"({"b":"]}\""})", "3"}));
    EXPECT_EQ(texts_of(R"( {"a":{"features":[1]},"b\"features":[2],"features" : [ [1,{}], null]})"),
              (Texts{"[1,{}]", "null"}));
    EXPECT_EQ(texts_of("\xEF\xBB\xBF{\"features\":[]}"), Texts());
    const std::string file = R"({"features": [ 1, 2 ] })";
    EXPECT_EQ(find_features(file)->list->in(file), " 1, 2 ");
}

TEST(FeatureTexts, FindsTheObjectsOfASequence) {
    EXPECT_EQ(texts_of("{\"a\":1}\n{\"b\":[{}]}\n\n"), (Texts{R"({"a":1})", R"({"b":[{}]})"}));
    EXPECT_EQ(texts_of("\x1E{\"a\":1}\n\x1E{}\n"), (Texts{R"({"a":1})", "{}"}));
    EXPECT_FALSE(find_features("{}{}")->list);
}

/// The places are found, or not, for any text. The parser reports the faults.
TEST(FeatureTexts, EndsForInvalidText) {
    const std::string whole = R"({"features":[{"a":"b\\"},{"c":[1,2]}],"d":1})";
    for (std::size_t length = 0; length < whole.size(); ++length) {
        const std::string_view start = std::string_view(whole).substr(0, length);
        if (const auto found = find_features(start)) {
            for (const TextRange each : found->features) EXPECT_LE(each.end, length);
        }
    }
    for (const char* file : {"", "[1]", "{", "}", "{\"features\":[,]}", "{\"features\":[1,]}", "{\"features\":[1 2]}",
                             "{}x", "{\"features\":[1"})
        EXPECT_TRUE(texts_of(file) == Texts{"none"} || texts_of(file).size() < 3) << file;
}

}  // namespace
}  // namespace ccdt::api
