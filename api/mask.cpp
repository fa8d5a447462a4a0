// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/mask.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/image/png_writer.h"
#include "api/run/deadline.h"
#include "api/run/stopwatch.h"
#include "api/sample.h"
#include "core/order/threshold_mask.h"

namespace ccdt::api {
namespace {

constexpr MaskFormat kMask{{"mask", "Mask, 8 bits", "png", "image/png", ""}, 8};
constexpr MaskFormat kMask16{{"mask16", "Mask, 16 bits", "png", "image/png", ""}, 16};
constexpr const MaskFormat* kMaskFormats[] = {&kMask, &kMask16};

bool is_side(double side) {
    return side >= kMinMaskSide && side <= kMaxMaskSide && side == std::floor(side);
}

Result<void> refused(const std::string& what, const std::string& field) {
    return failure(ErrorCode::Malformed, "a mask " + what, field);
}

}  // namespace

std::span<const MaskFormat* const> mask_formats() {
    return kMaskFormats;
}

Result<void> check_mask(const SampleRequest& request) {
    const auto* torus = std::get_if<Rectangle>(&request.domain);
    if (torus == nullptr || !torus->periodic)
        return refused("needs a domain of the type torus, whose sides give its size in pixels",
                       request.field_of("format"));
    for (const auto& [side, field] : {std::pair{torus->width, "/domain/width"}, {torus->height, "/domain/height"}}) {
        if (is_side(side)) continue;
        return refused("must have " + std::to_string(kMinMaskSide) + " to " + std::to_string(kMaxMaskSide) +
                           " pixels on each side, so the sides of the domain must be integers in this range",
                       field);
    }
    return {};
}

Result<Answer> run_mask(const SampleRequest& request, const Control& control, Timings& timings) {
    Stopwatch watch;
    const auto& torus = std::get<Rectangle>(request.domain);
    const int width = static_cast<int>(torus.width), height = static_cast<int>(torus.height);
    const auto ranks = threshold_mask(width, height, request.run.seed, control.stop);
    timings.optimise = watch.lap();
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());

    std::vector<std::uint16_t> greys;
    greys.reserve(ranks.size());
    for (const std::uint64_t rank : ranks)
        greys.push_back(static_cast<std::uint16_t>((rank << request.mask_format->bits) / ranks.size()));
    auto body = write_greys(greys, width, height, request.mask_format->bits, control.stop);
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    Answer answer;
    answer.media_type = request.mask_format->file.content_type();
    answer.body = *std::move(body);
    return answer;
}

Estimate cost_of_mask(const SampleRequest& request) {
    constexpr Estimate kPixel{64, 3 * kMicrosecond};
    const auto& torus = std::get<Rectangle>(request.domain);
    return kPixel * (torus.width * torus.height);
}

}  // namespace ccdt::api
