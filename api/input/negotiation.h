// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "api/input/file_formats.h"
#include "api/input/option_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Finds a format by name.
/// @param offered  formats that the endpoint writes
/// @returns        index of the format
/// Errors: Malformed for any other name; the message lists the formats.
Result<std::size_t> read_format(const Input& input, std::span<const FileFormat* const> offered);

/// Finds the format that the suffix of a file's name stands for. A suffix is the extension or the name of a format, in
/// lower or upper case, or `.tif`, `.nc`, `.ngc` or `.gc`.
/// @param suffix   with the dot; empty if the name has no suffix
/// @param offered  formats that the endpoint writes; the first one with the suffix is chosen
/// @returns        index of the format
/// Errors: Malformed for any other suffix; the message lists the extensions.
Result<std::size_t> format_of_suffix(std::string_view suffix, std::span<const FileFormat* const> offered);

/// Returns the file formats of the rows of a table.
template <class Row>
std::vector<const FileFormat*> files_of(std::span<const Row* const> rows) {
    std::vector<const FileFormat*> files;
    for (const Row* row : rows) files.push_back(&row->file);
    return files;
}

/// Finds a row of an endpoint's table of formats by name.
/// @param offered  rows with a member `file`
template <class Row>
Result<const Row*> read_format(const Input& input, std::span<const Row* const> offered) {
    return read_format(input, files_of(offered)).map([&](std::size_t i) { return offered[i]; });
}

/// Chooses the format that a client prefers according to its Accept header (RFC 9110, 12.5.1).
///
/// @param offered  formats in the server's order of preference, which decides between formats of equal quality value
/// @returns        index of the format; 0 if the header is missing, empty or has no valid media range
/// If several media ranges match a format, the most specific one counts. Parameters of media types are not compared.
/// Errors: NotAcceptable if the client accepts none of the formats; the message lists the media types.
Result<std::size_t> negotiate(std::string_view accept, std::span<const FileFormat* const> offered);

/// Chooses the format of an answer from an endpoint's table, by the option `format` or else by the Accept header.
///
/// @param offered  rows with a member `file`, in the server's order of preference
/// @param format   in: the format that the option `format` names, or null if the option was not given; out: the chosen
///                 format
/// Errors: those of negotiate().
template <class Row>
Result<void> settle_format(std::string_view accept, std::span<const Row* const> offered, const Row*& format) {
    if (format != nullptr) return {};
    const auto chosen = negotiate(accept, files_of(offered));
    return assign(format, chosen.map([&](std::size_t i) { return offered[i]; }));
}

}  // namespace ccdt::api
