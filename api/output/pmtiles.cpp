// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/pmtiles.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include <zlib.h>
#include <protozero/buffer_string.hpp>
#include <protozero/exception.hpp>
#include <protozero/varint.hpp>

#include "api/output/records.h"

namespace ccdt::api {
namespace {

constexpr int kGzip = 16 + MAX_WBITS;
constexpr std::string_view kMagic = "PMTiles\3";
constexpr double kDegreeUnits = 1e7;

Bytef* bytes_of(std::string_view text) {
    return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
}

void append_degrees(std::string& out, Point degrees) {
    for (const double each : {degrees.x, degrees.y})
        append_binary(out, static_cast<std::int32_t>(std::llround(each * kDegreeUnits)));
}

/// Reads numbers from bytes, the least significant byte first.
template <class Number>
Number number_at(std::string_view bytes, std::size_t offset) {
    Number number{};
    std::memcpy(&number, bytes.data() + offset, sizeof number);
    return number;
}

Point degrees_at(std::string_view bytes, std::size_t offset) {
    return {number_at<std::int32_t>(bytes, offset) / kDegreeUnits,
            number_at<std::int32_t>(bytes, offset + 4) / kDegreeUnits};
}

}  // namespace

std::uint64_t tile_number(int zoom, std::uint32_t column, std::uint32_t row) {
    std::uint64_t number = 0;
    for (int z = 0; z < zoom; ++z) number += std::uint64_t{1} << (2 * z);  // tiles of the zooms before
    for (std::uint32_t side = (1U << zoom) / 2; side > 0; side /= 2) {
        const std::uint32_t right = (column & side) > 0, low = (row & side) > 0;
        number += std::uint64_t{side} * side * ((3 * right) ^ low);
        if (low == 0) {
            if (right == 1) {
                column = side - 1 - (column & (side - 1));
                row = side - 1 - (row & (side - 1));
            }
            std::swap(column, row);
        }
    }
    return number;
}

std::string write_header(const TileArchive& archive) {
    std::string out(kMagic);
    for (const auto& [offset, length] : {archive.root, archive.metadata, archive.leaves, archive.tiles}) {
        append_binary(out, offset);
        append_binary(out, length);
    }
    for (int i = 0; i < 3; ++i) append_binary(out, archive.entries);  // tiles, entries, contents
    constexpr char kClustered = 1, kByGzip = 2, kVectorTiles = 1;
    out += {kClustered, kByGzip, kByGzip, kVectorTiles};
    out += {static_cast<char>(archive.min_zoom), static_cast<char>(archive.max_zoom)};
    append_degrees(out, archive.min);
    append_degrees(out, archive.max);
    out += static_cast<char>(archive.min_zoom);
    append_degrees(out, 0.5 * (archive.min + archive.max));
    return out;
}

std::optional<TileArchive> read_header(std::string_view bytes) {
    if (bytes.size() < TileArchive::kHeader || !bytes.starts_with(kMagic)) return std::nullopt;
    TileArchive archive;
    std::size_t offset = kMagic.size();
    for (auto* section : {&archive.root, &archive.metadata, &archive.leaves, &archive.tiles}) {
        *section = {number_at<std::uint64_t>(bytes, offset), number_at<std::uint64_t>(bytes, offset + 8)};
        offset += 16;
    }
    constexpr std::size_t kZooms = 100, kBounds = 102;
    archive.entries = number_at<std::uint64_t>(bytes, offset);
    archive.min_zoom = static_cast<unsigned char>(bytes[kZooms]);
    archive.max_zoom = static_cast<unsigned char>(bytes[kZooms + 1]);
    archive.min = degrees_at(bytes, kBounds);
    archive.max = degrees_at(bytes, kBounds + 8);
    return archive;
}

std::string write_directory(std::span<const TileEntry> entries) {
    std::string bytes;
    const auto add = [&](std::uint64_t number) { protozero::add_varint_to_buffer(&bytes, number); };
    add(entries.size());
    std::uint64_t last = 0;
    for (const TileEntry& entry : entries) add(entry.id - std::exchange(last, entry.id));
    for (const TileEntry& entry : entries) add(entry.run);
    for (const TileEntry& entry : entries) add(entry.length);
    std::uint64_t end = 0;
    for (const TileEntry& entry : entries) {
        add(&entry != entries.data() && entry.offset == end ? 0 : entry.offset + 1);
        end = entry.offset + entry.length;
    }
    return gzipped(bytes);
}

std::optional<std::vector<TileEntry>> read_directory(std::string_view bytes) {
    const auto text = gunzipped(bytes);
    if (!text) return std::nullopt;
    const char* at = text->data();
    const char* const last = at + text->size();
    try {
        const auto take = [&] { return protozero::decode_varint(&at, last); };
        const std::uint64_t count = take();
        if (count > text->size()) return std::nullopt;
        std::vector<TileEntry> entries(count);
        std::uint64_t id = 0, end = 0;
        for (TileEntry& entry : entries) entry.id = id += take();
        for (TileEntry& entry : entries) entry.run = take();
        for (TileEntry& entry : entries) entry.length = take();
        for (TileEntry& entry : entries) {
            const std::uint64_t given = take();
            entry.offset = given == 0 ? end : given - 1;
            end = entry.offset + entry.length;
        }
        return entries;
    } catch (const protozero::exception&) {
        return std::nullopt;
    }
}

const TileEntry* find_entry(std::span<const TileEntry> entries, std::uint64_t tile) {
    const auto after = std::ranges::upper_bound(entries, tile, {}, &TileEntry::id);
    if (after == entries.begin()) return nullptr;
    const TileEntry& entry = *std::prev(after);
    return entry.run == 0 || tile - entry.id < entry.run ? &entry : nullptr;
}

std::string gzipped(std::string_view text) {
    constexpr int kMemory = 8;
    z_stream stream{};
    deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
    stream.next_in = bytes_of(text);
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = bytes_of(out);
    stream.avail_out = static_cast<uInt>(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

std::optional<std::string> gunzipped(std::string_view bytes) {
    constexpr std::size_t kStep = 65'536;
    z_stream stream{};
    inflateInit2(&stream, kGzip);
    stream.next_in = bytes_of(bytes);
    stream.avail_in = static_cast<uInt>(bytes.size());
    std::string out;
    int status = Z_OK;
    while (status == Z_OK) {
        out.resize(stream.total_out + kStep);
        stream.next_out = bytes_of(out) + stream.total_out;
        stream.avail_out = kStep;
        status = inflate(&stream, Z_NO_FLUSH);
    }
    out.resize(stream.total_out);
    inflateEnd(&stream);
    return status == Z_STREAM_END ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace ccdt::api
