// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/avif_properties.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace ccdt::api {
namespace {

constexpr std::size_t kVersion = 4;  ///< size of the version and flags at the beginning of some boxes

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

}  // namespace

bool is_avif(std::string_view bytes) {
    constexpr std::size_t kName = 4;
    const auto box = media_box(bytes, 0);
    if (!box || box->name != "ftyp") return false;
    for (std::size_t at = 0; at + kName <= box->data.size(); at += kName) {
        const std::string_view brand = box->data.substr(at, kName);
        const bool is_brand = at != kName;  // the second field is a version number, not a brand
        if (is_brand && (brand == "avif" || brand == "avis")) return true;
    }
    return false;
}

std::uint64_t avif_frames(std::string_view bytes) {
    std::string_view inside = bytes;
    for (const char* const name : {"moov", "trak", "mdia", "minf", "stbl", "stsz"}) {
        const auto box = find_box(inside, name);
        if (!box) return 0;
        inside = box->data;
    }
    return ByteReader(inside, true).read(kVersion + 4, 4).value_or(0);
}

std::vector<Chunk> avif_properties(std::string_view bytes) {
    const auto meta = find_box(bytes, "meta");
    if (!meta) return {};
    const std::string_view inside = meta->data.substr(std::min(kVersion, meta->data.size()));
    const auto item = primary_item(inside);
    const auto properties = find_box(inside, "iprp");
    const auto container = properties ? find_box(properties->data, "ipco") : std::nullopt;
    if (!item || !container) return {};
    const std::vector<Chunk> all = all_properties(container->data);
    std::vector<Chunk> found;
    for (auto box = media_box(properties->data, 0); box && found.empty(); box = media_box(properties->data, box->end)) {
        if (box->name != "ipma") continue;
        for (const std::uint32_t number : numbers_of(box->data, *item)) {
            if (number >= 1 && number <= all.size()) found.push_back(all[number - 1]);
        }
    }
    return found;
}

}  // namespace ccdt::api
