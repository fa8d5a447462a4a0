// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "api/surface/bytes.h"
#include "api/surface/words.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMaxElements = 100, kMaxProperties = 1000;

std::optional<PlyType> type_named(std::string_view name) {
    constexpr auto kNames = std::to_array<std::pair<std::string_view, std::string_view>>({{"char", "int8"},
                                                                                          {"uchar", "uint8"},
                                                                                          {"short", "int16"},
                                                                                          {"ushort", "uint16"},
                                                                                          {"int", "int32"},
                                                                                          {"uint", "uint32"},
                                                                                          {"float", "float32"},
                                                                                          {"double", "float64"}});
    const auto found =
        std::ranges::find_if(kNames, [name](const auto& each) { return each.first == name || each.second == name; });
    if (found == kNames.end()) return std::nullopt;
    return static_cast<PlyType>(found - kNames.begin());
}

/// Returns the value of a type that stands for full light.
double white_of(PlyType type) {
    if (type == PlyType::Int16 || type == PlyType::Uint16) return std::numeric_limits<std::uint16_t>::max();
    return type == PlyType::Float32 || type == PlyType::Float64 ? 1 : std::numeric_limits<std::uint8_t>::max();
}

tl::unexpected<Error> wrong_header(std::size_t line, const std::string& reason) {
    return unusable_surface(SurfaceFormat::Ply, "line " + std::to_string(line) + ": " + reason);
}

/// Numbers of a binary PLY.
class BinaryNumbers {
public:
    BinaryNumbers(std::string_view bytes, const PlyHeader& header)
        : bytes_(bytes),
          at_(header.size),
          order_(header.encoding == PlyHeader::Encoding::BigEndian ? std::endian::big : std::endian::little) {}

    /// Reads a number; returns none at the end of the file.
    std::optional<double> next(PlyType type) {
        if (!skip(type, 1)) return std::nullopt;
        switch (const char* const at = bytes_.data() + at_ - size_of(type); type) {
            case PlyType::Int8:
                return number_at<std::int8_t>(at);
            case PlyType::Uint8:
                return number_at<std::uint8_t>(at);
            case PlyType::Int16:
                return number_at<std::int16_t>(at, order_);
            case PlyType::Uint16:
                return number_at<std::uint16_t>(at, order_);
            case PlyType::Int32:
                return number_at<std::int32_t>(at, order_);
            case PlyType::Uint32:
                return number_at<std::uint32_t>(at, order_);
            case PlyType::Float32:
                return number_at<float>(at, order_);
            case PlyType::Float64:
                return number_at<double>(at, order_);
        }
        return std::nullopt;
    }

    /// Returns false if so many numbers are not left.
    bool skip(PlyType type, std::uint64_t numbers) {
        if (numbers > (bytes_.size() - at_) / size_of(type)) return false;
        at_ += size_of(type) * static_cast<std::size_t>(numbers);
        return true;
    }

    std::size_t line() const { return 0; }
    /// Whether the last number was missing because the file ends.
    static bool is_at_end() { return true; }
    std::string position() const { return "byte " + std::to_string(at_); }
    /// Returns the number of bytes before the next number.
    std::size_t offset() const { return at_; }

    /// Reports what follows the last element.
    template <class Sink>
    Result<void> finish(Sink& sink) const {
        if (at_ != bytes_.size())
            sink.warn("bytes after the last element are ignored", position(), bytes_.size() - at_);
        return {};
    }

private:
    std::string_view bytes_;
    std::size_t at_;
    std::endian order_;
};

/// Numbers of a text PLY. They may be on any lines.
class TextNumbers {
public:
    TextNumbers(std::string_view text, const PlyHeader& header)
        : size_(text.size()), words_(text.substr(header.size), header.lines + 1) {}

    std::optional<double> next(PlyType) {
        word_ = words_.next();
        return number_in(word_);
    }

    bool skip(PlyType, std::uint64_t numbers) {
        for (; numbers > 0; --numbers) {
            word_ = words_.next();
            if (word_.empty()) return false;
        }
        return true;
    }

    std::size_t line() const { return words_.line(); }
    bool is_at_end() const { return word_.empty(); }
    std::string position() const { return "line " + std::to_string(words_.line()); }
    std::size_t offset() const { return size_ - words_.left(); }

    template <class Sink>
    Result<void> finish(Sink&) {
        word_ = words_.next();
        if (word_.empty()) return {};
        return unusable_surface(SurfaceFormat::Ply, position() + ": there is " + quoted(word_) +
                                                        " after the last element; do its rows have more numbers than "
                                                        "the header announces?");
    }

private:
    std::size_t size_;
    Words words_;
    std::string_view word_;
};

/// Meanings of properties of vertices.
enum class Meaning : std::uint8_t { X, Y, Z, Red, Green, Blue, S, T, None };

Meaning meaning_of(const PlyProperty& property) {
    constexpr auto kNames = std::to_array<std::pair<std::string_view, Meaning>>(
        {{"x", Meaning::X},         {"y", Meaning::Y},        {"z", Meaning::Z},
         {"red", Meaning::Red},     {"r", Meaning::Red},      {"diffuse_red", Meaning::Red},
         {"green", Meaning::Green}, {"g", Meaning::Green},    {"diffuse_green", Meaning::Green},
         {"blue", Meaning::Blue},   {"b", Meaning::Blue},     {"diffuse_blue", Meaning::Blue},
         {"s", Meaning::S},         {"u", Meaning::S},        {"tx", Meaning::S},
         {"texture_u", Meaning::S}, {"t", Meaning::T},        {"v", Meaning::T},
         {"ty", Meaning::T},        {"texture_v", Meaning::T}});
    const auto found = std::ranges::find(kNames, property.name, [](const auto& each) { return each.first; });
    return property.is_list || found == kNames.end() ? Meaning::None : found->second;
}

bool is_corners(const PlyProperty& property) {
    return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Keeps properties of vertices, and the places of their rows.
struct RowSink {
    static constexpr bool kReads = true, kIsMesh = false;

    std::span<const std::string_view> names;
    PlyRows rows;

    void warn(const char*, const std::string&, std::size_t = 1) {}
};

/// Reads the elements of a PLY.
template <class Numbers, class Sink>
class ElementReader {
public:
    ElementReader(Numbers numbers, Sink& sink) : numbers_(std::move(numbers)), sink_(sink) {}

    Result<void> read(const PlyHeader& header) {
        for (const PlyElement& element : header.elements) {
            if (element.properties.empty()) continue;
            if (auto right = read_element(element); !right) return right;
        }
        return numbers_.finish(sink_);
    }

private:
    Result<void> read_element(const PlyElement& element) {
        if constexpr (Sink::kIsMesh) {
            if (element.name == "vertex") return read_vertices(element);
            if (element.name == "face" || element.name == "tristrips") return read_faces(element);
        } else {
            if (element.name == "vertex") return read_rows(element);
        }
        return skip_rows(element);
    }

    tl::unexpected<Error> wrong(const PlyElement& element, std::uint64_t row, std::string_view reason) const {
        return unusable_surface(SurfaceFormat::Ply, numbers_.position() + ": " +
                                                        std::string(element.name.substr(0, 30)) + ' ' +
                                                        std::to_string(row) + " of " + std::to_string(element.count) +
                                                        ' ' + std::string(reason));
    }

    /// Returns the error of a number that is missing or invalid.
    tl::unexpected<Error> missing(const PlyElement& element, std::uint64_t row) const {
        return wrong(element, row, numbers_.is_at_end() ? "is incomplete, because the file ends" : "is not a number");
    }

    /// Reads the size of a list.
    Result<std::uint64_t> read_count(const PlyElement& element, const PlyProperty& property, std::uint64_t row) {
        const auto count = numbers_.next(property.count);
        if (!count) return missing(element, row);
        if (*count >= 0 && *count == std::floor(*count) && *count <= 0xFFFFFFFF)
            return static_cast<std::uint64_t>(*count);
        return wrong(element, row, "has a list of invalid size");
    }

    Result<void> skip_property(const PlyElement& element, const PlyProperty& property, std::uint64_t row) {
        std::uint64_t count = 1;
        if (property.is_list) {
            const auto read = read_count(element, property, row);
            if (!read) return tl::unexpected(read.error());
            count = *read;
        }
        if (numbers_.skip(property.type, count)) return {};
        return wrong(element, row, "is incomplete, because the file ends");
    }

    Result<void> skip_rows(const PlyElement& element) {
        for (std::uint64_t row = 0; row < element.count; ++row) {
            for (const PlyProperty& property : element.properties) {
                if (auto right = skip_property(element, property, row); !right) return right;
            }
        }
        return {};
    }

    /// Reads the named properties of vertices.
    Result<void> read_rows(const PlyElement& element) {
        const std::size_t properties = element.properties.size();
        std::vector<double> values(properties + 1, std::numeric_limits<double>::quiet_NaN());
        std::vector<bool> is_read(properties);
        std::vector<std::size_t> sources;
        for (const std::string_view name : sink_.names) {
            const auto is_named = [name](const PlyProperty& each) { return each.name == name && !each.is_list; };
            const auto found = std::ranges::find_if(element.properties, is_named);
            sources.push_back(static_cast<std::size_t>(found - element.properties.begin()));
            if (sources.back() < properties) is_read[sources.back()] = true;
        }
        sink_.rows.ends.push_back(numbers_.offset());
        for (std::uint64_t row = 0; row < element.count; ++row) {
            for (std::size_t i = 0; i < properties; ++i) {
                const PlyProperty& property = element.properties[i];
                if (!is_read[i]) {
                    if (auto right = skip_property(element, property, row); !right) return right;
                    continue;
                }
                const auto number = numbers_.next(property.type);
                if (!number) return missing(element, row);
                values[i] = *number;
            }
            for (std::size_t i = 0; i < sources.size(); ++i) sink_.rows.columns[i].push_back(values[sources[i]]);
            sink_.rows.ends.push_back(numbers_.offset());
        }
        return {};
    }

    Result<void> read_vertices(const PlyElement& element) {
        std::array<bool, 9> has{};
        std::vector<Meaning> meanings;
        for (const PlyProperty& property : element.properties) {
            meanings.push_back(meaning_of(property));
            has[static_cast<std::size_t>(meanings.back())] = true;
        }
        if (!(has[0] && has[1] && has[2]))
            return unusable_surface(SurfaceFormat::Ply, "its vertices lack one of the properties x, y and z");
        const bool has_colour = has[3] && has[4] && has[5], has_texture = has[6] && has[7];
        for (std::uint64_t row = 0; row < element.count; ++row) {
            std::array<double, 9> values{};
            values.fill(std::numeric_limits<double>::quiet_NaN());
            for (std::size_t i = 0; i < meanings.size(); ++i) {
                const PlyProperty& property = element.properties[i];
                if (meanings[i] == Meaning::None || !Sink::kReads) {
                    if (auto right = skip_property(element, property, row); !right) return right;
                    continue;
                }
                const auto number = numbers_.next(property.type);
                if (!number) return missing(element, row);
                const bool is_colour = meanings[i] >= Meaning::Red && meanings[i] <= Meaning::Blue;
                values[static_cast<std::size_t>(meanings[i])] = is_colour ? *number / white_of(property.type) : *number;
            }
            sink_.vertex({values[0], values[1], values[2]}, numbers_.line());
            if (has_colour) sink_.colour({values[3], values[4], values[5]});
            if (has_texture) sink_.texture({values[6], values[7]});
        }
        return {};
    }

    Result<void> read_faces(const PlyElement& element) {
        const auto corners = std::ranges::find_if(element.properties, is_corners);
        if (corners == element.properties.end())
            return unusable_surface(SurfaceFormat::Ply, "its faces have no list vertex_indices");
        for (std::uint64_t row = 0; row < element.count; ++row) {
            for (const PlyProperty& property : element.properties) {
                auto right = &property == &*corners ? read_corners(element, property, row)
                                                    : skip_property(element, property, row);
                if (!right) return right;
            }
        }
        if (std::ranges::find(element.properties, "texcoord", &PlyProperty::name) != element.properties.end())
            sink_.warn("texture coordinates of faces are ignored", "", static_cast<std::size_t>(element.count));
        return {};
    }

    Result<void> read_corners(const PlyElement& element, const PlyProperty& property, std::uint64_t row) {
        const auto count = read_count(element, property, row);
        if (!count) return tl::unexpected(count.error());
        const bool is_strip = element.name == "tristrips";
        const FacePlace position{row, numbers_.line()};
        if constexpr (!Sink::kReads) {
            if (!is_strip) {
                if (numbers_.skip(property.type, *count)) return sink_.face(static_cast<std::size_t>(*count), position);
                return wrong(element, row, "is incomplete, because the file ends");
            }
        }
        corners_.clear();
        for (std::uint64_t i = 0; i < *count; ++i) {
            const auto index = numbers_.next(property.type);
            if (!index) return missing(element, row);
            if (is_strip && *index == -1) {
                if (auto right = add_strip(position); !right) return right;
                corners_.clear();
            } else if (*index >= 0 && *index == std::floor(*index) && *index < 0xFFFFFFFF) {
                corners_.push_back(static_cast<std::uint32_t>(*index));
            } else {
                return wrong(element, row, "refers to an invalid vertex");
            }
        }
        return is_strip ? add_strip(position) : sink_.face(corners_, position);
    }

    /// Adds the triangles of a strip. Triangles that only connect two parts of the strip have two equal corners, and
    /// are left out.
    Result<void> add_strip(const FacePlace& position) {
        for (std::size_t i = 2; i < corners_.size(); ++i) {
            const std::uint32_t a = corners_[i - 2 + i % 2], b = corners_[i - 1 - i % 2], c = corners_[i];
            if (a == b || b == c || c == a) continue;
            if (auto right = sink_.face(std::array{a, b, c}, position); !right) return right;
        }
        return {};
    }

    Numbers numbers_;
    Sink& sink_;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

std::size_t size_of(PlyType type) {
    constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
    return kSizes[static_cast<std::size_t>(type)];
}

Result<PlyHeader> read_ply_header(std::string_view file) {
    PlyHeader header;
    const auto first = file.find_first_of("\r\n");
    const std::string_view end = first == std::string_view::npos   ? "\n"
                                 : file.substr(first, 2) == "\r\n" ? "\r\n"
                                                                   : file.substr(first, 1);
    bool has_format = false;
    std::size_t properties = 0;
    for (std::string_view rest = file; !rest.empty();) {
        // In a header whose lines end with CR and LF, some may end with LF only.
        const std::string_view text = take_until(rest, end == "\r" ? end : "\n");
        Words words(text);
        const std::size_t line = ++header.lines;
        const std::string_view word = words.next_in_line();
        if (word == "format") {
            const std::string_view name = words.next_in_line();
            has_format = true;
            if (name == "binary_little_endian")
                header.encoding = PlyHeader::Encoding::LittleEndian;
            else if (name == "binary_big_endian")
                header.encoding = PlyHeader::Encoding::BigEndian;
            else if (name != "ascii")
                return wrong_header(line, "the format " + quoted(name) + " is not supported");
        } else if (word == "element") {
            const std::string_view name = words.next_in_line();
            const auto count = parse_number<std::uint32_t>(words.next_in_line());
            if (!count) return wrong_header(line, "the number of elements is not an integer below 4294967296");
            if (std::ranges::find(header.elements, name, &PlyElement::name) != header.elements.end())
                return wrong_header(line, "there is another element " + quoted(name));
            if (header.elements.size() == kMaxElements)
                return wrong_header(line,
                                    "there are more than " + std::to_string(kMaxElements) + " elements, the limit");
            header.elements.push_back({name, *count});
        } else if (word == "property") {
            if (header.elements.empty()) return wrong_header(line, "the property has no element");
            if (++properties > kMaxProperties)
                return wrong_header(line,
                                    "there are more than " + std::to_string(kMaxProperties) + " properties, the limit");
            std::string_view type = words.next_in_line();
            PlyProperty property;
            property.is_list = type == "list";
            if (property.is_list) {
                const auto count = type_named(type = words.next_in_line());
                if (!count) return wrong_header(line, quoted(type) + " is not a type");
                property.count = *count;
                type = words.next_in_line();
            }
            const auto known = type_named(type);
            if (!known) return wrong_header(line, quoted(type) + " is not a type");
            property.type = *known;
            property.name = words.next_in_line();
            header.elements.back().properties.push_back(property);
        } else if (word == "end_header") {
            if (!has_format) return wrong_header(line, "the header states no format");
            header.size = file.size() - rest.size();
            return header;
        } else if (!word.empty() && word != "ply" && word != "comment" && word != "obj_info") {
            header.unknown.push_back(line);
        }
    }
    return unusable_surface(SurfaceFormat::Ply, "its header has no end");
}

std::uint64_t PlyHeader::count(std::string_view name) const {
    const auto found = std::ranges::find(elements, name, &PlyElement::name);
    return found == elements.end() ? 0 : found->count;
}

template <class Sink>
Result<void> read_ply(std::string_view file, Sink& sink) {
    const auto header = read_ply_header(file);
    if (!header) return tl::unexpected(header.error());
    for (const std::size_t line : header->unknown)
        sink.warn("unknown lines of the header are ignored", "line " + std::to_string(line));
    if (header->encoding == PlyHeader::Encoding::Text)
        return ElementReader<TextNumbers, Sink>(TextNumbers(file, *header), sink).read(*header);
    return ElementReader<BinaryNumbers, Sink>(BinaryNumbers(file, *header), sink).read(*header);
}

Result<PlyRows> read_ply_rows(std::string_view file, std::span<const std::string_view> names) {
    RowSink sink{names, {}};
    sink.rows.columns.resize(names.size());
    return read_ply(file, sink).map([&] { return std::move(sink.rows); });
}

std::string ply_header_for(std::string_view file, const PlyHeader& header, std::size_t vertices) {
    std::string out;
    bool is_left_out = false;
    for (std::string_view rest = file.substr(0, header.size); !rest.empty();) {
        const std::size_t end = rest.find_first_of("\r\n"), next = rest.find_first_not_of("\r\n", end);
        const std::string_view line = rest.substr(0, next);
        rest.remove_prefix(line.size());
        Words words(line);
        const std::string_view word = words.next_in_line();
        if (word == "element") {
            is_left_out = words.next_in_line() != "vertex";
            if (!is_left_out) out += "element vertex " + std::to_string(vertices) += line.substr(end);
        } else if (word != "property" || !is_left_out) {
            out += line;
        }
    }
    return out;
}

template Result<void> read_ply(std::string_view, SurfaceCounter&);
template Result<void> read_ply(std::string_view, SurfaceBuilder&);

}  // namespace ccdt::api
