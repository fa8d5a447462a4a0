// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/stl.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/surface/bytes.h"
#include "api/surface/words.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kHead = 84;   ///< text and number of facets, bytes
constexpr std::size_t kFacet = 50;  ///< bytes

std::uint64_t facets_of(std::string_view bytes) {
    return number_at<std::uint32_t>(bytes.data() + kHead - sizeof(std::uint32_t));
}

/// Reads the colours of facets. Magics announces a colour of the whole object in the header, and marks facets that have
/// this colour. VisCAM marks facets that have a colour.
class FacetColours {
public:
    explicit FacetColours(std::string_view head) {
        constexpr std::string_view kMark = "COLOR=";
        auto at = head.substr(0, kHead - 8).find(kMark);
        if (at == std::string_view::npos) return;
        object_.emplace();
        for (double& value : *object_) value = static_cast<unsigned char>(head[at++ + kMark.size()]) / 255.0;
    }

    std::optional<std::array<double, 3>> of(std::uint16_t attribute) const {
        const auto level = [attribute](int shift) { return (attribute >> shift & 31) / 31.0; };
        const bool is_marked = attribute >> 15 != 0;
        if (object_) return is_marked ? *object_ : Colour{level(0), level(5), level(10)};
        return is_marked ? std::optional(Colour{level(10), level(5), level(0)}) : std::nullopt;
    }

private:
    using Colour = std::array<double, 3>;

    std::optional<Colour> object_;
};

/// Reads the facets of a text.
template <class Sink>
class FacetReader {
public:
    FacetReader(std::string_view text, Sink& sink) : words_(text), sink_(sink) {}

    Result<void> read() {
        bool is_inside = false;  // a solid
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
            if (is_keyword(word, "solid") && !is_inside) {
                is_inside = true;
                skip_name();
            } else if (is_keyword(word, "endsolid") && is_inside) {
                is_inside = false;
                words_.skip_line();
            } else if (is_keyword(word, "facet") && is_inside) {
                if (auto facet = read_facet(); !facet) return facet;
            } else {
                return wrong(is_inside ? "facet or endsolid" : "solid", word);
            }
        }
        if (is_inside) sink_.warn("a solid has no end, so facets may be missing", "");
        return {};
    }

private:
    tl::unexpected<Error> wrong(std::string_view expected, std::string_view found) const {
        return unusable_surface(SurfaceFormat::StlText,
                                words_.position() + (found.empty() ? "the file ends" : quoted(found)) + " instead of " +
                                    std::string(expected) + ", in facet " + std::to_string(facets_));
    }

    /// Ignores the name of a solid: the rest of the line, or the words before a facet or the end of the solid in the
    /// same line.
    void skip_name() {
        Words next = words_;
        for (std::string_view word = next.next_in_line(); !word.empty(); word = next.next_in_line()) {
            const Words after = next;
            if ((is_keyword(word, "facet") && is_keyword(next.next_in_line(), "normal")) ||
                is_keyword(word, "endsolid"))
                return;
            next = after;
            words_ = next;
        }
        words_.skip_line();
    }

    Result<void> expect(std::string_view keyword) {
        const std::string_view word = words_.next();
        return is_keyword(word, keyword) ? Result<void>() : wrong(keyword, word);
    }

    Result<void> read_facet() {
        const FacePlace position{facets_, words_.line()};
        std::string_view word = words_.next();
        while (!word.empty() && !is_keyword(word, "outer")) word = words_.next();  // the normal
        if (word.empty()) return wrong("outer loop", word);
        if (auto loop = expect("loop"); !loop) return loop;
        corners_.clear();
        for (word = words_.next(); is_keyword(word, "vertex"); word = words_.next()) {
            std::array<double, 3> at{};
            for (double& ordinate : at) {
                word = words_.next();
                const auto number = Sink::kReads || word.empty() ? number_in(word) : 0;
                if (!number) return wrong("a number", word);
                ordinate = *number;
            }
            corners_.push_back(vertices_++);
            sink_.vertex({at[0], at[1], at[2]}, words_.line());
        }
        if (!is_keyword(word, "endloop") || corners_.size() < 3) return wrong("vertex", word);
        ++facets_;
        if (auto end = expect("endfacet"); !end) return end;
        return sink_.face(corners_, position);
    }

    Words words_;
    Sink& sink_;
    std::uint64_t facets_ = 0;
    std::uint32_t vertices_ = 0;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

bool is_text_stl(std::string_view bytes) {
    return is_keyword(Words(bytes).next(), "solid");
}

bool is_binary_stl(std::string_view bytes) {
    if (bytes.size() < kHead) return false;
    const std::size_t facets = (bytes.size() - kHead) / kFacet;
    if ((facets > 0 || bytes.size() == kHead) && facets_of(bytes) == facets) return true;
    return bytes.substr(0, kHead).find('\0') != std::string_view::npos && is_text_stl(bytes);
}

template <class Sink>
Result<void> read_text_stl(std::string_view text, Sink& sink) {
    return FacetReader<Sink>(text, sink).read();
}

template <class Sink>
Result<void> read_binary_stl(std::string_view bytes, Sink& sink) {
    constexpr auto kFormat = SurfaceFormat::StlBinary;
    if (bytes.size() < kHead)
        return unusable_surface(kFormat, "it ends at byte " + std::to_string(bytes.size()) + ", within its header");
    const std::uint64_t facets = facets_of(bytes), needed = kHead + kFacet * facets;
    if (needed > bytes.size())
        return unusable_surface(kFormat, "its header announces " + std::to_string(facets) + " facets, which need " +
                                             std::to_string(needed) + " bytes, but the file has " +
                                             std::to_string(bytes.size()));
    if (needed < bytes.size())
        sink.warn("bytes after the last facet are ignored", "byte " + std::to_string(needed), bytes.size() - needed);
    const FacetColours colours(bytes);
    for (std::uint32_t facet = 0; facet < facets; ++facet) {
        const char* const at = bytes.data() + kHead + kFacet * facet;
        const auto ordinate = [at](std::size_t i) { return double{number_at<float>(at + i * sizeof(float))}; };
        const auto colour = colours.of(number_at<std::uint16_t>(at + kFacet - sizeof(std::uint16_t)));
        for (std::size_t corner = 1; corner <= 3; ++corner) {
            sink.vertex({ordinate(3 * corner), ordinate(3 * corner + 1), ordinate(3 * corner + 2)}, 0);
            if (colour) sink.colour(*colour);
        }
        if (auto face = sink.face(std::array{3 * facet, 3 * facet + 1, 3 * facet + 2}, {facet, 0}); !face) return face;
    }
    return {};
}

template Result<void> read_text_stl(std::string_view, SurfaceCounter&);
template Result<void> read_text_stl(std::string_view, SurfaceBuilder&);
template Result<void> read_binary_stl(std::string_view, SurfaceCounter&);
template Result<void> read_binary_stl(std::string_view, SurfaceBuilder&);

}  // namespace ccdt::api
