// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/density_input.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "api/image/embedded_image.h"
#include "api/output/stage_costs.h"
#include "core/picture/tone.h"

namespace ccdt::api {
namespace {

constexpr std::uint64_t kMaxSide = std::numeric_limits<int>::max();

struct DensityDraft {
    std::optional<int> width;
    std::optional<int> height;
    std::optional<int> depth;
    std::optional<std::vector<double>> values;
    std::optional<ImageFile> image;
};

/// Checks the number of values.
/// @param wanted  the number of values that is wanted, in words
Result<void> check_values(const Input& input, const DensityDraft& draft, std::string_view wanted) {
    // Sides are below 2^31, so the product of two sides is exact. The product of three sides is limited.
    const std::uint64_t layer = static_cast<std::uint64_t>(*draft.width) * static_cast<std::uint64_t>(*draft.height);
    const auto layers = static_cast<std::uint64_t>(draft.depth.value_or(1));
    const std::uint64_t cells = layer > kMaxInteger / layers ? kMaxInteger : layer * layers;
    if (draft.values->size() == cells) return {};
    const std::string pointer = pointer_below(input.field, "values");
    return failure(ErrorCode::Malformed,
                   pointer + " must have " + std::string(wanted) + " numbers, " + std::to_string(cells) + ", not " +
                       std::to_string(draft.values->size()),
                   pointer);
}

Result<DensityInput> settle_density(const Input& input, DensityDraft draft) {
    const bool any_of_grid = draft.width || draft.height || draft.values;
    if (draft.image && !any_of_grid) return DensityImage{*std::move(draft.image)};
    if (draft.image || !draft.width || !draft.height || !draft.values) {
        return malformed(input, "must have either the members width, height and values, or the member image");
    }
    if (auto checked = check_values(input, draft, "width times height"); !checked)
        return tl::unexpected(checked.error());
    return DensityGrid{*draft.width, *draft.height, *std::move(draft.values)};
}

void flip_rows(std::vector<float>& values, int width) {
    const auto row = static_cast<std::ptrdiff_t>(width);
    auto top = values.begin();
    for (auto bottom = values.end() - row; top < bottom; top += row, bottom -= row) {
        std::swap_ranges(top, top + row, bottom);
    }
}

Result<Density> make_density(const DensityImage& image, YAxis y, const Limits& limits, const Decode& decode,
                             const Control& control) {
    auto picture = decode.grey(image.file.bytes, limits.max_pixels, control.stop);
    if (!picture) return failure(picture.error().code, picture.error().message, "/density/image");
    const int width = picture->width;
    const int height = picture->height;
    std::vector<float> coverage = ink_coverage(*picture, Tone::Linear, false);
    *picture = {};  // frees several megabytes per megapixel
    if (y == YAxis::Up) flip_rows(coverage, width);
    auto density = Density::grid(width, height, std::span<const float>(coverage));
    if (!density) density.error().field = "/density/image";
    return density;
}

constexpr std::array<OptionRule<DensityDraft>, 5> kRules = {{
    {"/density/depth",
     [](const Input& i, const Limits&, DensityDraft& d) { return assign(d.depth, read_integer(i, 1, kMaxSide)); }},
    {"/density/width",
     [](const Input& i, const Limits&, DensityDraft& d) { return assign(d.width, read_integer(i, 1, kMaxSide)); }},
    {"/density/height",
     [](const Input& i, const Limits&, DensityDraft& d) { return assign(d.height, read_integer(i, 1, kMaxSide)); }},
    {"/density/values",
     [](const Input& i, const Limits&, DensityDraft& d) { return assign(d.values, read_densities(i)); }},
    {"/density/image",
     [](const Input& i, const Limits& l, DensityDraft& d) { return assign(d.image, read_embedded_image(i, l)); }},
}};

Result<DensityDraft> read_draft(std::span<const OptionRule<DensityDraft>> rules, const Input& input,
                                const Limits& limits) {
    DensityDraft draft;
    const auto object = std::get<JsonValue>(input.value);
    return read_members<DensityDraft>(rules, object, input.field, limits, draft).map([&] { return std::move(draft); });
}

}  // namespace

Result<std::vector<double>> read_densities(const Input& input) {
    const auto list = std::get<JsonValue>(input.value);
    if (!list.is_array()) return malformed(input, "must be a list of numbers");
    std::vector<double> values;
    values.reserve(list.size());
    for (const JsonValue value : list) {
        if (!value.is_number() || value.number() < 0) {
            const std::string pointer = pointer_below(input.field, values.size());
            return failure(ErrorCode::Malformed, pointer + " must be a number of at least 0", pointer);
        }
        values.push_back(value.number());
    }
    return values;
}

Result<DensityInput> read_density(const Input& input, const Limits& limits) {
    return read_draft(std::span(kRules).subspan(1), input, limits).and_then([&](DensityDraft draft) {
        return settle_density(input, std::move(draft));
    });
}

Result<VoxelGrid> read_grid(const Input& input, const Limits& limits) {
    auto draft = read_draft(std::span(kRules).first(4), input, limits);
    if (!draft) return tl::unexpected(draft.error());
    if (!draft->width || !draft->height || !draft->depth || !draft->values)
        return malformed(input, "must have the members width, height, depth and values");
    if (auto checked = check_values(input, *draft, "width times height times depth"); !checked)
        return tl::unexpected(checked.error());
    const auto side = [](int count) { return static_cast<std::size_t>(count); };
    return VoxelGrid{{side(*draft->width), side(*draft->height), side(*draft->depth)}, *std::move(draft->values)};
}

Result<Density> make_density(const DensityInput& input, YAxis y, const Limits& limits, const Decode& decode,
                             const Control& control) {
    if (const auto* image = std::get_if<DensityImage>(&input)) return make_density(*image, y, limits, decode, control);
    const auto* grid = std::get_if<DensityGrid>(&input);
    if (grid == nullptr) return Density::uniform();
    auto density = Density::grid(grid->width, grid->height, std::span<const double>(grid->values));
    if (!density) return tl::unexpected(error_below(density.error(), "/density"));
    return density;
}

Estimate decoding_cost(const DensityInput& input) {
    const auto* image = std::get_if<DensityImage>(&input);
    return image == nullptr ? Estimate{} : decoding_cost(image->file);
}

double cells_of(const DensityInput& input) {
    if (const auto* image = std::get_if<DensityImage>(&input)) return static_cast<double>(image->file.header.pixels());
    const auto* grid = std::get_if<DensityGrid>(&input);
    return grid == nullptr ? 0 : static_cast<double>(grid->values.size());
}

std::size_t bytes_of(const DensityInput& input) {
    if (const auto* image = std::get_if<DensityImage>(&input)) return bytes_of(image->file);
    const auto* grid = std::get_if<DensityGrid>(&input);
    return grid == nullptr ? 0 : grid->values.size() * sizeof(double);
}

}  // namespace ccdt::api
