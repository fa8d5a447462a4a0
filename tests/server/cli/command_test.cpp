// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/command.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "api/analyze/analyze.h"
#include "server/cli/completion.h"
#include "server/cli/help.h"

namespace ccdt::server {
namespace {

const Option& find_option(const std::vector<Option>& options, std::string_view name) {
    const auto found = std::ranges::find(options, name, &Option::name);
    if (found == options.end()) throw std::invalid_argument(std::string(name));
    return *found;
}

TEST(Command, TakesItsOptionsFromTheDescriptionOfTheApi) {
    const auto halftone = options_of(*find_command("halftone"));
    const Option& detail = find_option(halftone, "detail");
    EXPECT_EQ(detail.allowed, "from 0 to 1");
    EXPECT_EQ(detail.default_value, "0.7");
    EXPECT_EQ(find_option(halftone, "fit").value, "contain|cover");
    EXPECT_TRUE(find_option(halftone, "antialias").is_flag());
    EXPECT_FALSE(find_option(halftone, "device").takes_text);
    const auto& formats = find_option(halftone, "format").words;
    for (const char* const format : {"png", "dxf", "escpos"})
        EXPECT_NE(std::ranges::find(formats, format), formats.end()) << format;
    EXPECT_EQ(find_option(halftone, "sites").allowed, "from 1 to --max-sites");

    const auto sample = options_of(*find_command("sample"));
    const Option& sites = find_option(sample, "sites");
    EXPECT_TRUE(sites.takes_number && sites.takes_text && sites.takes_json);
    EXPECT_FALSE(sites.in_body);
    for (const char* const member : {"domain", "density", "calibration"}) {
        EXPECT_TRUE(find_option(sample, member).is_json()) << member;
        EXPECT_TRUE(find_option(sample, member).in_body) << member;
    }
    EXPECT_EQ(find_option(options_of(*find_command("analyze")), "max-frequency").member, "max_frequency");
}

TEST(Command, HasAllOptionsOfAnalyses) {
    const auto options = options_of(*find_command("analyze"));
    std::set<std::string_view> members;
    for (const Option& option : options) members.insert(option.member);
    for (const auto name : api::analyze_options()) {
        EXPECT_EQ(members.contains(name), name != "points") << name;  // the input gives the points
    }
}

TEST(Command, GroupsAllOptionsBySubject) {
    for (const Command& command : commands()) {
        const auto options = options_of(command);
        std::size_t count = 0;
        for (const auto& [title, members] : group_options(options)) {
            EXPECT_NE(title, "Other options") << members.front()->name;
            EXPECT_FALSE(members.empty());
            count += members.size();
        }
        EXPECT_EQ(count, options.size());
    }
}

TEST(Command, NamesOptionsOnlyOnce) {
    for (const Command& command : commands()) {
        std::set<std::string> names;
        for (const Option& option : options_of(command)) EXPECT_TRUE(names.insert(option.name).second) << option.name;
    }
}

TEST(Help, DescribesEveryOptionWithinTheWidth) {
    constexpr std::size_t kWidth = 60;
    const Command& command = *find_command("sample");
    const std::string help = command_help(command, kWidth);
    for (const Option& option : options_of(command))
        EXPECT_NE(help.find((option.default_value == "true" ? "--[no-]" : "--") + option.name), std::string::npos)
            << option.name;
    std::size_t begin = help.find("Area:");
    const std::size_t end = help.find("\nExamples:");
    while (begin < end) {
        const std::size_t line = help.find('\n', begin);
        const std::string text = help.substr(begin, line - begin);
        EXPECT_TRUE(text.size() <= kWidth || !text.starts_with("        ")) << text;
        begin = line + 1;
    }
}

TEST(Help, ListsCommandsInAColumn) {
    const std::string help = program_help(80);
    for (const OtherCommand& command : other_commands()) {
        const auto name = help.find("\n  " + std::string(command.name) + "  ");
        ASSERT_NE(name, std::string::npos) << command.name;
        EXPECT_EQ(help.substr(name + 15, 4), command.summary.substr(0, 4)) << command.name;
    }
}

TEST(Help, WrapsAtBlanks) {
    EXPECT_EQ(wrapped("one two three", 2, 9), "  one two\n  three\n");
    EXPECT_EQ(wrapped("a incomprehensibilities b", 0, 5), "a\nincomprehensibilities\nb\n");
    EXPECT_EQ(first_sentence("Inks. gray: one."), "Inks");
    EXPECT_EQ(first_sentence("One of 0.5 and 1."), "One of 0.5 and 1");
}

TEST(Manual, ContainsEveryOptionAndExitStatus) {
    for (const Command& command : commands()) {
        const std::string page = command_manual(command);
        for (const Option& option : options_of(command)) {
            std::string name = option.name;
            for (std::size_t at = 0; (at = name.find('-', at)) != std::string::npos; at += 2) name.insert(at, 1, '\\');
            EXPECT_NE(page.find(name), std::string::npos) << option.name;
        }
        for (const auto& [value, meaning] : exit_statuses())
            EXPECT_NE(page.find(".B \"" + std::string(value)), std::string::npos) << value;
    }
}

TEST(Completion, KnowsThreeShells) {
    for (const char* const shell : {"bash", "zsh", "fish"}) {
        const auto script = completion_script(shell);
        ASSERT_TRUE(script);
        for (const char* const word : {"halftone", "max-frequency", "spectra6", "completion"})
            EXPECT_NE(script->find(word), std::string::npos) << shell << ' ' << word;
    }
    EXPECT_FALSE(completion_script("csh"));
}

TEST(Completion, OffersFilesForOptionsThatTakeThem) {
    EXPECT_NE(completion_script("bash")->find("--mesh|--output|-o) return ;;"), std::string::npos);
    EXPECT_NE(completion_script("zsh")->find("]:mesh:_files'"), std::string::npos);
    EXPECT_NE(completion_script("fish")->find(" -l mesh -r -F "), std::string::npos);
}

TEST(Help, ListsTheMeshOfPointsAsAnArea) {
    const auto group_of_mesh = [](std::string_view command) {
        const std::vector<Option> options = options_of(*find_command(command));
        for (const auto& [title, members] : group_options(options)) {
            if (std::ranges::find(members, "mesh", &Option::name) != members.end()) return title;
        }
        return std::string_view();
    };
    EXPECT_EQ(group_of_mesh("analyze"), "Area");
    EXPECT_EQ(group_of_mesh("sample"), "Placement");
}

}  // namespace
}  // namespace ccdt::server
