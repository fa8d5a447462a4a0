#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace ccdt {

/// Kinds of failure. They say nothing of transport; server maps each to a status.
enum class ErrorCode {
    Malformed,      ///< the input cannot be read, or a value lies outside its documented range
    Unusable,       ///< well formed, but nothing can be made of it: crossing edges, broken image, no ink
    LimitExceeded,  ///< larger than a configured limit, which the message names
    NotAcceptable,  ///< none of the formats asked for can be made
    Unsupported,    ///< the input's format is not one that is read
    Stopped,        ///< ended by the caller's stop token before there was a result
    Internal,       ///< our own fault
};

struct Error {
    ErrorCode code = ErrorCode::Internal;
    std::string message;             ///< for people; names the limit where there is one
    std::string field;               ///< what the message is about: an option's name or a JSON Pointer; may be empty
    std::vector<Error> others = {};  ///< found in the same input, after this one; these have none themselves
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(ErrorCode code, std::string message, std::string field = {}) {
    return tl::unexpected<Error>(Error{code, std::move(message), std::move(field)});
}

}  // namespace ccdt
