// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace ccdt {

/// Kinds of failure, independent of any protocol. api maps each to an HTTP status.
enum class ErrorCode {
    Malformed,      ///< the input cannot be read, or a value lies outside its documented range
    Unusable,       ///< well formed, but without a usable result: crossing edges, broken image, no ink
    LimitExceeded,  ///< larger than a configured limit, which the message names
    NotAcceptable,  ///< none of the requested formats is available
    Unsupported,    ///< the format of the input is not supported
    Unavailable,    ///< impossible at present, for lack of processes or time; may succeed later
    Stopped,        ///< ended by the caller's stop token before there was a result
    Internal,       ///< a bug in this project
};

struct Error {
    ErrorCode code = ErrorCode::Internal;
    std::string message;             ///< readable text; names the limit, if any
    std::string field;               ///< an option's name or a JSON Pointer that identifies the input; may be empty
    std::vector<Error> others = {};  ///< further errors in the same input; `others` of each is empty
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(ErrorCode code, std::string message, std::string field = {}) {
    return tl::unexpected<Error>(Error{code, std::move(message), std::move(field)});
}

}  // namespace ccdt
