// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/tiff_reader.h"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/image/broken_image.h"
#include "api/image/containers.h"

namespace ccdt::api {
namespace {

using Space = TiffPixels::Space;
using Type = TiffPixels::Type;

/// A file in memory, as libtiff reads it.
struct InputFile {
    std::string_view bytes;
    std::size_t position = 0;
    bool is_damaged = false;  ///< whether libjpeg has reported a fault of which it only warns
};

InputFile& file_of(thandle_t handle) {
    return *static_cast<InputFile*>(handle);
}

tmsize_t read(thandle_t handle, void* target, tmsize_t size) {
    InputFile& file = file_of(handle);
    if (file.position > file.bytes.size()) return 0;
    const std::string_view part = file.bytes.substr(file.position, static_cast<std::size_t>(size));
    std::memcpy(target, part.data(), part.size());
    file.position += part.size();
    return static_cast<tmsize_t>(part.size());
}

tmsize_t refuse_to_write(thandle_t, void*, tmsize_t) {
    return 0;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
    InputFile& file = file_of(handle);
    const std::size_t base = whence == SEEK_CUR ? file.position : whence == SEEK_END ? file.bytes.size() : 0;
    return file.position = base + offset;
}

int close(thandle_t) {
    return 0;
}

toff_t size(thandle_t handle) {
    return file_of(handle).bytes.size();
}

/// Lets libtiff read the file in place. It does not write to a file that it reads.
int map(thandle_t handle, void** begin, toff_t* count) {
    const std::string_view bytes = file_of(handle).bytes;
    *begin = const_cast<char*>(bytes.data());
    *count = bytes.size();
    return 1;
}

void unmap(thandle_t, void*, toff_t) {}

int ignore_error(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

int check_warning(TIFF*, void* file, const char* module, const char*, va_list) {
    if (module != nullptr && std::string_view(module) == "JPEGLib") static_cast<InputFile*>(file)->is_damaged = true;
    return 1;
}

struct Close {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
    void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};
using Tiff = std::unique_ptr<TIFF, Close>;

/// @param most  maximum number of bytes that libtiff may allocate at once
Tiff open(InputFile& file, std::uint64_t most, std::size_t directory) {
    const std::unique_ptr<TIFFOpenOptions, Close> options(TIFFOpenOptionsAlloc());
    if (!options) return nullptr;
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), ignore_error, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), check_warning, &file);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(most));
    // The mode rh reads no directory yet.
    Tiff tiff(TIFFClientOpenExt("", "rh", &file, read, refuse_to_write, seek, close, size, map, unmap, options.get()));
    if (tiff && TIFFSetSubDirectory(tiff.get(), directory) == 0) tiff.reset();
    return tiff;
}

template <class Number>
Number field(TIFF* tiff, std::uint32_t tag) {
    Number value{};
    TIFFGetFieldDefaulted(tiff, tag, &value);
    return value;
}

tl::unexpected<Error> unusual(const std::string& what) {
    return failure(ErrorCode::Unusable, "there is no support for this kind of TIFF: " + what);
}

bool is_fax(std::uint16_t compression) {
    constexpr std::array kFaxes = {COMPRESSION_CCITTRLE, COMPRESSION_CCITTRLEW, COMPRESSION_CCITTFAX3,
                                   COMPRESSION_CCITTFAX4};
    return std::ranges::find(kFaxes, compression) != kFaxes.end();
}

/// Returns the photometric interpretation. If it is missing, returns the most probable one.
std::uint16_t photometric_of(TIFF* tiff) {
    std::uint16_t photometric = 0;
    if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric) != 0) return photometric;
    if (field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL) >= 3) return PHOTOMETRIC_RGB;
    return is_fax(field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION)) ? PHOTOMETRIC_MINISWHITE : PHOTOMETRIC_MINISBLACK;
}

std::optional<Space> space_of(std::uint16_t photometric) {
    switch (photometric) {
        case PHOTOMETRIC_MINISWHITE:
            return Space::WhiteIsZero;
        case PHOTOMETRIC_MINISBLACK:
            return Space::Grey;
        case PHOTOMETRIC_RGB:
            return Space::Rgb;
        case PHOTOMETRIC_PALETTE:
            return Space::Palette;
        case PHOTOMETRIC_SEPARATED:
            return Space::Inks;
        case PHOTOMETRIC_YCBCR:
            return Space::YCbCr;
        case PHOTOMETRIC_CIELAB:
            return Space::CieLab;
        case PHOTOMETRIC_ICCLAB:
            return Space::IccLab;
        default:
            return std::nullopt;
    }
}

std::string name_of_photometric(std::uint16_t photometric) {
    constexpr std::uint16_t kLinearRaw = 34892;
    switch (photometric) {
        case PHOTOMETRIC_MASK:
            return "a transparency mask";
        case PHOTOMETRIC_ITULAB:
            return "ITU L*a*b*";
        case PHOTOMETRIC_CFA:
        case kLinearRaw:
            return "the raw data of a camera's sensor";
        case PHOTOMETRIC_LOGL:
        case PHOTOMETRIC_LOGLUV:
            return "LogLuv, for high dynamic range";
        default:
            return "the photometric interpretation " + std::to_string(photometric);
    }
}

const char* name_of(Space space) {
    switch (space) {
        case Space::WhiteIsZero:
        case Space::Grey:
            return "grey";
        case Space::Rgb:
            return "RGB";
        case Space::Palette:
            return "palette";
        case Space::Inks:
            return "CMYK";
        case Space::YCbCr:
            return "YCbCr";
        case Space::CieLab:
            return "CIELAB";
        case Space::IccLab:
            break;
    }
    return "ICCLAB";
}

/// Describes pixels, as in "16-bit CMYK with 3 extra channels".
std::string name_of(const TiffPixels& pixels) {
    std::string name = std::to_string(pixels.bits) + "-bit ";
    if (pixels.type == Type::Signed) name += "signed ";
    if (pixels.type == Type::Float) name += "float ";
    name += name_of(pixels.space);
    const int extra = pixels.samples - pixels.colours();
    if (extra > 0) name += " with " + std::to_string(extra) + " extra channel" + (extra > 1 ? "s" : "");
    if (extra < 0) name += " with " + std::to_string(pixels.samples) + " channel" + (pixels.samples > 1 ? "s" : "");
    return name;
}

/// Checks what libtiff cannot open: a long directory, and bits per sample that differ.
Result<void> check_directory(const TiffDirectory& directory) {
    constexpr std::size_t kMaxEntries = 4096;
    if (directory.entries() > kMaxEntries)
        return unusual(std::to_string(directory.entries()) + " tags; the limit is " + std::to_string(kMaxEntries));
    const auto samples = std::min(directory.number(TIFFTAG_SAMPLESPERPIXEL).value_or(1), kMaxTiffSamples + 1U);
    const auto first = directory.number(TIFFTAG_BITSPERSAMPLE);
    for (std::uint32_t i = 1; first && i < samples; ++i) {
        const auto bits = directory.number(TIFFTAG_BITSPERSAMPLE, i);
        if (bits && bits != first)
            return unusual("channels of " + std::to_string(*first) + " and " + std::to_string(*bits) + " bits");
    }
    return {};
}

Result<void> check_structure(TIFF* tiff, const TiffDirectory& directory) {
    constexpr std::uint32_t kDngVersion = 50706;
    const bool is_reduced = (field<std::uint32_t>(tiff, TIFFTAG_SUBFILETYPE) & FILETYPE_REDUCEDIMAGE) != 0;
    if (is_reduced && (directory.has(TIFFTAG_SUBIFD) || directory.has(kDngVersion) || directory.next() != 0))
        return unusual("its first picture is the thumbnail of another one, as in a camera's raw file (DNG, NEF)");
    if (field<std::uint32_t>(tiff, TIFFTAG_IMAGEDEPTH) > 1) return unusual("more than two dimensions");
    return {};
}

bool has_type(const TiffPixels& pixels, TiffUse use) {
    const int bits = pixels.bits;
    const bool is_light = pixels.space == Space::Grey || pixels.space == Space::WhiteIsZero;
    const bool is_byte_or_word = bits == 8 || bits == 16;
    switch (pixels.type) {
        case Type::Float:
            return (is_byte_or_word ? bits == 16 : bits == 24 || bits == 32 || bits == 64) &&
                   (is_light || pixels.space == Space::Rgb || pixels.space == Space::Inks);
        case Type::Signed:
            return use == TiffUse::Values && is_light && (is_byte_or_word || bits == 32);
        case Type::Unsigned:
            break;
    }
    switch (pixels.space) {
        case Space::YCbCr:
            return bits == 8;
        case Space::CieLab:
        case Space::IccLab:
            return is_byte_or_word;
        case Space::Palette:
            return bits >= 1 && bits <= 16;
        default:
            return bits >= 1 && bits <= 32;
    }
}

std::optional<Type> type_of(std::uint16_t sample_format) {
    switch (sample_format) {
        case SAMPLEFORMAT_UINT:
        case SAMPLEFORMAT_VOID:
            return Type::Unsigned;
        case SAMPLEFORMAT_INT:
            return Type::Signed;
        case SAMPLEFORMAT_IEEEFP:
            return Type::Float;
        default:
            return std::nullopt;
    }
}

/// Finds the channel of alpha. A file that has one extra channel but does not say what it means has alpha.
void find_alpha(TIFF* tiff, const TiffDirectory& directory, TiffPixels& pixels) {
    std::uint16_t count = 0;
    const std::uint16_t* meanings = nullptr;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &count, &meanings);
    const int colours = pixels.colours();
    if (!directory.has(TIFFTAG_EXTRASAMPLES)) {
        if (pixels.samples == colours + 1 && colours != 4) pixels.alpha = colours;
        return;
    }
    for (int i = 0; i < std::min<int>(count, pixels.samples - colours); ++i) {
        if (meanings[i] == EXTRASAMPLE_UNSPECIFIED) continue;
        pixels.alpha = colours + i;
        pixels.premultiplied = meanings[i] == EXTRASAMPLE_ASSOCALPHA;
        return;
    }
}

/// Reads the colours of a palette. If all of them are small, they have 8 bits instead of 16.
bool read_palette(TIFF* tiff, TiffPixels& pixels) {
    constexpr std::uint16_t kByte = 255;
    std::array<const std::uint16_t*, 3> colours{};
    if (TIFFGetField(tiff, TIFFTAG_COLORMAP, &colours[0], &colours[1], &colours[2]) == 0) return false;
    const std::size_t size = std::size_t{1} << pixels.bits;
    for (const auto* const list : colours) pixels.palette.insert(pixels.palette.end(), list, list + size);
    if (std::ranges::all_of(pixels.palette, [](std::uint16_t value) { return value <= kByte; })) {
        for (std::uint16_t& value : pixels.palette) value = static_cast<std::uint16_t>(value * 257);
    }
    return true;
}

void read_chroma_tags(TIFF* tiff, TiffPixels& pixels) {
    const float* weights = nullptr;
    const float* reference = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_YCBCRCOEFFICIENTS, &weights) != 0) std::copy_n(weights, 3, pixels.luma.begin());
    if (TIFFGetField(tiff, TIFFTAG_REFERENCEBLACKWHITE, &reference) != 0)
        std::copy_n(reference, 6, pixels.reference.begin());
}

Result<TiffPixels> read_pixels(TIFF* tiff, const TiffDirectory& directory, TiffUse use) {
    const std::uint16_t photometric = photometric_of(tiff);
    const auto space = space_of(photometric);
    if (!space) return unusual(name_of_photometric(photometric));
    const auto type = type_of(field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT));
    if (!type) return unusual("complex numbers");

    TiffPixels pixels;
    pixels.space = *space;
    pixels.type = *type;
    pixels.bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE);
    pixels.samples = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL);
    pixels.is_planar = pixels.samples > 1 && field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE;
    if (pixels.space == Space::Inks && field<std::uint16_t>(tiff, TIFFTAG_INKSET) == INKSET_MULTIINK)
        return unusual("inks other than cyan, magenta, yellow and black");
    if (pixels.samples < pixels.colours() || std::cmp_greater(pixels.samples, kMaxTiffSamples) ||
        !has_type(pixels, use))
        return unusual(name_of(pixels));
    find_alpha(tiff, directory, pixels);
    const bool may_be_premultiplied =
        pixels.colours() != 3 ? pixels.space != Space::Palette : pixels.space == Space::Rgb;
    if (pixels.premultiplied && !may_be_premultiplied) return unusual(name_of(pixels) + ", premultiplied by alpha");
    if (pixels.space == Space::Palette && !read_palette(tiff, pixels)) return unusual("a palette without colours");
    if (pixels.space == Space::YCbCr) read_chroma_tags(tiff, pixels);
    return pixels;
}

Result<void> check_compression(TIFF* tiff, const TiffPixels& pixels, std::string_view bytes) {
    constexpr std::array kKnown = {COMPRESSION_NONE,          COMPRESSION_LZW,     COMPRESSION_JPEG,
                                   COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE, COMPRESSION_PACKBITS,
                                   COMPRESSION_LZMA,          COMPRESSION_ZSTD,    COMPRESSION_WEBP};
    const auto compression = field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION);
    const bool fax = is_fax(compression);
    if ((!fax && std::ranges::find(kKnown, compression) == kKnown.end()) || TIFFIsCODECConfigured(compression) == 0) {
        const TIFFCodec* const codec = TIFFFindCODEC(compression);
        return unusual("compression " + std::to_string(compression) +
                       (codec != nullptr ? " (" + std::string(codec->name) + ")" : ""));
    }
    const bool needs_bytes = compression == COMPRESSION_JPEG || compression == COMPRESSION_WEBP;
    const bool fits = fax ? pixels.bits == 1 && (pixels.samples == 1 || pixels.is_planar)
                          : !needs_bytes || (pixels.bits == 8 && pixels.type == Type::Unsigned);
    if (!fits) return unusual(name_of(pixels) + ", compressed by " + TIFFFindCODEC(compression)->name);
    if (compression == COMPRESSION_JPEG) {
        const auto frame = jpeg_frame(bytes, TIFFGetStrileOffset(tiff, 0));
        const std::string kind = frame ? unread_jpeg(*frame) : "";
        if (!kind.empty()) return unusual(name_of(pixels) + ", compressed as " + kind);
    }
    std::uint16_t predictor = PREDICTOR_NONE;
    TIFFGetField(tiff, TIFFTAG_PREDICTOR, &predictor);
    const bool whole_bytes = pixels.bits % 8 == 0 && pixels.bits != 24;
    if (predictor == PREDICTOR_HORIZONTAL && !whole_bytes)
        return unusual(name_of(pixels) + ", compressed as differences");
    return {};
}

/// Reads the blocks of a page: its strips or tiles.
class Blocks {
public:
    /// @param most  maximum number of bytes that libtiff may allocate at once
    Blocks(std::string_view bytes, std::uint64_t most, std::size_t directory)
        : file_{bytes}, tiff_(open(file_, most, directory)) {}

    TIFF* get() const { return tiff_.get(); }
    int rows() const { return static_cast<int>(rows_); }

    /// Whether libtiff converts the pixels from YCbCr to RGB.
    bool are_converted(const TiffPixels& pixels) const {
        return pixels.space == Space::YCbCr && !pixels.is_planar &&
               field<std::uint16_t>(get(), TIFFTAG_COMPRESSION) == COMPRESSION_JPEG;
    }

    /// Reads the layout of the blocks.
    Result<void> describe(const ImageHeader& header, const TiffPixels& pixels) {
        width_ = static_cast<std::size_t>(header.width);
        height_ = static_cast<std::size_t>(header.height);
        if (auto checked = describe_chroma(pixels); !checked) return checked;
        is_tiled_ = TIFFIsTiled(get()) != 0;
        if (is_tiled_) {
            columns_ = field<std::uint32_t>(get(), TIFFTAG_TILEWIDTH);
            rows_ = field<std::uint32_t>(get(), TIFFTAG_TILELENGTH);
            if (columns_ == 0 || rows_ == 0) return broken_image();
            if (columns_ * rows_ > header.pixels() + kMaxTilePixels)
                return unusual("tiles much larger than the picture");
        } else {
            columns_ = width_;
            rows_ = std::min<std::size_t>(field<std::uint32_t>(get(), TIFFTAG_ROWSPERSTRIP), height_);
            if (rows_ == 0) return broken_image();
        }
        across_ = (width_ + columns_ - 1) / columns_;
        block_bytes_ = static_cast<std::size_t>(is_tiled_ ? TIFFTileSize64(get()) : TIFFStripSize64(get()));
        row_bytes_ = static_cast<std::size_t>(is_tiled_ ? TIFFTileRowSize64(get()) : TIFFScanlineSize64(get()));
        if (is_subsampled()) row_bytes_ = columns_ * 3;
        const std::size_t samples = pixels.is_planar ? 1 : static_cast<std::size_t>(pixels.samples);
        // libtiff computes these sizes from the same tags.
        if (row_bytes_ < (columns_ * samples * static_cast<std::size_t>(pixels.bits) + 7) / 8) return broken_image();
        if (block_bytes_ <
            (is_subsampled() ? chroma_bytes(columns_, rows_, chroma_across_, chroma_down_) : row_bytes_ * rows_))
            return broken_image();
        planes_ = pixels.is_planar ? pixels.channels() : std::vector<std::uint16_t>{0};
        return {};
    }

    /// Converts a row. Rows must be read from the first to the last.
    bool read_row(std::size_t y, const TiffRowConverter& convert, std::uint8_t* to, std::size_t pixel_size) {
        if (y % rows_ == 0 && !load(y)) return false;
        std::vector<const std::uint8_t*> from(planes_.size());
        for (std::size_t block = 0; block < across_; ++block) {
            for (std::size_t plane = 0; plane < planes_.size(); ++plane)
                from[plane] = position_of(plane, block) + y % rows_ * row_bytes_;
            const std::size_t x = block * columns_;
            convert(from, std::min(columns_, width_ - x), to + x * pixel_size);
        }
        return true;
    }

private:
    bool is_subsampled() const { return chroma_across_ > 1 || chroma_down_ > 1; }

    /// Lets libtiff convert JPEG to RGB, and reads the subsampling of other pictures in YCbCr.
    Result<void> describe_chroma(const TiffPixels& pixels) {
        if (pixels.space != Space::YCbCr) return {};
        if (pixels.samples != 3 && !pixels.is_planar) return unusual(name_of(pixels));
        if (are_converted(pixels)) {
            TIFFSetField(get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
            return {};
        }
        std::uint16_t across = 0, down = 0;
        TIFFGetFieldDefaulted(get(), TIFFTAG_YCBCRSUBSAMPLING, &across, &down);
        const auto is_valid = [](std::uint16_t step) { return step == 1 || step == 2 || step == 4; };
        const bool is_full = across == 1 && down == 1;
        if (!is_valid(across) || !is_valid(down) || (!is_full && pixels.is_planar))
            return unusual(name_of(pixels) + (pixels.is_planar ? " in separate planes" : "") +
                           ", with chroma subsampled by " + std::to_string(across) + " x " + std::to_string(down));
        chroma_across_ = across;
        chroma_down_ = down;
        return {};
    }

    std::uint8_t* position_of(std::size_t plane, std::size_t block) {
        return band_.data() + (plane * across_ + block) * std::min(rows_, height_) * row_bytes_;
    }

    /// Reads the blocks that contain a row.
    bool load(std::size_t y) {
        band_.resize(planes_.size() * across_ * std::min(rows_, height_) * row_bytes_);
        for (std::size_t plane = 0; plane < planes_.size(); ++plane) {
            for (std::size_t block = 0; block < across_; ++block) {
                if (!load_block(y, block, plane)) return false;
            }
        }
        return !file_.is_damaged;
    }

    bool load_block(std::size_t y, std::size_t block, std::size_t plane) {
        const std::size_t rows = std::min(rows_, height_ - y);
        std::uint8_t* const to = position_of(plane, block);
        const auto row = static_cast<std::uint32_t>(y);
        if (!is_tiled_ && !is_subsampled()) {
            const auto size = static_cast<tmsize_t>(rows * row_bytes_);
            const auto strip = TIFFComputeStrip(get(), row, planes_[plane]);
            return TIFFReadEncodedStrip(get(), strip, to, size) == size;
        }
        block_.resize(block_bytes_);
        const auto size = static_cast<tmsize_t>(block_bytes_);
        if (is_tiled_) {
            const auto tile =
                TIFFComputeTile(get(), static_cast<std::uint32_t>(block * columns_), row, 0, planes_[plane]);
            if (TIFFReadEncodedTile(get(), tile, block_.data(), size) != size) return false;
        } else {
            const auto stored = static_cast<tmsize_t>(TIFFVStripSize64(get(), static_cast<std::uint32_t>(rows)));
            const auto strip = TIFFComputeStrip(get(), row, planes_[plane]);
            if (stored > size || TIFFReadEncodedStrip(get(), strip, block_.data(), stored) != stored) return false;
        }
        if (is_subsampled()) {
            expand_chroma(block_.data(), columns_, rows, chroma_across_, chroma_down_, to);
        } else {
            std::copy_n(block_.data(), rows * row_bytes_, to);
        }
        return true;
    }

    InputFile file_;
    Tiff tiff_;
    std::size_t width_ = 0;  ///< of the page
    std::size_t height_ = 0;
    bool is_tiled_ = false;
    std::size_t columns_ = 0;  ///< of a block
    std::size_t rows_ = 0;
    std::size_t across_ = 0;       ///< number of blocks side by side
    std::size_t block_bytes_ = 0;  ///< size of a block as libtiff returns it
    std::size_t row_bytes_ = 0;    ///< size of a row of a block, after the chroma is expanded
    std::size_t chroma_across_ = 1;
    std::size_t chroma_down_ = 1;
    std::vector<std::uint16_t> planes_;  ///< planes that are read
    std::vector<std::uint8_t> band_;     ///< [plane][block] rows of the blocks side by side
    std::vector<std::uint8_t> block_;    ///< the block as libtiff returns it, if it has to be rearranged
};

std::size_t size_of(RowSource::Sample sample) {
    switch (sample) {
        case RowSource::Sample::Byte:
            return sizeof(std::uint8_t);
        case RowSource::Sample::Word:
            return sizeof(std::uint16_t);
        case RowSource::Sample::Float:
            break;
    }
    return sizeof(float);
}

}  // namespace

Result<RowSource> open_tiff(std::string_view bytes, const ImageHeader& header, TiffUse use, std::size_t directory) {
    const TiffDirectory tags(bytes, directory);
    if (auto checked = check_directory(tags); !checked) return tl::unexpected(checked.error());
    const auto blocks = std::make_shared<Blocks>(bytes, header.decoder_bytes, directory);
    TIFF* const tiff = blocks->get();
    if (tiff == nullptr || field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH) != header.width ||
        field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH) != header.height)
        return broken_image();
    if (auto checked = check_structure(tiff, tags); !checked) return tl::unexpected(checked.error());
    auto pixels = read_pixels(tiff, tags, use);
    if (!pixels) return tl::unexpected(pixels.error());
    if (auto checked = check_compression(tiff, *pixels, bytes); !checked) return tl::unexpected(checked.error());
    if (auto described = blocks->describe(header, *pixels); !described) return tl::unexpected(described.error());
    if (blocks->are_converted(*pixels)) pixels->space = Space::Rgb;

    constexpr std::uint64_t kStepPixels = std::uint64_t{1} << 18;
    RowSource source = describe_tiff_rows(*pixels, use);
    source.width = static_cast<int>(header.width);
    source.height = static_cast<int>(header.height);
    source.orientation = field<std::uint16_t>(tiff, TIFFTAG_ORIENTATION);
    source.step = static_cast<int>(std::clamp<std::uint64_t>(kStepPixels / header.width, 1, 256));
    const std::size_t pixel = static_cast<std::size_t>(source.channels) * size_of(source.sample);
    source.read = [blocks, convert = convert_tiff_rows(*pixels, use), pixel, row = pixel * header.width](
                      int begin, int end, void* rows) {
        auto* to = static_cast<std::uint8_t*>(rows);
        for (auto y = static_cast<std::size_t>(begin); y < static_cast<std::size_t>(end); ++y, to += row) {
            if (!blocks->read_row(y, convert, to, pixel)) return false;
        }
        return true;
    };
    return source;
}

}  // namespace ccdt::api
