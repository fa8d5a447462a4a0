// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>
#include <string>

#include "ccdt/abi.h"

namespace ccdt::v2 {

/// Kinds of failure.
enum class FailureCode {
    Malformed,      ///< a value lies outside its documented range, or the input cannot be read
    Unusable,       ///< well formed, but without a usable result: crossing edges, a broken picture, nothing to draw
    LimitExceeded,  ///< larger than a limit, which the message names
    NotAcceptable,  ///< none of the requested formats is available
    Unsupported,    ///< the format of the input is not supported
    Unavailable,    ///< impossible at present, for lack of resources; may succeed later
    Stopped,        ///< ended by the caller's stop token before there was a result
    Internal,       ///< a bug in this library
};

/// Reports the failure of any function of this library. If memory runs out, a function may throw std::bad_alloc.
class CCDT_EXPORT Exception : public std::runtime_error {
public:
    Exception(FailureCode code, const std::string& message, std::string field);
    ~Exception() override;

    FailureCode code() const noexcept { return code_; }

    /// Returns the part of the input that the failure is about: the name of a parameter or option, or a path below it,
    /// such as `density/values/7`, or a JSON Pointer. Empty if the failure is not about a part of the input.
    const std::string& field() const noexcept { return field_; }

private:
    FailureCode code_;
    std::string field_;
};

}  // namespace ccdt::v2
