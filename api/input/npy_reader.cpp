// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/npy_reader.h"

#include <optional>
#include <string>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

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

/// Whether an array has as many bytes as its shape and type require.
bool is_complete(const NpyArray& array) {
    if (array.type.size() < 3) return false;
    std::size_t bytes = parse_number<std::size_t>(array.type.substr(2)).value_or(0);
    for (const std::size_t side : array.shape) {
        if (side > 0 && bytes > array.data.size() / side) return false;
        bytes *= side;
    }
    return bytes == array.data.size();
}

}  // namespace

Result<NpyArray> read_npy(std::string_view file) {
    constexpr std::size_t kSizeBytes = 2;
    if (!file.starts_with(kNpyMagic)) return wrong("the NPY file must have the version 1.0");
    file.remove_prefix(kNpyMagic.size());
    if (file.size() < kSizeBytes) return wrong("the NPY file ends within its header");
    const std::size_t size = static_cast<unsigned char>(file[0]) + 256U * static_cast<unsigned char>(file[1]);
    if (file.size() < kSizeBytes + size) return wrong("the NPY file ends within its header");
    const std::string_view header = file.substr(kSizeBytes, size);
    const auto shape = read_shape(value_of(header, "'shape': (", ")"));
    if (!shape) return wrong("the header of the NPY file has no valid shape");
    if (header.find("'fortran_order': False") == std::string_view::npos)
        return wrong("the NPY file must be an array in C order, not in Fortran order");
    const NpyArray array{value_of(header, "'descr': '", "'"), *shape, file.substr(kSizeBytes + size)};
    if (is_complete(array)) return array;
    return wrong("the NPY file has " + std::to_string(array.data.size()) +
                 " bytes of data, which do not match its type and shape");
}

}  // namespace ccdt::api
