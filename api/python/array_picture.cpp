// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/python/array_picture.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/image/picture_reader.h"

namespace ccdt::python {
namespace {

namespace py = pybind11;

api::RowSource rows_of(const py::array& pixels, bool linear) {
    using Sample = api::RowSource::Sample;
    constexpr int kRowsAtOnce = 16;  // a few hundred kilobytes of a photograph
    api::RowSource source;
    source.height = static_cast<int>(pixels.shape(0));
    source.width = static_cast<int>(pixels.shape(1));
    source.channels = static_cast<int>(pixels.shape(2));
    source.sample = pixels.itemsize() == 1 ? Sample::Byte : pixels.itemsize() == 2 ? Sample::Word : Sample::Float;
    source.alpha = source.channels % 2 == 0 ? source.channels - 1 : -1;
    source.curve = linear ? api::RowSource::Curve::Linear : api::RowSource::Curve::Srgb;
    source.step = kRowsAtOnce;
    const auto row_size = static_cast<std::size_t>(pixels.shape(1) * pixels.shape(2) * pixels.itemsize());
    source.read = [first = static_cast<const char*>(pixels.data()), row_size](int begin, int end, void* rows) {
        std::memcpy(rows, first + static_cast<std::size_t>(begin) * row_size,
                    static_cast<std::size_t>(end - begin) * row_size);
        return true;
    };
    return source;
}

}  // namespace

Result<api::ImageFile> file_of(const py::array& pixels, std::size_t max_pixels) {
    api::ImageHeader header;
    header.height = static_cast<std::uint64_t>(pixels.shape(0));
    header.width = static_cast<std::uint64_t>(pixels.shape(1));
    if (header.pixels() > max_pixels)
        return failure(ErrorCode::LimitExceeded, "the picture has " + std::to_string(header.pixels()) +
                                                     " pixels; the limit is " + std::to_string(max_pixels));
    return api::ImageFile{{static_cast<const char*>(pixels.data()), static_cast<std::size_t>(pixels.nbytes())}, header};
}

api::Decode decode_array(const py::array& pixels, bool linear) {
    const api::RowSource source = rows_of(pixels, linear);
    return {[source](std::string_view, const api::Reading& reading, const std::stop_token&) {
                return api::read_picture<Picture>(source, nullptr, reading);
            },
            [source](std::string_view, const api::Reading& reading, const std::stop_token&) {
                return api::read_picture<ColourPicture>(source, nullptr, reading);
            }};
}

}  // namespace ccdt::python
