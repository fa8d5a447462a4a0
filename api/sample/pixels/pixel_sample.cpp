// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/pixels/pixel_sample.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "api/decode/timed_decode.h"
#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/input/run_options.h"
#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"
#include "core/dither/pixel_choice.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kDomainType = "pixels";
constexpr std::uint64_t kMaxSide = 65'535;  ///< of a raster, in pixels

/// A block of pixels in a request. A missing width or height reaches to the border of the raster.
struct Block {
    int x = 0;
    int y = 0;
    std::optional<int> width;
    std::optional<int> height;
    std::string field;  ///< JSON Pointer
};

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    PixelRequest request;
    std::optional<std::uint64_t> sites;
    std::vector<Block> included;
    std::optional<Block> calibration;  ///< without x and y
    Options run;
};

Result<void> read_raster(const Input& input, FrameSize& raster) {
    static constexpr std::array<OptionRule<FrameSize>, 3> kRules = {{
        {"/domain/type", [](const Input&, const Limits&, FrameSize&) { return Result<void>(); }},
        {"/domain/width",
         [](const Input& i, const Limits&, FrameSize& r) { return assign(r.width, read_integer(i, 1, kMaxSide)); }},
        {"/domain/height",
         [](const Input& i, const Limits&, FrameSize& r) { return assign(r.height, read_integer(i, 1, kMaxSide)); }},
    }};
    const auto object = std::get<JsonValue>(input.value);
    if (auto read = read_members<FrameSize>(kRules, object, input.field, {}, raster); !read) return read;
    if (raster.width == 0 || raster.height == 0)
        return malformed(input, "must have the members type, width and height");
    return {};
}

/// Reads the members of a block.
/// @param rules  rules with the names of the members
Result<Block> read_block(std::span<const OptionRule<Block>> rules, const Input& input) {
    Block block;
    block.field = input.field;
    auto members = inputs_of(std::get<JsonValue>(input.value), input.field);
    if (!members) return tl::unexpected(members.error());
    ErrorList errors;
    for (const Input& member : *members) {
        const auto is_named = [&](const auto& rule) { return member.field == pointer_below(input.field, rule.name); };
        const auto rule = std::ranges::find_if(rules, is_named);
        errors.add(rule == rules.end() ? unknown_option(member, names_of(rules)) : rule->read(member, {}, block));
    }
    if (auto read = errors.result(); !read) return tl::unexpected(read.error());
    return block;
}

/// Members of blocks. A calibration area, whose position is given, has only the first two.
constexpr std::array<OptionRule<Block>, 4> kBlockRules = {{
    {"width", [](const Input& i, const Limits&, Block& b) { return assign(b.width, read_integer(i, 1, kMaxSide)); }},
    {"height", [](const Input& i, const Limits&, Block& b) { return assign(b.height, read_integer(i, 1, kMaxSide)); }},
    {"x", [](const Input& i, const Limits&, Block& b) { return assign(b.x, read_integer(i, 0, kMaxSide)); }},
    {"y", [](const Input& i, const Limits&, Block& b) { return assign(b.y, read_integer(i, 0, kMaxSide)); }},
}};

Result<Block> read_pixel(const Input& input) {
    const auto pair = std::get<JsonValue>(input.value);
    if (!pair.is_array() || pair.size() != 2)
        return malformed(input, "must be a pixel [x, y], or an object with x, y, width and height");
    Block block{0, 0, 1, 1, input.field};
    std::size_t position = 0;
    for (const JsonValue number : pair) {
        const std::string field = pointer_below(input.field, position);
        const auto read = assign(position == 0 ? block.x : block.y, read_integer({field, field, number}, 0, kMaxSide));
        if (!read) return tl::unexpected(read.error());
        ++position;
    }
    return block;
}

Result<void> read_included(const Input& input, std::vector<Block>& blocks) {
    const auto list = std::get<JsonValue>(input.value);
    if (!list.is_array()) return malformed(input, "must be a list of pixels [x, y] and blocks of pixels");
    blocks.reserve(list.size());
    for (const JsonValue value : list) {
        const std::string field = pointer_below(input.field, blocks.size());
        const Input each{field, field, value};
        auto block = value.is_object() ? read_block(kBlockRules, each) : read_pixel(each);
        if (!block) return tl::unexpected(block.error());
        blocks.push_back(*std::move(block));
    }
    return {};
}

Result<void> read_calibration(const Input& input, std::optional<Block>& calibration) {
    auto block = read_block(std::span(kBlockRules).first<2>(), input);
    if (!block) return tl::unexpected(block.error());
    if (!block->width && !block->height) return malformed(input, "must have the members width or height, or both");
    calibration = *std::move(block);
    return {};
}

constexpr std::array<OptionRule<Draft>, 8> kRules = {{
    {"domain", [](const Input& i, const Limits&, Draft& d) { return read_raster(i, d.request.raster); }},
    {"sites", [](const Input& i, const Limits&, Draft& d) { return assign(d.sites, read_integer(i, 1, kMaxInteger)); }},
    {"density",
     [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.density, read_density(i, l)); }},
    {"calibration", [](const Input& i, const Limits&, Draft& d) { return read_calibration(i, d.calibration); }},
    {"include", [](const Input& i, const Limits&, Draft& d) { return read_included(i, d.included); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.run); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"format",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.format, read_format(i, pixel_formats())); }},
}};

std::string text_of(const FrameSize& raster) {
    return std::to_string(raster.width) + " x " + std::to_string(raster.height) + " pixels";
}

std::size_t pixels_of(const FrameSize& raster) {
    return static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height);
}

Result<void> check_raster(const FrameSize& raster, const Limits& limits) {
    if (pixels_of(raster) <= limits.max_pixels) return {};
    return failure(
        ErrorCode::LimitExceeded,
        "domain has " + text_of(raster) + "; this server's limit (max-pixels) is " + std::to_string(limits.max_pixels),
        "/domain");
}

Result<void> settle_sites(Draft& draft) {
    if (!draft.sites) return failure(ErrorCode::Malformed, "sites is missing", "/sites");
    if (*draft.sites > pixels_of(draft.request.raster))
        return failure(
            ErrorCode::Unusable,
            "sites is " + std::to_string(*draft.sites) + ", but the domain has only " + text_of(draft.request.raster),
            "/sites");
    draft.request.sites = *draft.sites;
    return {};
}

/// Adds a block to the included ones. Errors: Unusable if a part of it is outside the raster.
Result<void> add_block(const Block& block, PixelRequest& request) {
    const FrameSize& raster = request.raster;
    const int width = block.width.value_or(raster.width - block.x),
              height = block.height.value_or(raster.height - block.y);
    if (width < 1 || height < 1 || width > raster.width - block.x || height > raster.height - block.y)
        return failure(ErrorCode::Unusable, block.field + " must lie within the domain of " + text_of(raster),
                       block.field);
    request.included.push_back({block.x, block.y, block.x + width, block.y + height});
    return {};
}

/// Returns the first pixel of a centred range. The middle pixel of the range, n / 2, is the middle pixel of the raster.
int first_of_centred(int range, int raster) {
    return raster / 2 - range / 2;
}

Result<void> settle_included(Draft& draft) {
    PixelRequest& request = draft.request;
    request.included.reserve(draft.included.size() + 1);
    request.including = draft.included.empty() ? "/calibration" : "/include";
    if (draft.calibration) {
        Block& block = *draft.calibration;
        if (block.width) block.x = std::max(0, first_of_centred(*block.width, request.raster.width));
        if (block.height) block.y = std::max(0, first_of_centred(*block.height, request.raster.height));
        if (auto added = add_block(block, request); !added) return added;
    }
    for (const Block& block : draft.included) {
        if (auto added = add_block(block, request); !added) return added;
    }
    return {};
}

/// Marks the included pixels. O(pixels + blocks).
std::vector<std::uint8_t> mask_of(std::span<const CellBlock> blocks, const FrameSize& raster) {
    std::vector<std::uint8_t> mask(pixels_of(raster), 0);
    if (blocks.empty()) return mask;
    // Changes of the number of blocks from pixel to pixel. Summed along rows, then along columns, they give the number
    // of blocks at each pixel.
    const auto stride = static_cast<std::size_t>(raster.width) + 1;
    std::vector<std::int32_t> changes(stride * (static_cast<std::size_t>(raster.height) + 1), 0);
    const auto change = [&](int x, int y) -> std::int32_t& {
        return changes[static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x)];
    };
    for (const auto& [left, low, right, high] : blocks) {
        ++change(left, low);
        --change(right, low);
        --change(left, high);
        ++change(right, high);
    }
    auto marked = mask.begin();
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x) {
            if (x > 0) change(x, y) += change(x - 1, y);
        }
        for (int x = 0; x < raster.width; ++x) {
            if (y > 0) change(x, y) += change(x, y - 1);
            *marked++ = change(x, y) > 0 ? 1 : 0;
        }
    }
    return mask;
}

Result<std::vector<double>> make_shares(const PixelRequest& request, const Density& density, Executor& executor) {
    const auto& [width, height] = request.raster;
    return pixel_shares(density, mask_of(request.included, request.raster), width, height, request.sites, executor)
        .map_error([&](Error error) {
            error.field = error.field == "include" ? std::string(request.including) : pointer_below("", error.field);
            return error;
        });
}

}  // namespace

std::vector<std::string_view> pixel_options() {
    return names_of<Draft>(kRules);
}

bool asks_for_pixels(JsonValue root) {
    const auto domain = root.is_object() ? root.find("domain") : std::nullopt;
    const auto type = domain && domain->is_object() ? domain->find("type") : std::nullopt;
    return type && type->is_string() && type->text() == kDomainType;
}

Result<PixelRequest> parse_pixels(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                  const Limits& limits) {
    if (!options.empty())
        return failure(ErrorCode::Malformed, "options must be members of the JSON body", excerpt(options.front().name));
    Draft draft;
    if (auto read = read_members<Draft>(kRules, root, "", limits, draft); !read) return tl::unexpected(read.error());
    if (auto fits = check_raster(draft.request.raster, limits); !fits) return tl::unexpected(fits.error());
    ErrorList errors;
    errors.add(settle_sites(draft));
    errors.add(settle_included(draft));
    errors.add(settle_format(accept, pixel_formats(), draft.request.format));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    draft.request.seed = draft.run.seed;
    return std::move(draft.request);
}

Result<Answer> run_pixels(const PixelRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings, BodySink* sink) {
    Stopwatch watch;
    const auto& [width, height] = request.raster;
    Executor& executor = *control.executor;
    const auto shares = make_density(request.density, YAxis::Down, limits, timed(decode, timings.decode), control)
                            .and_then([&](const Density& density) {
                                timings.prepare = watch.lap() - timings.decode;
                                return make_shares(request, density, executor);
                            });
    if (!shares) return tl::unexpected(shares.error());
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());
    const auto chosen = choose_pixels(*shares, width, height, request.seed, control.stop, executor);
    timings.optimise = watch.lap();

    Answer answer;
    answer.partial = control.stop.stop_requested();
    if (answer.partial && request.on_deadline == OnStop::Error) return tl::unexpected(check_stop(control.stop).error());
    answer.media_type = request.format->file.content_type();
    answer.sites = request.sites;
    Body body(answer, sink, control.stop);
    const ChosenPixels set{width, height, chosen, request.sites, request.seed, answer.partial};
    auto written = request.format->write(set, body, stop_of_writing(control, request.on_deadline));
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(written.error());
    return body.finish(std::move(answer));
}

Cost cost_of(const PixelRequest& request, const Limits& /*limits*/) {
    // Bytes per pixel: shares, wanted values, residuals, the levels of VisualError, and marks.
    constexpr Estimate kPixel{42, 0.4 * kMicrosecond};
    const auto pixels = static_cast<double>(pixels_of(request.raster));
    const Estimate written{
        static_cast<double>(request.sites) * request.format->bytes_per_site + pixels * request.format->bytes_per_pixel,
        0};
    return total_cost(then(decoding_cost(request.density), density_cost(cells_of(request.density))) + kPixel * pixels +
                      written);
}

std::size_t size_of(const PixelRequest& request) {
    return bytes_of(request.density) + request.included.size() * sizeof(CellBlock);
}

}  // namespace ccdt::api
