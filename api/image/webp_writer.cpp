#include "api/image/webp_writer.h"

#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "api/image/shades.h"

namespace ccdt::api {
namespace {

/// Of 0 to 9: at 4 soft rims take twice the time for a sixth less room, hard ones no less.
constexpr int kEffort = 1;

/// WebPPicture, freed in the end.
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

std::array<std::uint32_t, 256> argb_of(const Inks& inks) {
    const Shades shades = shades_of(inks);
    std::array<std::uint32_t, 256> argb{};
    std::transform(shades.begin(), shades.end(), argb.begin(), [](const auto& shade) {
        return std::uint32_t{shade[3]} << 24 | std::uint32_t{shade[0]} << 16 | std::uint32_t{shade[1]} << 8 | shade[2];
    });
    return argb;
}

void fill(WebPPicture& picture, const Raster& raster, const Inks& inks) {
    const auto argb = argb_of(inks);
    const auto width = static_cast<std::size_t>(raster.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(raster.height); ++y) {
        const auto* row = raster.coverage.data() + y * width;
        std::transform(row, row + width, picture.argb + y * static_cast<std::size_t>(picture.argb_stride),
                       [&](std::uint8_t coverage) { return argb[coverage]; });
    }
}

int go_on(int, const WebPPicture* picture) {
    return static_cast<const std::stop_token*>(picture->user_data)->stop_requested() ? 0 : 1;
}

}  // namespace

Result<std::string> write_webp(const Raster& raster, const Inks& inks, const std::stop_token& stop) {
    WebPConfig config;
    WebPMemoryWriter file;
    WebPMemoryWriterInit(&file);
    Canvas32 canvas;
    const bool ready = WebPConfigInit(&config) != 0 && WebPConfigLosslessPreset(&config, kEffort) != 0 &&
                       canvas.allocate(raster.width, raster.height);
    bool written = false;
    if (ready) {
        config.exact = 1;  // colours stay where nothing is seen of them
        WebPPicture& picture = canvas.get();
        fill(picture, raster, inks);
        picture.writer = WebPMemoryWrite;
        picture.custom_ptr = &file;
        picture.progress_hook = go_on;
        picture.user_data = const_cast<std::stop_token*>(&stop);  // only read
        written = WebPEncode(&config, &picture) != 0;
    }
    std::string bytes(reinterpret_cast<const char*>(file.mem), written ? file.size : 0);
    WebPMemoryWriterClear(&file);
    if (written) return bytes;
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped while the picture was encoded");
    return failure(ErrorCode::Internal, "the picture could not be encoded");
}

}  // namespace ccdt::api
