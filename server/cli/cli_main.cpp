// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include <unistd.h>

#include "server/cli/command.h"
#include "server/cli/completion.h"
#include "server/cli/console.h"
#include "server/cli/help.h"
#include "server/cli/run.h"
#include "server/processes/child_program.h"

namespace ccdt::server {
namespace {

int refuse(const std::string& message) {
    std::fprintf(stderr, "ccdt: %s\n", message.c_str());
    return kWrongUsage;
}

/// Replaces this program by ccdt-server.
/// @param arguments  null-terminated; the first one is `serve`, instead of the program's name
int serve(const char** arguments) {
    const std::string name = "ccdt-server";
    arguments[0] = name.c_str();
    char* const* const argv = const_cast<char* const*>(arguments);
    if (const auto file = find_program(name)) execv(file->c_str(), argv);
    execvp(name.c_str(), argv);
    std::fprintf(stderr, "ccdt: cannot start %s: %s; the program is in the package %s\n", name.c_str(),
                 std::strerror(errno), name.c_str());
    return kFailed;
}

int unknown_command(const std::string& name) {
    std::error_code error;
    const bool is_file = std::filesystem::exists(name, error);
    return refuse(
        name + " is not a command; " +
        (is_file ? "ccdt halftone " + name + " turns a picture into dots" : "ccdt --help lists the commands"));
}

bool is_other_command(std::string_view name) {
    return std::ranges::find(other_commands(), name, &OtherCommand::name) != other_commands().end();
}

/// Prints the help or the manual page of the command that the only argument names, or of the program. The program's
/// help and manual page also describe the commands that compute nothing.
int describe(std::span<const char* const> arguments, std::string (*of_program)(),
             std::string (*of_command)(const Command&)) {
    if (arguments.empty()) return print(of_program());
    if (arguments.size() > 1)
        return refuse("one command can be described at a time, not " + std::to_string(arguments.size()));
    const std::string_view name = arguments.front();
    if (const Command* const command = find_command(name)) return print(of_command(*command));
    return is_other_command(name) ? print(of_program()) : unknown_command(std::string(name));
}

int complete(std::span<const char* const> arguments) {
    const auto script = arguments.size() == 1 ? completion_script(arguments.front()) : std::nullopt;
    return script ? print(*script) : refuse("completion needs the name of a shell: bash, zsh or fish");
}

int run(std::span<const char*> arguments) {
    const auto help = [] { return program_help(terminal_width()); };
    if (arguments.empty()) {
        std::fputs(help().c_str(), stderr);
        return kWrongUsage;
    }
    const std::string_view name = arguments.front();
    const auto rest = arguments.subspan(1);
    if (const Command* const command = find_command(name)) return run_command(*command, rest);
    if (name == "serve") return serve(arguments.data());
    if (is_other_command(name) && rest.size() == 1 &&
        (rest.front() == std::string_view("--help") || rest.front() == std::string_view("-h")))
        return print(help());
    if (name == "completion") return complete(rest);
    if (name == "manual") return describe(rest, program_manual, command_manual);
    if (name == "help" || name == "--help" || name == "-h")
        return describe(rest, help, [](const Command& command) { return command_help(command, terminal_width()); });
    if (name == "--version") return print("ccdt " CCDT_VERSION "\n");
    return unknown_command(std::string(name));
}

}  // namespace
}  // namespace ccdt::server

int main(int argc, char** argv) {
    try {
        return ccdt::server::run(std::span(const_cast<const char**>(argv), static_cast<std::size_t>(argc)).subspan(1));
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "ccdt: %s\n", exception.what());
        return ccdt::server::kFailed;
    }
}
