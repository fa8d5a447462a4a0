// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/heif_properties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

namespace ccdt::api {
namespace {

constexpr std::size_t kVersion = 4;  ///< size of the version and flags at the beginning of some boxes

bool is_letter_or_digit(char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

std::optional<Chunk> find_box(std::string_view bytes, std::string_view name) {
    auto box = media_box(bytes, 0);
    while (box && box->name != name) box = media_box(bytes, box->end);
    return box;
}

/// Returns the id of the primary item, which is the picture that viewers show.
std::optional<std::uint32_t> primary_item(std::string_view meta) {
    const auto box = find_box(meta, "pitm");
    if (!box) return std::nullopt;
    const ByteReader reader(box->data, true);
    const bool is_old = reader.read(0, 1) == 0U;
    return reader.read(kVersion, is_old ? 2 : 4);
}

/// Returns the properties of all items. Items refer to them by number, from 1 on.
std::vector<Chunk> all_properties(std::string_view container) {
    constexpr std::size_t kMax = 0x7FFF;
    std::vector<Chunk> all;
    for (auto box = media_box(container, 0); box && all.size() < kMax; box = media_box(container, box->end))
        all.push_back(*box);
    return all;
}

/// Returns the numbers of an item's properties, from the data of an ipma box; empty if the box does not list the item.
std::vector<std::uint32_t> numbers_of(std::string_view associations, std::uint32_t item) {
    const ByteReader reader(associations, true);
    const std::size_t item_size = reader.read(0, 1) == 0U ? 2 : 4;
    const std::size_t size = (reader.read(3, 1).value_or(0) & 1) == 0 ? 1 : 2;
    const std::uint32_t mask = size == 1 ? 0x7F : 0x7FFF;  // the highest bit marks essential properties
    std::vector<std::uint32_t> numbers;
    std::size_t at = kVersion + 4;
    for (auto left = reader.read(kVersion, 4).value_or(0); left > 0; --left) {
        const auto name = reader.read(at, item_size);
        const auto count = reader.read(at + item_size, 1);
        if (!name || !count) break;
        at += item_size + 1;
        if (*name != item) {
            at += *count * size;
            continue;
        }
        for (std::uint32_t i = 0; i < *count; ++i)
            numbers.push_back(reader.read(at + i * size, size).value_or(0) & mask);
        break;
    }
    return numbers;
}

/// References from an item to other items.
struct References {
    std::string_view type;
    std::uint32_t from = 0;
    std::vector<std::uint32_t> to;
};

/// Returns the references between items. Source: ISO/IEC 14496-12, 8.11.12.
std::vector<References> all_references(std::string_view meta) {
    const auto list = find_box(meta, "iref");
    if (!list) return {};
    const std::size_t size = ByteReader(list->data, true).read(0, 1) == 0U ? 2 : 4;
    std::vector<References> all;
    for (auto box = media_box(list->data, kVersion); box; box = media_box(list->data, box->end)) {
        const ByteReader reader(box->data, true);
        References found{box->name, reader.read(0, size).value_or(0), {}};
        const std::size_t count = reader.read(size, 2).value_or(0);
        for (std::size_t i = 0; i < count; ++i) {
            const auto item = reader.read(size + 2 + i * size, size);
            if (!item) break;
            found.to.push_back(*item);
        }
        all.push_back(std::move(found));
    }
    return all;
}

/// Returns the first pixel of a crop along an axis; none if the crop is not within the picture.
/// @param length  of the crop, in pixels
/// @param at      offset of the property's fraction for the offset of the crop from the middle
std::optional<std::uint32_t> first_of_crop(const ByteReader& crop, std::size_t at, std::uint32_t whole,
                                           std::uint32_t length) {
    const auto numerator = crop.read(at, 4), denominator = crop.read(at + 4, 4);
    if (!numerator || !denominator || *denominator == 0 || length == 0 || length > whole) return std::nullopt;
    const double offset = static_cast<double>(static_cast<std::int32_t>(*numerator)) / *denominator;
    const double first = std::floor((whole - length) / 2.0 + offset);
    if (!(first >= 0 && first <= whole - length)) return std::nullopt;
    return static_cast<std::uint32_t>(first);
}

/// Returns the whole part of a fraction; 0 if it is not a number.
std::uint32_t whole_part(const ByteReader& reader, std::size_t at) {
    const auto numerator = reader.read(at, 4).value_or(0), denominator = reader.read(at + 4, 4).value_or(0);
    return denominator == 0 ? 0 : numerator / denominator;
}

/// Returns the properties of an item; empty if the file is broken.
std::vector<Chunk> properties_of(std::string_view meta, std::uint32_t item) {
    const auto properties = find_box(meta, "iprp");
    const auto container = properties ? find_box(properties->data, "ipco") : std::nullopt;
    if (!container) return {};
    const std::vector<Chunk> all = all_properties(container->data);
    std::vector<Chunk> found;
    for (auto box = media_box(properties->data, 0); box && found.empty(); box = media_box(properties->data, box->end)) {
        if (box->name != "ipma") continue;
        for (const std::uint32_t number : numbers_of(box->data, item)) {
            if (number >= 1 && number <= all.size()) found.push_back(all[number - 1]);
        }
    }
    return found;
}

/// Returns whether an item is the alpha of another one, according to its properties. Source: HEIF, 6.5.8; MIAF (ISO/IEC
/// 23000-22), 7.3.5.2.
bool is_alpha(std::string_view meta, std::uint32_t item) {
    return std::ranges::any_of(properties_of(meta, item), [](const Chunk& property) {
        return property.name == "auxC" && property.data.find("auxiliary:alpha") != std::string_view::npos;
    });
}

/// A mirroring from left to right, if any, followed by quarter turns counterclockwise.
struct Turn {
    bool mirrored = false;
    std::uint32_t quarters = 0;

    Turn then_rotated(std::uint32_t more) const { return {mirrored, (quarters + more) % 4}; }

    /// Adds a mirroring. A mirroring from top to bottom is one from left to right and a half turn; turns before a
    /// mirroring become opposite ones.
    Turn then_mirrored(bool top_to_bottom) const { return {!mirrored, ((top_to_bottom ? 6 : 4) - quarters) % 4}; }

    /// Returns the equivalent orientation of EXIF.
    int orientation() const {
        constexpr std::array<std::array<int, 4>, 2> kOrientations = {{{1, 8, 3, 6}, {2, 5, 4, 7}}};
        return kOrientations[mirrored ? 1 : 0][quarters];
    }
};

/// Returns whether the first box of a file, which may be truncated, lists one of the brands.
bool has_brand(std::string_view bytes, std::span<const std::string_view> brands) {
    constexpr std::size_t kName = 4, kBrands = 8, kMinorVersion = 12;
    if (bytes.substr(0, kBrands).substr(std::min(kName, bytes.size())) != "ftyp") return false;
    const std::size_t end = std::min<std::size_t>(ByteReader(bytes, true).read(0, 4).value_or(0), bytes.size());
    for (std::size_t at = kBrands; at + kName <= end; at += kName) {
        const std::string_view brand = bytes.substr(at, kName);
        const bool is_brand = at != kMinorVersion;
        if (is_brand && std::ranges::find(brands, brand) != brands.end()) return true;
    }
    return false;
}

/// Returns the contents of the box that describes the items; empty if there is none.
std::string_view find_meta(std::string_view bytes) {
    const auto meta = find_box(bytes, "meta");
    return meta ? meta->data.substr(std::min(kVersion, meta->data.size())) : std::string_view();
}

}  // namespace

bool is_avif(std::string_view bytes) {
    constexpr auto kBrands = std::to_array<std::string_view>({"avif", "avis"});
    return has_brand(bytes, kBrands);
}

bool is_heic(std::string_view bytes) {
    constexpr auto kBrands = std::to_array<std::string_view>(
        {"heic", "heix", "heim", "heis", "hevc", "hevx", "hevm", "hevs", "mif1", "msf1"});
    return !is_avif(bytes) && has_brand(bytes, kBrands);
}

std::optional<HeifView> heif_view(std::span<const Chunk> properties) {
    HeifView view;
    const Chunk* crop = nullptr;
    Turn turn;
    for (const Chunk& property : properties) {
        const ByteReader reader(property.data, true);
        const std::uint32_t first = reader.read(0, 1).value_or(0);
        if (property.name == "irot") turn = turn.then_rotated(first % 4);
        if (property.name == "imir") turn = turn.then_mirrored(first % 2 == 0);
        if (property.name == "ispe") {
            view.whole_width = view.width = reader.read(kVersion, 4).value_or(0);
            view.whole_height = view.height = reader.read(kVersion + 4, 4).value_or(0);
        }
        if (property.name != "clap") continue;
        if (turn.orientation() != 1) return std::nullopt;
        crop = &property;
    }
    view.orientation = turn.orientation();
    if (crop == nullptr) return view;
    const ByteReader reader(crop->data, true);
    view.width = whole_part(reader, 0);
    view.height = whole_part(reader, 8);
    const auto left = first_of_crop(reader, 16, view.whole_width, view.width);
    const auto top = first_of_crop(reader, 24, view.whole_height, view.height);
    if (!left || !top) return std::nullopt;
    view.left = *left;
    view.top = *top;
    return view;
}

std::string_view misread_grid(std::string_view bytes) {
    const std::string_view meta = find_meta(bytes);
    const auto item = primary_item(meta);
    const std::vector<References> all = all_references(meta);
    const auto grid =
        std::ranges::find_if(all, [&](const References& each) { return each.type == "dimg" && each.from == item; });
    if (grid == all.end()) return {};
    if (!std::ranges::is_sorted(grid->to)) return "tiles that are not in the order of their items";
    const auto is_alpha_of_tile = [&](const References& each) {
        return each.type == "auxl" && std::ranges::find_first_of(each.to, grid->to) != each.to.end() &&
               is_alpha(meta, each.from);
    };
    return std::ranges::any_of(all, is_alpha_of_tile) ? "tiles that have alpha of their own" : "";
}

std::vector<std::string_view> heif_item_types(std::string_view bytes) {
    constexpr std::size_t kType = 4;
    const auto list = find_box(find_meta(bytes), "iinf");
    if (!list) return {};
    std::vector<std::string_view> types;
    const bool is_old = ByteReader(list->data, true).read(0, 1) == 0U;
    const std::size_t head = kVersion + (is_old ? 2 : 4);  // the number of items is ignored
    for (auto box = media_box(list->data, head); box; box = media_box(list->data, box->end)) {
        const auto version = ByteReader(box->data, true).read(0, 1).value_or(0);
        const std::size_t at = kVersion + (version == 2 ? 4 : 6);  // after the number of the item and two more bytes
        if (version < 2 || box->data.size() < at + kType) continue;
        const std::string_view type = box->data.substr(at, kType);
        if (std::ranges::all_of(type, is_letter_or_digit)) types.push_back(type);
    }
    return types;
}

std::uint64_t heif_frames(std::string_view bytes) {
    std::string_view inside = bytes;
    for (const char* const name : {"moov", "trak", "mdia", "minf", "stbl", "stsz"}) {
        const auto box = find_box(inside, name);
        if (!box) return 0;
        inside = box->data;
    }
    return ByteReader(inside, true).read(kVersion + 4, 4).value_or(0);
}

std::vector<Chunk> heif_properties(std::string_view bytes) {
    const std::string_view meta = find_meta(bytes);
    const auto item = primary_item(meta);
    return item ? properties_of(meta, *item) : std::vector<Chunk>();
}

}  // namespace ccdt::api
