#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "api/input/file_formats.h"
#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Picks a format by name.
/// @param made  what this endpoint makes
/// @returns     its index
/// Errors: Malformed for any other, naming those that are made.
Result<std::size_t> read_format(const Input& input, std::span<const FileFormat* const> made);

template <class Row>
std::vector<const FileFormat*> files_of(std::span<const Row* const> rows) {
    std::vector<const FileFormat*> files;
    for (const Row* row : rows) files.push_back(&row->file);
    return files;
}

/// Picks a row of an endpoint's table of formats by name.
/// @param made  rows with a member `file`
template <class Row>
Result<const Row*> read_format(const Input& input, std::span<const Row* const> made) {
    return read_format(input, files_of(made)).map([&](std::size_t i) { return made[i]; });
}

/// Picks the format a client likes best by its Accept header (RFC 9110, 12.5.1).
///
/// @param made  in the server's order of preference, which decides between equals
/// @returns     its index; the first if the header is missing, empty or says nothing that can be understood
/// Of the media ranges that match a format the most specific one counts; their parameters are not compared.
/// Errors: NotAcceptable if all are refused, naming them.
Result<std::size_t> negotiate(std::string_view accept, std::span<const FileFormat* const> made);

/// Settles in which format of an endpoint's table an answer is made: by the option `format` if it is given, else by the
/// Accept header.
///
/// @param made    rows with a member `file`, in the server's order of preference
/// @param format  what read_format gave; null if it was not asked
/// Errors: as above.
template <class Row>
Result<void> settle_format(std::string_view accept, std::span<const Row* const> made, const Row*& format) {
    if (format != nullptr) return {};
    const auto chosen = negotiate(accept, files_of(made));
    return assign(format, chosen.map([&](std::size_t i) { return made[i]; }));
}

}  // namespace ccdt::api
