#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// What an answer can be made as.
struct Format {
    std::string_view name;             ///< of the option `format`
    std::string_view media_type;       ///< in Accept and Content-Type
    std::string_view parameters = {};  ///< after it in Content-Type

    std::string content_type() const { return std::string(media_type) += parameters; }
};

/// Picks a format by name.
/// @param made  what this endpoint makes
/// @returns     its index
/// Errors: Malformed for any other, naming those that are made.
Result<std::size_t> read_format(const Input& input, std::span<const Format> made);

/// Picks the format a client likes best by its Accept header (RFC 9110, 12.5.1).
///
/// @param made  in the server's order of preference, which decides between equals
/// @returns     its index; the first if the header is missing, empty or says nothing that can be understood
/// Of the media ranges that match a format the most specific one counts; their parameters are not compared.
/// Errors: NotAcceptable if all are refused, naming them.
Result<std::size_t> negotiate(std::string_view accept, std::span<const Format> made);

}  // namespace ccdt::api
