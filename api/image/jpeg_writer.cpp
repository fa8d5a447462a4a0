// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/jpeg_writer.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <jpeglib.h>

namespace ccdt::api {
namespace {

/// Encodes a JPEG. libjpeg reports errors by longjmp() into the member functions, so these functions must not have
/// local objects with destructors.
class JpegEncoder {
public:
    JpegEncoder() {
        encoder_.err = jpeg_std_error(&errors_.manager);
        errors_.manager.error_exit = [](j_common_ptr encoder) {
            std::longjmp(reinterpret_cast<Errors*>(encoder->err)->position, 1);
        };
        errors_.manager.output_message = [](j_common_ptr) {};
    }

    ~JpegEncoder() {
        jpeg_destroy_compress(&encoder_);
        std::free(bytes_);
    }
    JpegEncoder(const JpegEncoder&) = delete;
    JpegEncoder& operator=(const JpegEncoder&) = delete;

    /// @param density  pixels per inch; 0: unknown
    bool begin(const DotImage& image, int quality, int density) {
        if (setjmp(errors_.position) != 0) return false;
        jpeg_create_compress(&encoder_);
        jpeg_mem_dest(&encoder_, &bytes_, &size_);
        encoder_.image_width = static_cast<JDIMENSION>(image.width);
        encoder_.image_height = static_cast<JDIMENSION>(image.height);
        encoder_.input_components = image.grey ? 1 : 3;
        encoder_.in_color_space = image.grey ? JCS_GRAYSCALE : JCS_RGB;
        jpeg_set_defaults(&encoder_);
        jpeg_set_quality(&encoder_, quality, TRUE);
        encoder_.dct_method = JDCT_ISLOW;  // exact in integers, also in code for particular processors
        for (int i = 0; i < encoder_.num_components; ++i)
            encoder_.comp_info[i].h_samp_factor = encoder_.comp_info[i].v_samp_factor = 1;
        if (density > 0) {
            encoder_.density_unit = 1;
            encoder_.X_density = encoder_.Y_density = static_cast<UINT16>(density);
        }
        jpeg_start_compress(&encoder_, TRUE);
        return true;
    }

    bool write(std::uint8_t* row) {
        if (setjmp(errors_.position) != 0) return false;
        return jpeg_write_scanlines(&encoder_, &row, 1) == 1;
    }

    bool finish() {
        if (setjmp(errors_.position) != 0) return false;
        jpeg_finish_compress(&encoder_);
        return true;
    }

    std::string bytes() const { return {reinterpret_cast<const char*>(bytes_), size_}; }

private:
    struct Errors {
        jpeg_error_mgr manager;  // must be the first member: libjpeg has a pointer to it
        std::jmp_buf position;
    };

    Errors errors_{};
    jpeg_compress_struct encoder_{};
    unsigned char* bytes_ = nullptr;
    unsigned long size_ = 0;
};

/// Converts a row of pixels to grey values, or to red, green and blue.
void convert(const DotImage& image, const std::uint8_t* from, std::vector<std::uint8_t>& row) {
    const std::size_t channels = image.channels(), shown = image.grey ? 1 : 3;
    for (std::size_t x = 0; x < static_cast<std::size_t>(image.width); ++x, from += channels)
        std::copy_n(image.colours > 0 ? image.palette[*from].data() : from, shown, row.data() + x * shown);
}

}  // namespace

Result<std::string> write_jpeg(const DotImage& image, int quality, std::optional<double> width_mm,
                               const std::stop_token& stop) {
    constexpr double kMillimetresPerInch = 25.4, kMaxDensity = 65'535;
    const double density =
        width_mm ? std::min(std::round(image.width / *width_mm * kMillimetresPerInch), kMaxDensity) : 0;
    JpegEncoder encoder;
    std::vector<std::uint8_t> row(static_cast<std::size_t>(image.width) * 3);
    bool written = encoder.begin(image, quality, static_cast<int>(density));
    for (int y = 0; y < image.height && written; ++y) {
        if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped while the picture was encoded");
        convert(image, image.row(y), row);
        written = encoder.write(row.data());
    }
    if (written && encoder.finish()) return encoder.bytes();
    return failure(ErrorCode::Internal, "the picture could not be encoded");
}

}  // namespace ccdt::api
