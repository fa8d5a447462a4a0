// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/off.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "api/surface/words.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

bool take_prefix(std::string_view& text, std::string_view prefix) {
    if (!text.starts_with(prefix)) return false;
    text.remove_prefix(prefix.size());
    return true;
}

/// The keyword of a file, whose prefixes state the properties of vertices.
struct Keyword {
    bool has_texture = false;
    bool has_colours = false;
    bool has_normals = false;
    bool is_three_dimensional = true;
    bool has_usual_order = true;  ///< order ST, C, N; programs disagree about other orders
    std::string_view number;      ///< that follows without a blank
};

std::optional<Keyword> keyword_in(std::string_view word) {
    Keyword keyword;
    if (word == "off") return keyword;
    keyword.has_texture = take_prefix(word, "ST");
    keyword.has_colours = take_prefix(word, "C");
    keyword.has_normals = take_prefix(word, "N");
    if (keyword.has_normals && !keyword.has_colours && take_prefix(word, "C")) {  // MeshLab
        keyword.has_colours = true;
        keyword.has_usual_order = false;
        keyword.has_texture |= take_prefix(word, "ST");
    }
    const bool has_weight = take_prefix(word, "4"), has_dimension = take_prefix(word, "n");
    keyword.is_three_dimensional = !has_weight && !has_dimension;
    if (!take_prefix(word, "OFF")) return std::nullopt;
    if (!word.empty() && !parse_number<std::uint32_t>(word)) return std::nullopt;
    keyword.number = word;
    return keyword;
}

/// Beginning of a file.
struct Header {
    Keyword keyword;
    std::uint32_t vertices = 0, faces = 0;
    bool has_edges = false;  ///< whether the number of edges is in the line of the number of faces
    bool has_lines = false;  ///< whether the numbers of vertices and faces are in lines of their own
    Words data;              ///< the vertices and faces
};

tl::unexpected<Error> wrong(const std::string& reason) {
    return unusable_surface(SurfaceFormat::Off, reason);
}

Result<Header> read_header(std::string_view text) {
    Words words(text);
    const auto keyword = keyword_in(words.next());
    if (!keyword) return wrong("it does not begin with OFF");
    if (!keyword->is_three_dimensional) return wrong("vertices with other than three coordinates are not supported");
    std::string_view word = keyword->number.empty() ? words.next() : keyword->number;
    if (word == "BINARY") return wrong("binary OFF is not supported; send a text, or a binary PLY");
    const auto vertices = parse_number<std::uint32_t>(word);
    const std::size_t line = words.line();
    word = words.next();
    const auto faces = parse_number<std::uint32_t>(word);
    if (!vertices || !faces)
        return wrong(words.position() + "the numbers of vertices and faces do not follow the keyword");
    const bool has_edges = !words.next_in_line().empty();
    return Header{*keyword, *vertices, *faces, has_edges, words.line() > line, words};
}

/// Interpretation of the lines of a file.
struct Layout {
    bool has_rows = true;        ///< whether each vertex and each face begins a line
    bool has_edge_line = false;  ///< whether the number of edges is in a line of its own
};

/// Reads the vertices and faces of a file.
template <class Sink>
class ElementReader {
public:
    ElementReader(const Header& header, Layout layout, Sink& sink)
        : keyword_(header.keyword), layout_(layout), words_(header.data), sink_(sink) {}

    Result<void> read(const Header& header) {
        if (layout_.has_edge_line) words_.next();
        for (std::uint32_t i = 0; i < header.vertices; ++i) {
            if (auto right = read_vertex(i); !right) return right;
        }
        for (std::uint32_t i = 0; i < header.faces; ++i) {
            if (auto right = read_face(i); !right) return right;
        }
        if (const std::string_view word = words_.next(); !word.empty())
            return wrong(words_.position() + "there is " + quoted(word) + " after the last face");
        return {};
    }

private:
    Result<double> next_number(std::string_view element, std::uint32_t i) {
        const std::string_view word = words_.next();
        if (!Sink::kReads && !word.empty()) return 0;
        if (const auto number = number_in(word)) return *number;
        return wrong(
            words_.position() + std::string(element) + ' ' + std::to_string(i) +
            (word.empty() ? " is incomplete, because the file ends" : " has " + quoted(word) + " instead of a number"));
    }

    Result<void> read_vertex(std::uint32_t i) {
        std::array<double, 6> at{};  // and the normal
        const bool has_normal_here = keyword_.has_normals && keyword_.has_usual_order;
        for (std::size_t k = 0; k < (has_normal_here ? 6 : 3); ++k) {
            const auto number = next_number("vertex", i);
            if (!number) return tl::unexpected(number.error());
            at[k] = *number;
        }
        sink_.vertex({at[0], at[1], at[2]}, words_.line());
        more_.clear();
        const std::size_t needed =
            (keyword_.has_colours ? 4 : 0) + (keyword_.has_texture ? 2 : 0) + (keyword_.has_usual_order ? 0 : 3);
        constexpr std::size_t kMax = 9;
        while (layout_.has_rows ? more_.size() <= kMax : more_.size() < needed) {
            const std::string_view word = layout_.has_rows ? words_.next_in_line() : words_.next();
            if (layout_.has_rows && word.empty()) break;
            const auto number = Sink::kReads ? number_in(word) : word.empty() ? std::nullopt : std::optional(0.0);
            if (!number) return wrong(words_.position() + "vertex " + std::to_string(i) + " has an invalid colour");
            more_.push_back(*number);
        }
        return add_properties(i, needed);
    }

    /// @param needed  number of the numbers of a vertex after its position and normal
    Result<void> add_properties(std::uint32_t i, std::size_t needed) {
        const bool lacks_alpha = keyword_.has_colours && more_.size() + 1 == needed;
        if (needed > 0 && more_.size() != needed && !lacks_alpha)
            return wrong(words_.position() + "vertex " + std::to_string(i) +
                         " has not as many numbers as the keyword states");
        if (needed == 0 && !more_.empty()) {
            if (more_.size() < 3 || more_.size() > 4)
                return wrong(words_.position() + "vertex " + std::to_string(i) + " has further numbers");
            sink_.warn("numbers after the positions of vertices are ignored", "vertex " + std::to_string(i));
            return {};
        }
        if (!keyword_.has_usual_order) {
            sink_.warn("normals, colours and texture coordinates are ignored, because their order is not known",
                       "vertex " + std::to_string(i));
            return {};
        }
        if (keyword_.has_colours) sink_.colour({more_[0], more_[1], more_[2]});
        if (keyword_.has_texture) sink_.texture({more_[more_.size() - 2], more_.back()});
        return {};
    }

    Result<void> read_face(std::uint32_t i) {
        const std::string_view word = words_.next();
        const FacePlace position{i, words_.line()};
        const auto size = parse_number<std::uint32_t>(word);
        if (!size)
            return wrong(word.empty() ? "it ends before face " + std::to_string(i)
                                      : position.text() + " begins with " + quoted(word) + " instead of its size");
        corners_.clear();
        for (std::uint32_t k = 0; k < *size; ++k) {
            const std::string_view corner = words_.next();
            const auto index = Sink::kReads || corner.empty() ? parse_number<std::uint32_t>(corner) : 0;
            if (!index)
                return wrong(position.text() + (corner.empty() ? " is incomplete, because the file ends"
                                                               : " refers to vertex " + quoted(corner)));
            if constexpr (Sink::kReads) corners_.push_back(*index);
        }
        if (layout_.has_rows) {
            constexpr int kMax = 4;
            for (int colour = 0; !words_.next_in_line().empty(); ++colour) {
                if (colour == kMax) return wrong(position.text() + " has too many numbers");
            }
        }
        if constexpr (Sink::kReads)
            return sink_.face(corners_, position);
        else
            return sink_.face(*size, position);
    }

    const Keyword& keyword_;
    Layout layout_;
    Words words_;
    Sink& sink_;
    std::vector<double> more_;
    std::vector<std::uint32_t> corners_;
};

/// Returns the first layout with which a file can be read.
Result<Layout> layout_of(const Header& header) {
    std::optional<Error> first;
    for (const bool has_edge_line : {header.has_lines && !header.has_edges, !header.has_lines}) {
        for (const bool has_rows : {true, false}) {
            const Layout layout{has_rows, has_edge_line};
            SurfaceCounter counter(SurfaceFormat::Off);
            const auto right = ElementReader(header, layout, counter).read(header);
            if (right) return layout;
            if (!first) first = right.error();
        }
        if (header.has_edges) break;
    }
    return tl::unexpected(*first);
}

}  // namespace

bool is_off(std::string_view text) {
    return keyword_in(Words(text).next()).has_value();
}

template <class Sink>
Result<void> read_off(std::string_view text, Sink& sink) {
    const auto header = read_header(text);
    if (!header) return tl::unexpected(header.error());
    return layout_of(*header).and_then(
        [&](Layout layout) { return ElementReader<Sink>(*header, layout, sink).read(*header); });
}

template Result<void> read_off(std::string_view, SurfaceCounter&);
template Result<void> read_off(std::string_view, SurfaceBuilder&);

}  // namespace ccdt::api
