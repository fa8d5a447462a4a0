// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/operation/parsed_request.h"
#include "core/base/result.h"
#include "server/cli/arguments.h"
#include "server/cli/command.h"

namespace ccdt::server {

/// A request to the API in the form in which the service would receive it.
struct ApiRequest {
    std::string body;
    std::vector<api::TextOption> options;  ///< options as text, in addition to those of the body
};

/// Builds the request for an input.
///
/// Options become query parameters if the service accepts them beside this input, and otherwise members of a JSON body.
/// @param input  content of the input file; null: there is none
/// Errors: Malformed for a value that begins like JSON and is not JSON, with the member as Error::field, and for a file
/// of points that cannot be read; LimitExceeded for too many points.
Result<ApiRequest> build_request(const Command& command, const Arguments& arguments, const std::string* input);

/// Adds the format of the output to a JSON body of options, unless the body names a format with the same extension, and
/// for several outputs a file for each ink, unless the body has `split`.
/// @param is_split  whether the output can be several files
/// @returns         false if the input is no such body, which leaves it unchanged
/// Errors: Malformed if the body names a format with another extension, with `format` as Error::field; or if it has
/// `split` and the output is one file, with `output`.
Result<bool> set_output(const Command& command, const api::FileFormat& format, bool is_split, std::string& input);

/// Estimates the memory for parsing an input, in bytes.
std::size_t parsing_memory(std::string_view input);

/// Parses a request. The result may point into it.
Result<api::ParsedPointer> parse_request(const Command& command, const ApiRequest& request, const api::Limits& limits);

/// Replaces each value `@FILE` of an option that takes JSON by the content of the file. A file that is neither JSON nor
/// voxels becomes an object with the member `image`, in base64. A TIFF has voxels if `domain` is in space. Also
/// replaces the file of the mesh on which points are analysed. Errors: those of read_file(), with the member as
/// Error::field and the name of the file in the message.
Result<void> read_value_files(Arguments& arguments);

/// Checks the first bytes of a large input, so that a file of no known format, which may have no end, is not read.
/// A file of a known kind passes even if the command does not read it, because the error of the parser names the kind
/// and what is accepted. Errors: those of recognise_image() for pictures; otherwise Unsupported.
Result<void> check_head(const Command& command, std::string_view head);

/// Finds the format of an output. The option `format` names it, or else the suffix of the file's name chooses it.
/// Without either, it is the default.
/// @param output  name of the file; `-` for standard output
/// Errors: Malformed for an unknown suffix; the message lists the suffixes.
Result<const api::FileFormat*> find_format(const Command& command, const Arguments& arguments,
                                           const std::string& output);

/// Whether a format consists of text, which a terminal can show.
bool is_text(const api::FileFormat& format);

/// Text of an error for users, and the option to which it refers.
struct DescribedError {
    std::string option;  ///< such as `--max-frequency`; empty: the error is about the input
    std::string message;
};

/// Describes an error of the API: names options instead of members, and flags of the program instead of limits.
DescribedError describe_error(const Error& error, std::span<const Option> options);

}  // namespace ccdt::server
