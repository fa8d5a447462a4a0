// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/gif_reader.h"

#include <gif_lib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "api/image/broken_image.h"

namespace ccdt::api {
namespace {

struct Close {
    void operator()(GifFileType* file) const { DGifCloseFile(file, nullptr); }
};

/// Gives the library the next bytes of the text to which UserData points. At the end of the text, a read of one byte
/// gives 0, the length of the empty block that ends a frame. Viewers do not require this block.
int read_bytes(GifFileType* file, GifByteType* to, int size) {
    auto& left = *static_cast<std::string_view*>(file->UserData);
    if (left.empty() && size == 1) {
        *to = 0;
        return 1;
    }
    const auto taken = left.substr(0, static_cast<std::size_t>(size));
    std::ranges::copy(taken, to);
    left.remove_prefix(taken.size());
    return static_cast<int>(taken.size());
}

struct Frame {
    GifImageDesc position{};                  ///< the frame's rectangle in the picture
    std::array<GifColorType, 256> palette{};  ///< colours that are missing from the file are black
    int transparent = NO_TRANSPARENT_COLOR;
    std::vector<std::uint8_t> pixels;
};

/// Decodes all rows of a frame. In an interlaced file, the rows are stored in four passes.
bool read_pixels(GifFileType& file, Frame& frame) {
    const auto width = static_cast<std::size_t>(frame.position.Width);
    frame.pixels.resize(width * static_cast<std::size_t>(frame.position.Height));
    const auto read_rows = [&](int begin, int step) {
        for (int y = begin; y < frame.position.Height; y += step) {
            GifByteType* const row = frame.pixels.data() + static_cast<std::size_t>(y) * width;
            if (DGifGetLine(&file, row, frame.position.Width) == GIF_ERROR) return false;
        }
        return true;
    };
    if (!frame.position.Interlace) return read_rows(0, 1);
    return read_rows(0, 8) && read_rows(4, 8) && read_rows(2, 4) && read_rows(1, 2);
}

bool read_frame(GifFileType& file, const ImageHeader& header, Frame& frame) {
    if (DGifGetImageDesc(&file) == GIF_ERROR) return false;
    frame.position = file.Image;
    const auto& [left, top, width, height, interlaced, own_palette] = frame.position;
    const ColorMapObject* const palette = own_palette != nullptr ? own_palette : file.SColorMap;
    file.SWidth = std::max(file.SWidth, left + width);
    file.SHeight = std::max(file.SHeight, top + height);
    const bool is_expected = std::cmp_equal(file.SWidth, header.width) && std::cmp_equal(file.SHeight, header.height);
    if (!is_expected || width <= 0 || height <= 0) return false;
    if (palette != nullptr) std::copy_n(palette->Colors, palette->ColorCount, frame.palette.begin());
    return read_pixels(file, frame);
}

/// Reads an extension. Uses only the extension that gives the transparent colour of the next frame.
bool read_extension(GifFileType& file, Frame& frame) {
    int code = 0;
    GifByteType* block = nullptr;
    if (DGifGetExtension(&file, &code, &block) == GIF_ERROR) return false;
    GraphicsControlBlock control{};
    if (code == GRAPHICS_EXT_FUNC_CODE && block != nullptr &&
        DGifExtensionToGCB(block[0], block + 1, &control) == GIF_OK)
        frame.transparent = control.TransparentColor;
    while (block != nullptr)
        if (DGifGetExtensionNext(&file, &block) == GIF_ERROR) return false;
    return true;
}

/// Finds the first frame, and reads the frame and the extensions before it.
bool find_frame(GifFileType& file, const ImageHeader& header, Frame& frame) {
    auto type = UNDEFINED_RECORD_TYPE;
    while (DGifGetRecordType(&file, &type) != GIF_ERROR) {
        if (type == IMAGE_DESC_RECORD_TYPE) return read_frame(file, header, frame);
        if (type != EXTENSION_RECORD_TYPE || !read_extension(file, frame)) return false;
    }
    return false;
}

/// Writes a row of the picture: red, green and blue, and alpha if there are four channels.
void write_row(const Frame& frame, int y, int width, std::size_t channels, std::uint8_t* to) {
    const GifImageDesc& position = frame.position;
    std::fill_n(to, static_cast<std::size_t>(width) * channels, std::uint8_t{0});
    if (y < position.Top || y >= position.Top + position.Height) return;
    const auto row = static_cast<std::size_t>(y - position.Top) * static_cast<std::size_t>(position.Width);
    to += static_cast<std::size_t>(position.Left) * channels;
    for (std::size_t i = row; i < row + static_cast<std::size_t>(position.Width); ++i, to += channels) {
        if (frame.pixels[i] == frame.transparent) continue;
        const auto& [red, green, blue] = frame.palette[frame.pixels[i]];
        to[0] = red;
        to[1] = green;
        to[2] = blue;
        if (channels == 4) to[3] = 255;
    }
}

}  // namespace

Result<RowSource> open_gif(std::string_view bytes, const ImageHeader& header) {
    const std::unique_ptr<GifFileType, Close> file(DGifOpen(&bytes, read_bytes, nullptr));
    const auto frame = std::make_shared<Frame>();
    if (!file || !find_frame(*file, header, *frame)) return broken_image();

    RowSource source;
    source.width = file->SWidth;
    source.height = file->SHeight;
    const GifImageDesc& position = frame->position;
    const bool covers =
        position.Left == 0 && position.Top == 0 && position.Width >= source.width && position.Height >= source.height;
    source.channels = covers && frame->transparent == NO_TRANSPARENT_COLOR ? 3 : 4;
    source.alpha = source.channels == 4 ? 3 : -1;
    source.read = [frame, width = source.width, channels = static_cast<std::size_t>(source.channels)](
                      int begin, int end, void* rows) {
        auto* to = static_cast<std::uint8_t*>(rows);
        for (int y = begin; y < end; ++y, to += static_cast<std::size_t>(width) * channels)
            write_row(*frame, y, width, channels, to);
        return true;
    };
    return source;
}

}  // namespace ccdt::api
