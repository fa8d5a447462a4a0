// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/arguments.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "server/cli/command.h"

namespace ccdt::server {
namespace {

const std::vector<Option>& halftone_options() {
    static const std::vector<Option> options = options_of(*find_command("halftone"));
    return options;
}

Result<Arguments> parse(const std::vector<const char*>& arguments) {
    return parse_arguments(halftone_options(), arguments);
}

/// Returns the value of an option, or `none`. If the arguments are wrong, returns the message of the error.
std::string value_of(const std::vector<const char*>& arguments, std::string_view name) {
    const auto parsed = parse(arguments);
    if (!parsed) return parsed.error().message;
    const std::string* const value = parsed->find(name);
    return value == nullptr ? "none" : *value;
}

TEST(Arguments, AcceptsAllFormsOfAnOption) {
    EXPECT_EQ(value_of({"--sites", "20"}, "sites"), "20");
    EXPECT_EQ(value_of({"--sites=20"}, "sites"), "20");
    EXPECT_EQ(value_of({"--width_mm", "-3"}, "width-mm"), "-3");
    EXPECT_EQ(value_of({"--width-mm="}, "width-mm"), "");
    EXPECT_EQ(value_of({"--foreground=#a=b"}, "foreground"), "#a=b");
    EXPECT_EQ(value_of({"--antialias"}, "antialias"), "true");
    EXPECT_EQ(value_of({"--no-antialias"}, "antialias"), "false");
    EXPECT_EQ(value_of({"--antialias=false"}, "antialias"), "false");
    EXPECT_EQ(value_of({"photo.jpg"}, "antialias"), "none");
}

TEST(Arguments, MixesInputsAndOptions) {
    const auto parsed = parse({"a.png", "-o", "{name}.svg", "-", "-q", "--", "--sites", "-"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->inputs, (std::vector<std::string>{"a.png", "-", "--sites", "-"}));
    EXPECT_EQ(parsed->output, "{name}.svg");
    EXPECT_TRUE(parsed->quiet);
    EXPECT_FALSE(parsed->json);
    EXPECT_EQ(parse({"-oa.png"})->output, "a.png");
    EXPECT_EQ(parse({"-o=a.png"})->output, "a.png");
}

TEST(Arguments, ReadsLimits) {
    const auto parsed = parse({"--threads=3", "--memory=2GiB", "--max-sites=7", "--max-pixels", "8", "--max-faces=9"});
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(parsed->threads, 3U);
    EXPECT_EQ(parsed->memory, std::size_t{2} << 30);
    EXPECT_EQ(parsed->limits.max_sites, 7U);
    EXPECT_EQ(parsed->limits.max_pixels, 8U);
    EXPECT_EQ(parsed->limits.max_faces, 9U);
    const auto defaults = parse({});
    EXPECT_GE(defaults->threads, 1U);
    EXPECT_GT(defaults->memory, std::size_t{100} << 20);
    EXPECT_EQ(defaults->limits.max_sites, 100'000'000U);
}

TEST(Arguments, NamesTheWrongOption) {
    struct Case {
        std::vector<const char*> arguments;
        std::string_view field, message;
    };
    const Case cases[] = {
        {{"--site", "3"}, "--site", "--site is not an option; did you mean --sites?"},
        {{"--nonsense"}, "--nonsense", "--nonsense is not an option; --help lists the options"},
        {{"-x"}, "-x", "-x is not an option"},
        {{"--no-sites"}, "--no-sites", "--no-sites is not an option"},
        {{"--on-deadline=error"}, "--on-deadline", "is not an option"},
        {{"--sites"}, "--sites", "--sites needs a value"},
        {{"--sites=3", "--sites=3"}, "--sites", "--sites is given twice"},
        {{"--invert", "--no-invert"}, "--no-invert", "--no-invert is given twice"},
        {{"--no-invert=true"}, "--no-invert", "--no-invert has no value"},
        {{"--quiet=true"}, "--quiet", "--quiet has no value"},
        {{"--output="}, "--output", "--output needs the name of a file"},
        {{"--threads=0"}, "--threads", "--threads must be a whole number from 1 to 1024, not '0'"},
        {{"--memory", "x"}, "--memory", "--memory must be a number of bytes, such as 67108864 or 64MiB, not 'x'"},
        {{"--max-sites=100000001"}, "--max-sites", "from 1 to 100000000, not '100000001'"},
        {{"--max-pixels=1000000001"}, "--max-pixels", "from 1 to 1000000000, not '1000000001'"},
        {{"--max-faces=0"}, "--max-faces", "from 1 to 100000000, not '0'"},
    };
    for (const auto& [arguments, field, message] : cases) {
        const auto parsed = parse(arguments);
        ASSERT_FALSE(parsed) << message;
        EXPECT_EQ(parsed.error().field, field);
        EXPECT_NE(parsed.error().message.find(message), std::string::npos) << parsed.error().message;
    }
}

}  // namespace
}  // namespace ccdt::server
