// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/dot_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <protozero/pbf_builder.hpp>

#include "api/json/json_document.h"
#include "api/output/json_pieces.h"
#include "api/output/pmtiles.h"
#include "api/text/text.h"
#include "core/base/elementary.h"

namespace ccdt::api {
namespace {

constexpr int kExtent = 4096;  // units along the side of a tile
constexpr std::string_view kLayer = "dots";

/// A dot in the square of the world, [0, 1) x [0, 1), with y from north to south.
struct TileDot {
    double x, y;
    std::uint32_t rank;  ///< in its layer
    std::uint32_t feature;
    std::uint32_t layer;
};

/// A tile of a zoom, and the number of its dots.
struct Tile {
    std::uint64_t id;  ///< number of the tile among those of all zooms
    std::uint32_t column, row;
};

TileDot projected(Point degrees) {
    constexpr double kNearlyOne = 1 - 0x1p-53;
    const double latitude = degrees.y * (std::numbers::pi / 180);
    const double turn = elementary::log(elementary::tan(std::numbers::pi / 4 + latitude / 2)) / (2 * std::numbers::pi);
    const double x = degrees.x / 360 + 0.5;
    return {std::clamp(x - std::floor(x), 0.0, kNearlyOne), std::clamp(0.5 - turn, 0.0, kNearlyOne), 0, 0, 0};
}

/// Returns the dots of all layers. The dots of each layer are in the order of their ranks, and those of all layers are
/// mixed in proportion, so that no class is drawn over another.
std::vector<TileDot> dots_of(const PointSet& points) {
    std::vector<TileDot> dots;
    dots.reserve(points.size());
    for (std::uint32_t layer = 0; layer < points.layers.size(); ++layer) {
        const InkDots& given = points.layers[layer];
        for (std::size_t i = 0; i < given.dots.points.size(); ++i) {
            TileDot dot = projected(given.dots.points[i]);
            dot.rank = given.dots.ranks[i];
            dot.feature = given.features.empty() ? 0 : given.features[i];
            dot.layer = layer;
            dots.push_back(dot);
        }
    }
    std::ranges::sort(dots, {}, [&](const TileDot& dot) {
        const auto count = static_cast<double>(points.layers[dot.layer].dots.points.size());
        return std::pair((dot.rank + 0.5) / count, dot.layer);
    });
    return dots;
}

std::uint32_t column_at(double share, int zoom) {
    return static_cast<std::uint32_t>(std::ldexp(share, zoom));
}

/// Returns the tile at a zoom that contains a dot.
Tile tile_of(const TileDot& dot, int zoom) {
    const std::uint32_t column = column_at(dot.x, zoom), row = column_at(dot.y, zoom);
    return {tile_number(zoom, column, row), column, row};
}

/// Returns the last zoom if none is given: the first one at which no tile has more dots than the limit.
int find_last_zoom(std::span<const TileDot> dots, const DotTiles& wanted) {
    std::vector<std::uint64_t> ids(dots.size());
    for (int zoom = wanted.min_zoom;; ++zoom) {
        if (zoom == DotTiles::kMaxZoom) return zoom;
        std::ranges::transform(dots, ids.begin(), [&](const TileDot& dot) { return tile_of(dot, zoom).id; });
        std::ranges::sort(ids);
        bool is_full = false;
        for (std::size_t i = wanted.dots_per_tile; i < ids.size() && !is_full; ++i)
            is_full = ids[i] == ids[i - wanted.dots_per_tile];
        if (!is_full) return zoom;
    }
}

// Fields of messages, by the specification of vector tiles.
enum class TileField : protozero::pbf_tag_type { Layers = 3 };
enum class LayerField : protozero::pbf_tag_type {
    Name = 1,
    Features = 2,
    Keys = 3,
    Values = 4,
    Extent = 5,
    Version = 15
};
enum class FeatureField : protozero::pbf_tag_type { Id = 1, Tags = 2, Type = 3, Geometry = 4 };
enum class ValueField : protozero::pbf_tag_type { Text = 1, Number = 3, Boolean = 7 };

/// Writes tiles whose dots have attributes.
class TileWriter {
public:
    explicit TileWriter(const PointSet& points) : points_(points), has_classes_(points.are_named()) {
        if (has_classes_) keys_.emplace_back("class");
        if (points.properties != nullptr)
            keys_.insert(keys_.end(), points.properties->names.begin(), points.properties->names.end());
    }

    const std::vector<std::string>& keys() const { return keys_; }

    /// Returns a tile, compressed.
    std::string write(std::span<const TileDot> dots, const Tile& tile, int zoom) {
        values_.clear();
        numbers_.clear();
        std::string bytes, layer_bytes;
        protozero::pbf_builder<LayerField> layer(layer_bytes);
        layer.add_uint32(LayerField::Version, 2);
        layer.add_string(LayerField::Name, kLayer.data(), kLayer.size());
        for (const TileDot& dot : dots) {
            protozero::pbf_builder<FeatureField> feature(layer, LayerField::Features);
            feature.add_uint64(FeatureField::Id, std::uint64_t{dot.rank} * points_.layers.size() + dot.layer);
            const auto tags = tags_of(dot);
            if (!tags.empty()) feature.add_packed_uint32(FeatureField::Tags, tags.begin(), tags.end());
            constexpr std::uint32_t kPoint = 1, kMoveOnce = 9;
            feature.add_enum(FeatureField::Type, static_cast<std::int32_t>(kPoint));
            const std::array geometry{kMoveOnce, 2 * place(dot.x, tile.column, zoom), 2 * place(dot.y, tile.row, zoom)};
            feature.add_packed_uint32(FeatureField::Geometry, geometry.begin(), geometry.end());
        }
        for (const std::string& key : keys_) layer.add_string(LayerField::Keys, key);
        for (const std::string& value : values_) layer.add_message(LayerField::Values, value);
        layer.add_uint32(LayerField::Extent, kExtent);
        protozero::pbf_builder<TileField>(bytes).add_message(TileField::Layers, layer_bytes);
        return gzipped(bytes);
    }

private:
    static std::uint32_t place(double share, std::uint32_t column, int zoom) {
        const double within = (std::ldexp(share, zoom) - column) * kExtent;
        return static_cast<std::uint32_t>(std::min(within, kExtent - 1.0));
    }

    /// Returns pairs of the number of a key and of a value.
    std::vector<std::uint32_t> tags_of(const TileDot& dot) {
        std::vector<std::uint32_t> tags;
        if (has_classes_) tags.insert(tags.end(), {0, number_of(text(points_.layers[dot.layer].ink.name))});
        if (points_.properties == nullptr) return tags;
        for (const auto& [name, is_text, value] : points_.properties->of_feature[dot.feature]) {
            if (!is_text && value == "null") continue;
            tags.insert(tags.end(), {name + has_classes_, number_of(is_text ? text(value) : scalar(value))});
        }
        return tags;
    }

    std::uint32_t number_of(const std::string& value) {
        const auto [place, is_new] = numbers_.try_emplace(value, static_cast<std::uint32_t>(values_.size()));
        if (is_new) values_.push_back(value);
        return place->second;
    }

    static std::string text(std::string_view value) {
        std::string bytes;
        protozero::pbf_builder<ValueField>(bytes).add_string(ValueField::Text, value.data(), value.size());
        return bytes;
    }

    /// Returns a value of JSON that is no text. Lists and objects become text.
    static std::string scalar(const std::string& json) {
        std::string bytes;
        protozero::pbf_builder<ValueField> message(bytes);
        if (json == "true" || json == "false") {
            message.add_bool(ValueField::Boolean, json == "true");
        } else if (const auto number = parse_number<double>(json)) {
            message.add_double(ValueField::Number, *number);
        } else {
            return text(json);
        }
        return bytes;
    }

    const PointSet& points_;
    bool has_classes_;
    std::vector<std::string> keys_;
    std::vector<std::string> values_;               ///< of the current tile
    std::map<std::string, std::uint32_t> numbers_;  ///< numbers of the values
};

/// The root directory, and the directories to which it refers if the tiles are many.
struct Directories {
    std::string root, leaves;
};

Directories directories_of(std::span<const TileEntry> entries) {
    constexpr std::size_t kMaxRoot = 16'384 - 127;
    Directories made{write_directory(entries), {}};
    for (std::size_t size = 4'096; made.root.size() > kMaxRoot; size *= 2) {
        made.leaves.clear();
        std::vector<TileEntry> roots;
        for (std::size_t first = 0; first < entries.size(); first += size) {
            const std::string leaf = write_directory(entries.subspan(first, std::min(size, entries.size() - first)));
            roots.push_back({entries[first].id, made.leaves.size(), leaf.size(), 0});
            made.leaves += leaf;
        }
        made.root = write_directory(roots);
    }
    return made;
}

std::string metadata_of(const TileWriter& writer, const PointSet& points, int min_zoom, int max_zoom) {
    std::string json = R"({"name":"dots","description":"Dots spread evenly at every zoom","vector_layers":[{"id":")";
    json.append(kLayer).append(R"(","minzoom":)").append(std::to_string(min_zoom));
    json.append(R"(,"maxzoom":)").append(std::to_string(max_zoom)).append(R"(,"fields":{)");
    for (std::size_t i = 0; i < writer.keys().size(); ++i) {
        if (i > 0) json += ',';
        append_json_text(json, writer.keys()[i]);
        json += points.are_named() && i == 0 ? R"(:"String")" : R"(:"Mixed")";
    }
    return json += "}}]}";
}

/// Sets the bounds of an archive.
void set_bounds(const PointSet& points, TileArchive& archive) {
    archive.min = {180, 90};
    archive.max = {-180, -90};
    for (const InkDots& layer : points.layers) {
        for (Point p : layer.dots.points) {
            p.x -= 360 * std::floor((p.x + 180) / 360);
            archive.min = {std::min(archive.min.x, p.x), std::min(archive.min.y, p.y)};
            archive.max = {std::max(archive.max.x, p.x), std::max(archive.max.y, p.y)};
        }
    }
}

/// Returns the numbers of dots of the layers that a zoom shows.
std::vector<std::uint32_t> counts_at(const PointSet& points, int zooms_before_last) {
    std::vector<std::uint32_t> counts;
    for (const InkDots& layer : points.layers) {
        const double all = static_cast<double>(layer.dots.points.size());
        counts.push_back(static_cast<std::uint32_t>(std::llround(std::ldexp(all, -2 * zooms_before_last))));
    }
    return counts;
}

}  // namespace

void write_dot_tiles(const PointSet& points, Body& body, const std::stop_token& stop) {
    const std::vector<TileDot> dots = dots_of(points);
    const int min_zoom = points.tiles.min_zoom;
    const int max_zoom = points.tiles.max_zoom ? *points.tiles.max_zoom : find_last_zoom(dots, points.tiles);
    TileWriter writer(points);
    std::vector<TileEntry> entries;
    std::string tiles;
    std::vector<std::pair<Tile, TileDot>> shown;
    for (int zoom = min_zoom; zoom <= max_zoom && !stop.stop_requested(); ++zoom) {
        const auto counts = counts_at(points, max_zoom - zoom);
        shown.clear();
        for (const TileDot& dot : dots) {
            if (dot.rank < counts[dot.layer]) shown.emplace_back(tile_of(dot, zoom), dot);
        }
        std::ranges::stable_sort(shown, {}, [](const auto& each) { return each.first.id; });
        std::vector<TileDot> inside;
        for (std::size_t first = 0; first < shown.size() && !stop.stop_requested(); first += inside.size()) {
            const Tile tile = shown[first].first;
            inside.clear();
            for (std::size_t i = first; i < shown.size() && shown[i].first.id == tile.id; ++i)
                inside.push_back(shown[i].second);
            const std::string bytes = writer.write(inside, tile, zoom);
            entries.push_back({tile.id, tiles.size(), bytes.size(), 1});
            tiles += bytes;
        }
    }
    const auto [root, leaves] = directories_of(entries);
    const std::string metadata = gzipped(metadata_of(writer, points, min_zoom, max_zoom));
    TileArchive archive;
    archive.entries = entries.size();
    archive.min_zoom = min_zoom;
    archive.max_zoom = max_zoom;
    set_bounds(points, archive);
    std::uint64_t offset = TileArchive::kHeader;
    const auto place = [&](TileArchive::Section& section, std::size_t length) {
        section = {std::exchange(offset, offset + length), length};
    };
    place(archive.root, root.size());
    place(archive.metadata, metadata.size());
    place(archive.leaves, leaves.size());
    place(archive.tiles, tiles.size());
    std::string& out = body.text();
    out += write_header(archive);
    out.append(root).append(metadata).append(leaves);
    for (std::size_t at = 0; at < tiles.size() && body.flush() && !stop.stop_requested(); at += Body::kPiece)
        out.append(tiles, at, Body::kPiece);
}

}  // namespace ccdt::api
