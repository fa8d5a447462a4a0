// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/halftone_checks.h"
#include "tests/support/halftone_requests.h"

/// Parses a request to /halftone with a JSON body. The input is a line with the query, then the body.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    auto body = fuzz::text_of(data, size);
    const auto options = server::parse_query(fuzz::take_line(body));
    const auto request = api::parse_halftone_json(body, options, {}, fuzz::kHalftoneLimits);
    if (request) {
        fuzz::check_request(*request);
        CCDT_CHECK(request->image_field == "/image");
    } else if (request.error().field.starts_with('/') && options.empty()) {
        fuzz::check_error(request.error(), body);
    } else if (!request.error().field.starts_with('/')) {
        fuzz::check_error(request.error(), options);
    } else {
        fuzz::check_error(request.error());
    }
    return 0;
}
