// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/run/options.h"
#include "core/base/result.h"
#include "server/cli/option.h"

namespace ccdt::server {

/// Largest value of `--max-faces`.
inline constexpr std::size_t kMaxFaces = 100'000'000;

/// The arguments of a command that computes answers.
struct Arguments {
    /// An option of the API, and its value.
    struct Given {
        const Option* option;
        std::string value;       ///< `true` or `false` for a flag; a number in thousands is written out
        std::string typed = {};  ///< the value on the command line, for messages
    };

    std::vector<Given> given;
    std::vector<std::string> inputs;  ///< names of files; `-` is standard input
    std::optional<std::string> output;
    bool quiet = false;
    bool json = false;  ///< whether messages are JSON
    bool help = false;
    std::size_t threads = 1;
    std::size_t memory = 0;  ///< bytes
    api::Limits limits;

    /// Finds an option; null if it is not given.
    const Given* find_given(std::string_view name) const;

    /// Returns the value of an option; null if the option is not given.
    const std::string* find(std::string_view name) const;
};

/// Reads the arguments after the name of a command.
///
/// Options have the forms `--name value`, `--name=value`, `--flag` and `--no-flag`. An option with a letter also has
/// the forms `-o value`, `-ovalue` and `-o=value`. Underscores in names are the same as hyphens. Options and inputs may
/// be mixed. After `--`, all arguments are inputs. The values of options of the API are not checked.
/// @param options  options of the command; must outlive the result
/// Errors: Malformed for an unknown or repeated option, a missing value, and a wrong value of an option of the program.
/// Error::field is the option as it was written.
Result<Arguments> parse_arguments(std::span<const Option> options, std::span<const char* const> arguments);

}  // namespace ccdt::server
