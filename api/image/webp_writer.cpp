// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/webp_writer.h"

#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace ccdt::api {
namespace {

/// Effort of the compression, 0 to 9. With 4, encoding antialiased dots takes twice the time, and their files are a
/// sixth smaller; files of other pictures do not become smaller.
constexpr int kEffort = 1;

/// A WebPPicture, freed on destruction.
class Canvas32 {
public:
    Canvas32() { ready_ = WebPPictureInit(&picture_) != 0; }
    ~Canvas32() { WebPPictureFree(&picture_); }
    Canvas32(const Canvas32&) = delete;
    Canvas32& operator=(const Canvas32&) = delete;

    bool allocate(int width, int height) {
        picture_.use_argb = 1;
        picture_.width = width;
        picture_.height = height;
        return ready_ && WebPPictureAlloc(&picture_) != 0;
    }

    WebPPicture& get() { return picture_; }

private:
    WebPPicture picture_{};
    bool ready_ = false;
};

std::uint32_t argb_of(std::uint32_t red, std::uint32_t green, std::uint32_t blue, std::uint32_t alpha) {
    return alpha << 24 | red << 16 | green << 8 | blue;
}

void fill_by_palette(WebPPicture& picture, const DotImage& image) {
    std::array<std::uint32_t, 256> argb{};
    std::transform(image.palette.begin(), image.palette.end(), argb.begin(),
                   [](const auto& shade) { return argb_of(shade[0], shade[1], shade[2], shade[3]); });
    for (int y = 0; y < picture.height; ++y) {
        std::transform(image.row(y), image.row(y) + image.row_size(),
                       picture.argb + std::ptrdiff_t{y} * picture.argb_stride,
                       [&](std::uint8_t value) { return argb[value]; });
    }
}

void fill(WebPPicture& picture, const DotImage& image) {
    if (image.colours > 0) return fill_by_palette(picture, image);
    const std::uint8_t* pixel = image.pixels.data();
    for (int y = 0; y < picture.height; ++y) {
        std::uint32_t* const row = picture.argb + std::ptrdiff_t{y} * picture.argb_stride;
        for (int x = 0; x < picture.width; ++x, pixel += image.channels()) {
            row[x] = argb_of(pixel[0], pixel[1], pixel[2], image.transparent ? pixel[3] : 255);
        }
    }
}

int go_on(int, const WebPPicture* picture) {
    return static_cast<const std::stop_token*>(picture->user_data)->stop_requested() ? 0 : 1;
}

}  // namespace

Result<std::string> write_webp(const DotImage& image, std::optional<double>, const std::stop_token& stop) {
    WebPConfig config;
    WebPMemoryWriter file;
    WebPMemoryWriterInit(&file);
    Canvas32 canvas;
    const bool ready = WebPConfigInit(&config) != 0 && WebPConfigLosslessPreset(&config, kEffort) != 0 &&
                       canvas.allocate(image.width, image.height);
    bool written = false;
    if (ready) {
        config.exact = 1;  // keeps the colours of transparent pixels
        WebPPicture& picture = canvas.get();
        fill(picture, image);
        picture.writer = WebPMemoryWrite;
        picture.custom_ptr = &file;
        picture.progress_hook = go_on;
        picture.user_data = const_cast<std::stop_token*>(&stop);  // go_on() does not modify the token
        written = WebPEncode(&config, &picture) != 0;
    }
    std::string bytes(reinterpret_cast<const char*>(file.mem), written ? file.size : 0);
    WebPMemoryWriterClear(&file);
    if (written) return bytes;
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped while the picture was encoded");
    return failure(ErrorCode::Internal, "the picture could not be encoded");
}

}  // namespace ccdt::api
