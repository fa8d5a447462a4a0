// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/ink_jpeg.h"

#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>

#include <jpeglib.h>

#include "api/image/broken_image.h"
#include "api/image/image_header.h"

namespace ccdt::api {
namespace {

constexpr int kInks = 4;

/// Decodes a JPEG with four inks. libjpeg reports errors by longjmp() into the member functions, so these functions
/// must not have local objects with destructors.
class InkJpeg {
public:
    explicit InkJpeg(std::string_view bytes) : bytes_(bytes) {
        decoder_.err = jpeg_std_error(&errors_.manager);
        errors_.manager.error_exit = [](j_common_ptr decoder) {
            std::longjmp(reinterpret_cast<Errors*>(decoder->err)->position, 1);
        };
        errors_.manager.output_message = [](j_common_ptr) {};
    }

    ~InkJpeg() { jpeg_destroy_decompress(&decoder_); }
    InkJpeg(const InkJpeg&) = delete;
    InkJpeg& operator=(const InkJpeg&) = delete;

    bool open() {
        if (setjmp(errors_.position) != 0) return false;
        jpeg_create_decompress(&decoder_);
        jpeg_mem_src(&decoder_, reinterpret_cast<const unsigned char*>(bytes_.data()), bytes_.size());
        jpeg_read_header(&decoder_, TRUE);
        if (decoder_.num_components != kInks) return false;
        decoder_.out_color_space = JCS_CMYK;
        jpeg_start_decompress(&decoder_);
        return is_sound();
    }

    bool read(int count, std::uint8_t* rows) {
        if (setjmp(errors_.position) != 0) return false;
        for (int i = 0; i < count; ++i) {
            JSAMPROW row = rows + static_cast<std::size_t>(i) * row_size();
            if (jpeg_read_scanlines(&decoder_, &row, 1) != 1) return false;
            for (std::size_t j = 0; j < row_size(); ++j) row[j] = static_cast<std::uint8_t>(255 - row[j]);
        }
        return is_sound();
    }

    int width() const { return static_cast<int>(decoder_.output_width); }
    int height() const { return static_cast<int>(decoder_.output_height); }

private:
    struct Errors {
        jpeg_error_mgr manager;  // must be the first member: libjpeg has a pointer to it
        std::jmp_buf position;
    };

    std::size_t row_size() const { return std::size_t{decoder_.output_width} * kInks; }
    bool is_sound() const { return errors_.manager.num_warnings == 0; }

    std::string_view bytes_;
    Errors errors_{};
    jpeg_decompress_struct decoder_{};
};

}  // namespace

Result<RowSource> open_ink_jpeg(std::string_view bytes) {
    constexpr int kRows = 16;
    const auto file = std::make_shared<InkJpeg>(bytes);
    if (!file->open()) return broken_image();
    RowSource source;
    source.width = file->width();
    source.height = file->height();
    source.channels = kInks;
    source.space = RowSource::Space::Inks;
    source.orientation = exif_orientation(bytes, ImageFormat::Jpeg);
    source.step = kRows;
    source.read = [file](int begin, int end, void* rows) {
        return file->read(end - begin, static_cast<std::uint8_t*>(rows));
    };
    return source;
}

}  // namespace ccdt::api
