// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/halftone_input.h"

#include <utility>

#include "api/image/embedded_image.h"

namespace ccdt::api {

HalftoneInput read_halftone(std::string_view image, const std::vector<TextOption>& options, const Limits& limits) {
    const auto with_bytes = [&](const ImageHeader& header) { return ImageFile{image, header, nullptr}; };
    return read_halftone(read_image_header(image, limits.max_pixels).map(with_bytes), options);
}

HalftoneInput read_halftone(Result<ImageFile> image, const std::vector<TextOption>& options) {
    return {nullptr, inputs_of(options), std::move(image), ""};
}

Result<HalftoneInput> read_halftone_json(std::string_view body, const std::vector<TextOption>& options,
                                         const Limits& limits) {
    auto document = JsonDocument::parse(body);
    if (!document) return tl::unexpected(document.error());
    HalftoneInput input{std::make_unique<const JsonDocument>(*std::move(document)),
                        {},
                        failure(ErrorCode::Malformed, "image is missing", "/image"),
                        "/image"};
    auto members = inputs_of(input.document->root(), "");
    if (!members) return tl::unexpected(members.error());
    if (const auto image = std::ranges::find(*members, "image", &Input::name); image != members->end()) {
        input.image = read_embedded_image(*image, limits);
        members->erase(image);
    }
    for (auto& option : inputs_of(options)) members->push_back(std::move(option));
    input.options = *std::move(members);
    return input;
}

}  // namespace ccdt::api
