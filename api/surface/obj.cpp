// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/obj.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "api/surface/words.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

enum class Statement { Vertex, Texture, Face, PointOrLine, Name, Curve, Unknown };

Statement statement_of(std::string_view word) {
    if (word == "v") return Statement::Vertex;
    if (word == "f" || word == "fo") return Statement::Face;
    if (word == "vt") return Statement::Texture;
    const auto is_any_of = [word](auto... names) { return ((word == names) || ...); };
    if (is_any_of("vn", "o", "g", "s", "usemtl", "mtllib", "mg", "usemap", "maplib", "lod", "bevel", "c_interp",
                  "d_interp", "shadow_obj", "trace_obj"))
        return Statement::Name;
    if (is_any_of("p", "l")) return Statement::PointOrLine;
    if (is_any_of("vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp",
                  "end", "con", "ctech", "stech"))
        return Statement::Curve;
    return Statement::Unknown;
}

template <class Sink>
class StatementReader {
public:
    StatementReader(std::string_view text, Sink& sink) : words_(text), sink_(sink) {}

    Result<void> read() {
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
            if (auto right = read_statement(word); !right) return right;
        }
        return add_corners();
    }

private:
    /// An index of a corner that must be checked at the end, because it may refer to a later statement.
    struct Largest {
        std::uint32_t index = 0;
        FacePlace position;
    };
    using Colour = std::array<double, 3>;

    static constexpr std::uint32_t kNone = ~std::uint32_t{0};
    static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    static constexpr Colour kNoColour{kNaN, kNaN, kNaN};

    tl::unexpected<Error> wrong(const std::string& reason) const {
        return unusable_surface(SurfaceFormat::Obj, words_.position() + reason);
    }

    static tl::unexpected<Error> wrong_corner(std::string_view word, const FacePlace& position, std::string_view why) {
        return unusable_surface(SurfaceFormat::Obj,
                                position.text() + " has the corner " + quoted(word) + ", which " + std::string(why));
    }

    Result<void> read_statement(std::string_view word) {
        switch (statement_of(word)) {
            case Statement::Vertex:
                return read_vertex();
            case Statement::Texture:
                return read_texture();
            case Statement::Face:
                return read_face();
            case Statement::Name:
                words_.skip_line();  // a path may end with a backslash
                return {};
            case Statement::PointOrLine:
                sink_.warn("points and lines, which have no area, are ignored",
                           "line " + std::to_string(words_.line()));
                break;
            case Statement::Curve:
                sink_.warn("statements of curves are ignored", "line " + std::to_string(words_.line()));
                break;
            case Statement::Unknown:
                sink_.warn("unknown statements are ignored",
                           quoted(word) + " in line " + std::to_string(words_.line()));
                break;
        }
        while (!words_.next_in_line().empty()) {
        }
        return {};
    }

    /// Reads the numbers of a statement.
    /// @returns  their number
    template <std::size_t kSize>
    Result<std::size_t> read_numbers(std::array<double, kSize>& numbers) {
        std::size_t size = 0;
        for (std::string_view word = words_.next_in_line(); !word.empty(); word = words_.next_in_line()) {
            const auto number = Sink::kReads ? number_in(word) : 0;
            if (!number) return wrong(quoted(word) + " is not a number");
            if (size == kSize) return wrong("the statement has more than " + std::to_string(kSize) + " numbers");
            numbers[size++] = *number;
        }
        return size;
    }

    Result<void> read_vertex() {
        std::array<double, 7> n{};
        const auto size = read_numbers(n);
        if (!size) return tl::unexpected(size.error());
        if (*size < 3 || *size == 5) return wrong("a vertex has " + std::to_string(*size) + " numbers");
        if constexpr (!Sink::kReads) {
            constexpr std::uint64_t kVertex = 2 * (sizeof(Point3) + sizeof(Colour));  // while the vectors grow
            sink_.need(kVertex);
        } else {
            Point3 at{n[0], n[1], n[2]};
            if (*size == 4 && n[3] == 0) {
                at.x = std::numeric_limits<double>::infinity();
            } else if (*size == 4 && n[3] != 1) {
                at = {n[0] / n[3], n[1] / n[3], n[2] / n[3]};
                sink_.warn("coordinates are divided by the fourth one", "line " + std::to_string(words_.line()));
            }
            if (!(std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z)))
                not_finite_.emplace_back(static_cast<std::uint32_t>(positions_.size()), words_.line());
            positions_.push_back(at);
            if (*size >= 6) {
                colours_.resize(positions_.size() - 1, kNoColour);
                colours_.push_back({n[3], n[4], n[5]});
            }
        }
        return {};
    }

    Result<void> read_texture() {
        std::array<double, 3> n{};
        if (const auto size = read_numbers(n); !size) return tl::unexpected(size.error());
        if constexpr (Sink::kReads)
            texture_.push_back({n[0], n[1]});
        else
            sink_.need(2 * sizeof(std::array<double, 2>));
        return {};
    }

    Result<void> read_face() {
        const FacePlace position{faces_++, words_.line()};
        std::vector<std::array<std::uint32_t, 2>>& corners = corners_;
        const std::size_t first = corners.size();
        std::size_t size = 0;
        bool ends_in_slash = false;  // whether the corner before does
        for (std::string_view word = words_.next_in_line(); !word.empty(); word = words_.next_in_line(), ++size) {
            if constexpr (Sink::kReads) {
                if (auto right = read_corner(word, position); !right) return right;
                const bool has_slash = word.find('/') != std::string_view::npos;
                if (ends_in_slash && !has_slash)
                    return wrong_corner(word, position, "follows a slash and a blank, so it may be another number");
                ends_in_slash = word.ends_with('/');
            }
        }
        if constexpr (Sink::kReads) {
            numbers_.clear();
            for (std::size_t i = first; i < corners.size(); ++i) numbers_.push_back(static_cast<std::uint32_t>(i));
            if (size < 3) corners.resize(first);
            return sink_.face(numbers_, position);
        } else {
            if (size > 2) sink_.need(2 * sizeof(corners[0]) * size);
            for (std::size_t i = 0; size > 2 && i < size; ++i) sink_.vertex({}, 0);
            return sink_.face(size, position);
        }
    }

    /// Reads a corner: the number of a vertex and, after slashes, of texture coordinates and a normal.
    Result<void> read_corner(std::string_view word, const FacePlace& position) {
        std::string_view rest = word;
        const auto vertex = resolve(take_until(rest, "/"), positions_.size(), position, largest_vertex_);
        const std::string_view second = take_until(rest, "/");
        if (!vertex) return wrong_corner(word, position, "refers to no vertex");
        auto texture = kNone;
        if (!second.empty()) {
            const auto found = resolve(second, texture_.size(), position, largest_texture_);
            if (!found) largest_texture_ = {kNone, position};
            texture = found.value_or(kNone);
        }
        corners_.push_back({*vertex, texture});
        return {};
    }

    /// Returns the index of a number that counts from 1, or backwards from the last statement with -1.
    static std::optional<std::uint32_t> resolve(std::string_view word, std::size_t size, const FacePlace& position,
                                                Largest& largest) {
        if (word.starts_with('+')) word.remove_prefix(1);
        const auto number = parse_number<std::int64_t>(word);
        if (!number || *number == 0 || *number > static_cast<std::int64_t>(kNone)) return std::nullopt;
        const std::int64_t index = *number > 0 ? *number - 1 : static_cast<std::int64_t>(size) + *number;
        if (index < 0) return std::nullopt;
        if (index >= largest.index) largest = {static_cast<std::uint32_t>(index), position};
        return static_cast<std::uint32_t>(index);
    }

    Result<void> add_corners() {
        if (!corners_.empty() && largest_vertex_.index >= positions_.size())
            return unusable_surface(SurfaceFormat::Obj, largest_vertex_.position.text() + " refers to vertex " +
                                                            std::to_string(std::uint64_t{largest_vertex_.index} + 1) +
                                                            ", but there are only " +
                                                            std::to_string(positions_.size()));
        const bool has_texture = largest_texture_.index < texture_.size();
        if (!has_texture && largest_texture_.position.line > 0)
            sink_.warn("texture coordinates are ignored, because faces refer to missing ones",
                       largest_texture_.position.text());
        if (!colours_.empty()) colours_.resize(positions_.size(), kNoColour);
        for (const auto& [vertex, texture] : corners_) {
            const auto found = std::ranges::lower_bound(not_finite_, std::pair(vertex, std::size_t{0}));
            if (found != not_finite_.end() && found->first == vertex)
                return unusable_surface(SurfaceFormat::Obj, "vertex " + std::to_string(vertex) + " (line " +
                                                                std::to_string(found->second) + ") is not finite");
            sink_.vertex(positions_[vertex], 0);
            if (!colours_.empty()) sink_.colour(colours_[vertex]);
            if (has_texture && texture != kNone) sink_.texture(texture_[texture]);
        }
        return {};
    }

    Words words_;
    Sink& sink_;
    std::uint64_t faces_ = 0;
    std::vector<Point3> positions_;
    std::vector<Colour> colours_;  ///< [positions], or empty
    std::vector<std::array<double, 2>> texture_;
    std::vector<std::array<std::uint32_t, 2>> corners_;              ///< indices of positions and texture coordinates
    std::vector<std::uint32_t> numbers_;                             ///< corners of the current face
    std::vector<std::pair<std::uint32_t, std::size_t>> not_finite_;  ///< vertices and their lines
    Largest largest_vertex_, largest_texture_;
};

}  // namespace

bool is_obj(std::string_view text) {
    constexpr int kSearched = 100;
    Words words(text);
    const Statement first = statement_of(words.next());
    if (first != Statement::Unknown && first != Statement::Curve) return true;
    for (int line = 1; line < kSearched; ++line) {
        words.skip_line();
        if (words.next() != "v") continue;
        int numbers = 0;
        while (number_in(words.next_in_line())) ++numbers;
        if (numbers >= 3) return true;
    }
    return false;
}

std::string_view materials_of_obj(std::string_view text) {
    Words words(text);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        if (word == "mtllib") return words.next_in_line();
        words.skip_line();
    }
    return {};
}

template <class Sink>
Result<void> read_obj(std::string_view text, Sink& sink) {
    return StatementReader<Sink>(text, sink).read();
}

template Result<void> read_obj(std::string_view, SurfaceCounter&);
template Result<void> read_obj(std::string_view, SurfaceBuilder&);

}  // namespace ccdt::api
