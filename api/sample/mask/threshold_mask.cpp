// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/mask/threshold_mask.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/image/png_writer.h"
#include "api/output/npy_header.h"
#include "api/run/deadline.h"
#include "api/run/stopwatch.h"
#include "core/points/order/threshold_mask.h"

namespace ccdt::api {
namespace {

constexpr MaskFormat kMask{{"mask", "Mask, 8 bits", "png", "image/png", ""}, 8};
constexpr MaskFormat kMask16{{"mask16", "Mask, 16 bits", "png", "image/png", ""}, 16};
constexpr MaskFormat kMaskNpy{{"masknpy", "Mask, 16 bits, NPY", "npy", kNpy.media_type, ""}, 16, true};
constexpr const MaskFormat* kMaskFormats[] = {&kMask, &kMask16, &kMaskNpy};

bool is_integer(double value, int least, int most) {
    return value >= least && value <= most && value == std::floor(value);
}

Result<void> refused(const std::string& what, const std::string& field) {
    return failure(ErrorCode::Malformed, "a mask " + what, field);
}

std::string write_array(const ThresholdMask& mask, std::span<const std::uint16_t> greys) {
    std::vector<std::size_t> shape;
    if (mask.depth) shape.push_back(static_cast<std::size_t>(*mask.depth));
    for (const double side : {mask.torus.height, mask.torus.width}) shape.push_back(static_cast<std::size_t>(side));
    std::string file = npy_header("<u2", shape);
    for (const std::uint16_t grey : greys) file += {static_cast<char>(grey & 255), static_cast<char>(grey >> 8)};
    return file;
}

}  // namespace

std::span<const MaskFormat* const> mask_formats() {
    return kMaskFormats;
}

Result<void> check_mask(const Rectangle* domain, std::optional<double> depth, const std::string& format_field) {
    if (domain == nullptr || !domain->periodic)
        return refused("needs a domain of the type torus, whose sides give its size in pixels", format_field);
    for (const auto& [side, field] : {std::pair{domain->width, "/domain/width"}, {domain->height, "/domain/height"}}) {
        if (is_integer(side, kMinMaskSide, kMaxMaskSide)) continue;
        return refused("must have " + std::to_string(kMinMaskSide) + " to " + std::to_string(kMaxMaskSide) +
                           " pixels on each side, so the sides of the domain must be integers in this range",
                       field);
    }
    if (depth && !is_integer(*depth, 1, kMaxMaskDepth))
        return refused("must have 1 to " + std::to_string(kMaxMaskDepth) +
                           " frames, so the depth of the domain must be an integer in this range",
                       "/domain/depth");
    if (domain->width * domain->height * depth.value_or(1) > kMaxMaskPixels)
        return refused(
            "must have at most " + std::to_string(static_cast<int>(kMaxMaskPixels)) + " pixels in all frames",
            "/domain/depth");
    return {};
}

Result<Answer> run_mask(const ThresholdMask& mask, const Control& control, Timings& timings) {
    Stopwatch watch;
    const int width = static_cast<int>(mask.torus.width), height = static_cast<int>(mask.torus.height);
    const int depth = static_cast<int>(mask.depth.value_or(1));
    const auto ranks = threshold_mask(width, height, depth, mask.seed, control.stop, *control.executor);
    timings.optimise = watch.lap();
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());

    std::vector<std::uint16_t> greys;
    greys.reserve(ranks.size());
    const std::size_t frame = ranks.size() / static_cast<std::size_t>(depth);
    for (const std::uint64_t rank : ranks)
        greys.push_back(static_cast<std::uint16_t>((rank << mask.format->bits) / frame));
    auto body = mask.format->is_array ? Result<std::string>(write_array(mask, greys))
                                      : write_greys(greys, width, height * depth, mask.format->bits, control.stop);
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    Answer answer;
    answer.media_type = mask.format->file.content_type();
    answer.body = *std::move(body);
    return answer;
}

Estimate cost_of_mask(const ThresholdMask& mask) {
    constexpr Estimate kPixel{64, 7 * kMicrosecond};
    return kPixel * (mask.torus.width * mask.torus.height * mask.depth.value_or(1));
}

}  // namespace ccdt::api
