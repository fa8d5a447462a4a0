// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/python/png_pixels.h"

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <png.h>

namespace ccdt::python {

pybind11::array png_pixels(std::string_view file) {
    namespace py = pybind11;
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    const std::unique_ptr<png_image, void (*)(png_image*)> owner(&image, png_image_free);
    const auto check = [&](int success) {
        if (success == 0) throw std::runtime_error(std::string("the PNG file cannot be read: ") + image.message);
    };
    check(png_image_begin_read_from_memory(&image, file.data(), file.size()));
    image.format &= PNG_FORMAT_FLAG_COLOR | PNG_FORMAT_FLAG_ALPHA | PNG_FORMAT_FLAG_LINEAR;
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(image.height), static_cast<py::ssize_t>(image.width)};
    if (PNG_IMAGE_SAMPLE_CHANNELS(image.format) > 1) shape.push_back(PNG_IMAGE_SAMPLE_CHANNELS(image.format));
    const bool wide = (image.format & PNG_FORMAT_FLAG_LINEAR) != 0;
    py::array pixels(wide ? py::dtype::of<std::uint16_t>() : py::dtype::of<std::uint8_t>(), shape);
    const auto row_stride = static_cast<png_int_32>(PNG_IMAGE_ROW_STRIDE(image));
    check(png_image_finish_read(&image, nullptr, pixels.mutable_data(), row_stride, nullptr));
    return pixels;
}

}  // namespace ccdt::python
