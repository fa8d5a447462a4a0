// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/feature_list.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ccdt::api {
namespace {

std::string feature(const std::string& properties, const std::string& more = "") {
    return R"({"type":"Feature","geometry":null,"properties":)" + properties + more + '}';
}

std::string collection(const std::string& features) {
    return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

Result<FeatureList> list(const std::string& text, const PropertyChoice& choice = {.all = true, .names = {}}) {
    const auto document = JsonDocument::parse(text);
    EXPECT_TRUE(document) << document.error().message;
    return list_features(*find_features({"/geometry", "/geometry", document->root()}), {}, 0, &choice, "/properties");
}

std::string members(const FeatureList& features, std::size_t feature) {
    std::string out;
    features.carried.append_members(out, feature);
    return out;
}

Result<PropertyChoice> choice_of(const std::string& json) {
    const auto document = JsonDocument::parse(json);
    return read_properties({"/properties", "/properties", document->root()});
}

TEST(PropertyChoice, ReadsAStarOrNames) {
    EXPECT_TRUE(choice_of(R"("*")")->all);
    EXPECT_TRUE(read_properties({"properties", "properties", std::string_view("*")})->all);
    const auto names = read_properties({"properties", "properties", std::string_view("name, iso")});
    ASSERT_TRUE(names) << names.error().message;
    EXPECT_FALSE(names->all);
    EXPECT_EQ(names->names, (std::vector<std::string>{"name", "iso"}));
    EXPECT_EQ(choice_of(R"(["a,b","*"])")->names, (std::vector<std::string>{"a,b", "*"}));
}

TEST(PropertyChoice, RefusesInvalidNames) {
    EXPECT_EQ(choice_of(R"(["a",7])").error().field, "/properties/1");
    EXPECT_EQ(choice_of(R"(["a","a"])").error().message, "/properties/1 repeats an earlier name");
    EXPECT_EQ(choice_of("[]").error().message, "/properties must have 1 to 256 properties");
    EXPECT_FALSE(choice_of("\"\""));
    EXPECT_FALSE(choice_of("7"));
    EXPECT_FALSE(choice_of("{}"));
}

TEST(FeatureList, KeepsTheTypesOfValues) {
    const auto features =
        list(collection(feature(R"({"s":"a\"b","i":7,"d":0.1,"t":true,"n":null,"o":{"a":[1,"\u0009"],"b":{}}})")));
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(members(*features, 0), R"("s":"a\"b","i":7,"d":0.1,"t":true,"n":null,"o":{"a":[1,"\t"],"b":{}})");
}

TEST(FeatureList, CarriesChosenPropertiesInTheGivenOrder) {
    const auto features =
        list(collection(feature(R"({"a":1,"b":2,"c":3})") + ',' + feature(R"({"c":4})") + ',' + feature("null")),
             {false, {"c", "a"}});
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(features->carried.names, (std::vector<std::string>{"c", "a"}));
    EXPECT_EQ(members(*features, 0), R"("c":3,"a":1)");
    EXPECT_EQ(members(*features, 1), R"("c":4)");
    EXPECT_EQ(members(*features, 2), "");
}

TEST(FeatureList, ListsAllPropertiesOnce) {
    const auto features = list(collection(feature(R"({"a":1,"b":2})") + ',' + feature(R"({"c":3,"a":4})")));
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(features->carried.names, (std::vector<std::string>{"a", "b", "c"}));
    EXPECT_EQ(members(*features, 1), R"("a":4,"c":3)");
}

TEST(FeatureList, RenamesPropertiesWithReservedNames) {
    const auto features = list(collection(feature(R"({"class":1,"class_":2,"x":3,"name":4})")));
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(features->carried.names, (std::vector<std::string>{"class__", "class_", "x_", "name"}));
}

TEST(FeatureList, ReadsIds) {
    const auto features = list(collection(feature("null", R"(,"id":"a\"b")") + ',' + feature("null", R"(,"id":12)") +
                                          ',' + feature("null", R"(,"id":[1])") + ',' + feature("null")));
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(features->ids, (std::vector<std::string>{R"("a\"b")", "12", "", ""}));
    EXPECT_EQ(features->pointer_to(2), "/geometry/features/2");
}

TEST(FeatureList, AcceptsASingleFeature) {
    const auto features = list(feature(R"({"a":1})", R"(,"id":3)"));
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(features->ids, (std::vector<std::string>{"3"}));
    EXPECT_EQ(members(*features, 0), R"("a":1)");
    EXPECT_EQ(features->pointer_to(0), "/geometry");
}

TEST(FeatureList, RefusesAChosenPropertyThatNoFeatureHas) {
    const auto features = list(collection(feature(R"({"a":1})")), {false, {"a", "nmae"}});
    ASSERT_FALSE(features);
    EXPECT_EQ(features.error().code, ErrorCode::Malformed);
    EXPECT_EQ(features.error().field, "/properties");
    EXPECT_EQ(features.error().message, "no feature has the property 'nmae'; the properties of the features are a");
}

TEST(FeatureList, RefusesPropertiesThatAreNotAnObject) {
    const auto features = list(collection(feature("null") + ',' + feature("[]")));
    ASSERT_FALSE(features);
    EXPECT_EQ(features.error().field, "/geometry/features/1/properties");
}

TEST(FeatureList, RefusesTooManyProperties) {
    std::string many = "{\"p0\":0";
    for (std::size_t i = 1; i < PropertyChoice::kMax; ++i) many += ",\"p" + std::to_string(i) + "\":0";
    ASSERT_TRUE(list(collection(feature(many + '}'))));
    const auto features = list(collection(feature(many + '}') + ',' + feature(R"({"one more":0})")));
    ASSERT_FALSE(features);
    EXPECT_EQ(features.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(features.error().field, "/properties");
}

TEST(FeatureList, RefusesPropertiesThatAreTooLarge) {
    const auto of_size = [](std::size_t size) {
        return collection(feature("{\"a\":\"" + std::string(size - 1, 'x') + "\"}"));
    };
    EXPECT_TRUE(list(of_size(CarriedProperties::kMaxOfFeature)));
    const auto features = list(of_size(CarriedProperties::kMaxOfFeature + 1));
    ASSERT_FALSE(features);
    EXPECT_EQ(features.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(features.error().field, "/geometry/features/0/properties");
}

TEST(FeatureList, LimitsTheTotalSizeOfProperties) {
    const auto features = list(collection(feature("{\"a\":\"" + std::string(9'995, 'x') + "\"}")));
    ASSERT_TRUE(features);
    EXPECT_EQ(features->carried.size_of(0), 10'000U);
    EXPECT_TRUE(check_size(features->carried, {100'000}, "/properties"));
    const auto checked = check_size(features->carried, {110'000}, "/properties");
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, ErrorCode::LimitExceeded);
}

TEST(FeatureList, NamesThePropertiesThatExist) {
    const std::string two = collection(feature(R"({"POP2020":1,"name":"a"})") + ',' + feature(R"({"area":null})"));
    const auto message = [&](const std::string& name) {
        const auto features = list(two, {.all = false, .names = {name}});
        return features ? std::string() : features.error().message;
    };
    EXPECT_EQ(message("area"), "");
    EXPECT_EQ(message("pop2021"),
              "no feature has the property 'pop2021'; did you mean 'POP2020'? The properties of the "
              "features are POP2020, name, area");
    EXPECT_EQ(message("height"),
              "no feature has the property 'height'; the properties of the features are POP2020, name, area");
    const auto none = list(collection(feature("null")), {.all = false, .names = {"a"}});
    EXPECT_EQ(none.error().message, "no feature has the property 'a'; the features have no properties");
}

TEST(FeatureList, RefusesPropertiesThatCouldNotBeRead) {
    const std::string map = R"({"type":"FeatureCollection","unreadable":{"name":"no encoding"},"features":[)" +
                            feature(R"({"n":1})") + "]}";
    EXPECT_TRUE(list(map, {.all = false, .names = {"n"}}));
    for (const PropertyChoice& choice :
         {PropertyChoice{.all = true, .names = {}}, {.all = false, .names = {"n", "name"}}}) {
        const auto features = list(map, choice);
        ASSERT_FALSE(features);
        EXPECT_EQ(features.error().code, ErrorCode::Unusable);
        EXPECT_EQ(features.error().message, "no encoding");
        EXPECT_EQ(features.error().field, "/properties");
    }
}

TEST(FeatureList, KeepsAllDigitsOfIntegers) {
    const auto features = list(collection(feature(R"({"id":9007199254740993})", R"(,"id":-9007199254740993)")));
    ASSERT_TRUE(features) << features.error().message;
    EXPECT_EQ(members(*features, 0), R"("id":9007199254740993)");
    EXPECT_EQ(features->ids.front(), "-9007199254740993");
}

}  // namespace
}  // namespace ccdt::api
