// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/npy_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

/// A float of 2 bytes (IEEE 754 binary16).
enum class Half : std::uint16_t {};

double number_of(Half half) {
    constexpr int kFractionBits = 10, kMaxExponent = 31, kOffset = 25;
    const auto bits = static_cast<std::uint16_t>(half);
    const int fraction = bits & ((1 << kFractionBits) - 1), exponent = bits >> kFractionBits & kMaxExponent;
    double number =
        std::ldexp(exponent > 0 ? fraction + (1 << kFractionBits) : fraction, std::max(exponent, 1) - kOffset);
    if (exponent == kMaxExponent) number = fraction == 0 ? INFINITY : NAN;
    return bits >> 15 != 0 ? -number : number;
}

template <class Element>
double number_of(Element element) {
    return static_cast<double>(element);
}

template <class Element>
double element_at(std::string_view data, std::size_t i, bool is_big_endian) {
    static_assert(std::endian::native == std::endian::little);
    std::array<char, sizeof(Element)> bytes{};
    data.copy(bytes.data(), sizeof(Element), i * sizeof(Element));
    if (is_big_endian) std::ranges::reverse(bytes);
    return number_of(std::bit_cast<Element>(bytes));
}

/// A type of elements in NumPy's notation without the byte order, and the function that reads elements.
struct ElementType {
    std::string_view name;
    std::size_t size;
    double (*element_at)(std::string_view data, std::size_t i, bool is_big_endian);
};

template <class Element>
constexpr ElementType type_of(std::string_view name) {
    return {name, sizeof(Element), element_at<Element>};
}

constexpr ElementType kTypes[] = {
    type_of<std::uint8_t>("b1"),  type_of<std::uint8_t>("u1"),  type_of<std::int8_t>("i1"),
    type_of<std::uint16_t>("u2"), type_of<std::int16_t>("i2"),  type_of<std::uint32_t>("u4"),
    type_of<std::int32_t>("i4"),  type_of<std::uint64_t>("u8"), type_of<std::int64_t>("i8"),
    type_of<Half>("f2"),          type_of<float>("f4"),         type_of<double>("f8"),
};

/// @param type  with the byte order: `<`, `>`, or `|` for a single byte
const ElementType* find_type(std::string_view type) {
    if (type.find_first_of("<>|") != 0) return nullptr;
    const auto* const found = std::ranges::find(kTypes, type.substr(1), &ElementType::name);
    return found == std::end(kTypes) ? nullptr : found;
}

tl::unexpected<Error> wrong(std::string message) {
    return failure(ErrorCode::Malformed, std::move(message));
}

/// Returns the text between a key, such as `'shape': (`, and `end`; empty if the header does not have it.
std::string_view value_of(std::string_view header, std::string_view key, std::string_view end) {
    const auto at = header.find(key);
    if (at == std::string_view::npos) return {};
    header.remove_prefix(at + key.size());
    return take_until(header, end);
}

/// Reads a Python tuple without its parentheses, such as `12, 2` or `12,`. Returns none for any other text.
std::optional<std::vector<std::size_t>> read_shape(std::string_view text) {
    std::vector<std::size_t> shape;
    while (!trim(text).empty()) {
        const auto side = parse_number<std::size_t>(trim(take_until(text, ",")));
        if (!side) return std::nullopt;
        shape.push_back(*side);
    }
    return shape;
}

/// Whether an array of numbers has as many bytes as its shape and type require.
bool is_complete(const NpyArray& array) {
    std::size_t bytes = find_type(array.type)->size;
    for (const std::size_t side : array.shape) {
        if (side > 0 && bytes > array.data.size() / side) return false;
        bytes *= side;
    }
    return bytes == array.data.size();
}

}  // namespace

bool NpyArray::has_numbers() const {
    return find_type(type) != nullptr;
}

double NpyArray::value(std::size_t i) const {
    const ElementType* const element = find_type(type);
    if (is_fortran) {
        std::size_t stride = data.size() / element->size, at = 0;
        for (std::size_t axis = shape.size(); axis-- > 0; i /= shape[axis]) {
            stride /= shape[axis];
            at += i % shape[axis] * stride;
        }
        i = at;
    }
    return element->element_at(data, i, type.front() == '>');
}

Result<NpyArray> read_npy(std::string_view file) {
    const auto byte = [&](std::size_t i) { return i < file.size() ? static_cast<unsigned char>(file[i]) : 0U; };
    const auto version = byte(kNpyMagic.size() - 2);
    if (!is_npy(file) || version < 1 || version > 3) return wrong("the NPY file must have the version 1, 2 or 3");
    file.remove_prefix(std::min(kNpyMagic.size(), file.size()));
    const std::size_t size_bytes = version == 1 ? 2 : 4;
    std::size_t size = 0;
    for (std::size_t i = size_bytes; i-- > 0;) size = 256 * size + byte(i);
    if (file.size() < size_bytes + size) return wrong("the NPY file ends within its header");
    const std::string_view header = file.substr(size_bytes, size);
    const auto shape = read_shape(value_of(header, "'shape': (", ")"));
    if (!shape) return wrong("the header of the NPY file has no valid shape");
    const NpyArray array{value_of(header, "'descr': '", "'"), *shape, file.substr(size_bytes + size),
                         value_of(header, "'fortran_order': ", ",") == "True"};
    if (!array.has_numbers() || is_complete(array)) return array;
    return wrong("the NPY file has " + std::to_string(array.data.size()) +
                 " bytes of data, which do not match its type and shape");
}

}  // namespace ccdt::api
