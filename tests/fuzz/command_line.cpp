// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <string>
#include <vector>

#include "server/config/config.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

using std::chrono::milliseconds;

/// Removes the lines up to the first empty line from a text. Returns them without the empty line.
std::vector<std::string> take_lines(std::string_view& text) {
    std::vector<std::string> lines;
    while (!text.empty()) {
        const auto line = take_line(text);
        if (line.empty()) break;
        lines.emplace_back(line.substr(0, line.find('\0')));
    }
    return lines;
}

void check_duration(milliseconds duration) {
    CCDT_CHECK(duration >= milliseconds(1) && duration <= std::chrono::hours(24));
}

void check_config(const server::Config& config) {
    CCDT_CHECK(!config.bind.empty() && config.port >= 0 && config.port <= 65'535);
    CCDT_CHECK(config.workers >= 1 && config.workers <= 1024);
    CCDT_CHECK(config.max_body >= 1 && config.memory >= 1);
    CCDT_CHECK(config.limits.max_sites >= 1 && config.limits.max_pixels >= 1);
    for (const auto duration :
         {config.timeout, config.drain_timeout, config.patience.header, config.patience.body, config.patience.idle})
        check_duration(duration);
    CCDT_CHECK(config.capacity.connections >= 1 && config.capacity.bytes <= config.memory);
    CCDT_CHECK(config.live.rate.per_second >= 0 && std::isfinite(config.live.rate.per_second) &&
               config.live.rate.burst >= 1);
    for (const auto& origin : config.live.cors_origins) {
        CCDT_CHECK(!origin.empty());
        for (const char c : origin) CCDT_CHECK(c > ' ' && c < 0x7f && c != ',');
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses arguments, variables and a file of settings. The input has a line for each argument, an empty line, lines
/// NAME=value, an empty line, and the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    auto text = fuzz::text_of(data, size);
    const auto lines = fuzz::take_lines(text);
    const auto variables = fuzz::take_lines(text);
    std::vector<const char*> arguments;
    for (const auto& line : lines) arguments.push_back(line.c_str());
    std::vector<const char*> environment;
    for (const auto& variable : variables) environment.push_back(variable.c_str());
    const auto parsed =
        server::parse_command_line(arguments, environment, [text](const std::string&) { return std::string(text); });
    if (!parsed) {
        fuzz::check_error(parsed.error());
    } else if (parsed->action != server::CommandLine::Action::Help &&
               parsed->action != server::CommandLine::Action::Version &&
               parsed->action != server::CommandLine::Action::Manual) {
        fuzz::check_config(parsed->config);
        server::config_file(parsed->values);
    }
    return 0;
}
