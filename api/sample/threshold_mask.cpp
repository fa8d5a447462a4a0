// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/threshold_mask.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/image/png_writer.h"
#include "api/run/deadline.h"
#include "api/run/stopwatch.h"
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

Result<void> check_mask(const Rectangle* domain, const std::string& format_field) {
    if (domain == nullptr || !domain->periodic)
        return refused("needs a domain of the type torus, whose sides give its size in pixels", format_field);
    for (const auto& [side, field] : {std::pair{domain->width, "/domain/width"}, {domain->height, "/domain/height"}}) {
        if (is_side(side)) continue;
        return refused("must have " + std::to_string(kMinMaskSide) + " to " + std::to_string(kMaxMaskSide) +
                           " pixels on each side, so the sides of the domain must be integers in this range",
                       field);
    }
    return {};
}

Result<Answer> run_mask(const ThresholdMask& mask, const Control& control, Timings& timings) {
    Stopwatch watch;
    const int width = static_cast<int>(mask.torus.width), height = static_cast<int>(mask.torus.height);
    const auto ranks = threshold_mask(width, height, 1, mask.seed, control.stop);
    timings.optimise = watch.lap();
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());

    std::vector<std::uint16_t> greys;
    greys.reserve(ranks.size());
    for (const std::uint64_t rank : ranks)
        greys.push_back(static_cast<std::uint16_t>((rank << mask.format->bits) / ranks.size()));
    auto body = write_greys(greys, width, height, mask.format->bits, control.stop);
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    Answer answer;
    answer.media_type = mask.format->file.content_type();
    answer.body = *std::move(body);
    return answer;
}

Estimate cost_of_mask(const ThresholdMask& mask) {
    constexpr Estimate kPixel{64, 3 * kMicrosecond};
    return kPixel * (mask.torus.width * mask.torus.height);
}

}  // namespace ccdt::api
