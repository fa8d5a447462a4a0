// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "api/image/image_header.h"
#include "api/input/option_reader.h"
#include "api/json/json_document.h"
#include "api/run/options.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Image and options of a request to /halftone, before the options are read.
struct HalftoneInput {
    std::unique_ptr<const JsonDocument> document;  ///< holds the options of a JSON body; null for other bodies
    std::vector<Input> options;
    Result<ImageFile> image;
    std::string image_field;  ///< Error::field of errors about the image; empty unless the body is JSON

    bool has(std::string_view option) const {
        return std::ranges::find(options, option, &Input::name) != options.end();
    }

    /// Returns an option that is given.
    const Input& option(std::string_view name) const { return *std::ranges::find(options, name, &Input::name); }
};

/// Reads a request whose image is the body or a part of a form. Options are given as text.
/// @param image    the file's bytes, which must outlive the result
/// @param options  options in the order of the request; their texts must outlive the result
HalftoneInput read_halftone(std::string_view image, const std::vector<TextOption>& options, const Limits& limits);

/// Reads a request for a picture whose header is known. Such a picture need not be a file: `image.bytes` is only passed
/// to the decoder. The other parameters are those of the function above.
HalftoneInput read_halftone(Result<ImageFile> image, const std::vector<TextOption>& options);

/// Reads a request whose body is a JSON object, with the member `image` in base64 or as a data: URI.
/// @param options  options in the query, in addition to the members of the object; their texts must outlive the result
/// Errors: those of JsonDocument::parse(); Malformed if the body is not an object.
Result<HalftoneInput> read_halftone_json(std::string_view body, const std::vector<TextOption>& options,
                                         const Limits& limits);

/// Adds the image to a request whose options have been read. Errors: those of `request` and of `input.image`.
template <class Request>
Result<Request> with_image(Result<Request> request, const HalftoneInput& input) {
    ErrorList errors;
    errors.add(request);
    errors.add(input.image);
    if (auto right = errors.result(); !right) return tl::unexpected(right.error());
    request->image = *input.image;
    return request;
}

}  // namespace ccdt::api
