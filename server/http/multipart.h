// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/http.h"

namespace ccdt::server {

/// A field of a form: its name, and the position of its content in the body.
struct FormPart {
    std::string name;
    std::size_t begin = 0;
    std::size_t size = 0;
    bool is_file = false;  ///< whether the field has a file name

    std::string_view content(std::string_view body) const { return body.substr(begin, size); }
};

/// Finds the parts of a multipart/form-data body. Copies only the names.
///
/// Problems (400): no boundary in the content type, or one that RFC 2046 does not allow; a part without a name or with
/// several names; a part whose headers exceed 16 KiB; more than 1,000 parts; a body that ends before its last boundary;
/// a boundary without a line end after it. O(n) for any body and boundary.
HttpResult<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view content_type);

}  // namespace ccdt::server
