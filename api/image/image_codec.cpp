#include "api/image/image_codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "api/image/image_header.h"

namespace ccdt::api {
namespace {

struct Size {
    std::uint64_t width = 0;
    std::uint64_t height = 0;
};

const char* plugin_name(ImageFormat format) {
    switch (format) {
        case ImageFormat::Png:
            return "png";
        case ImageFormat::Jpeg:
            return "jpeg";
        case ImageFormat::WebP:
            return "webp";
        case ImageFormat::Tiff:
            return "tiff";
    }
    return "";
}

tl::unexpected<Error> broken() {
    return failure(ErrorCode::Unusable, "the image is broken or cut short");
}

std::uint64_t pixels_of(int width, int height) {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
}

tl::unexpected<Error> unusual(const char* what) {
    return failure(ErrorCode::Unusable, std::string("the image is of a kind that is not read: ") + what);
}

/// Places where the pixels of the file's rows go in the upright picture.
struct Placement {
    Size size;                 ///< of the upright picture
    std::ptrdiff_t start = 0;  ///< index of the file's first pixel
    std::ptrdiff_t right = 0;  ///< from a pixel to the next in its row of the file
    std::ptrdiff_t down = 0;   ///< from a pixel to the one below it in the file
};

/// @param orientation  EXIF's, 1 to 8; anything else counts as 1, upright
Placement place(Size file, int orientation) {
    if (orientation < 1 || orientation > 8) orientation = 1;
    const bool turned = orientation >= 5;
    const Size size = turned ? Size{file.height, file.width} : file;
    const auto width = static_cast<std::ptrdiff_t>(size.width);
    const auto height = static_cast<std::ptrdiff_t>(size.height);
    // The file's first pixel lies at the right, or at the bottom, of the upright picture.
    const bool from_right = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
    const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
    const std::ptrdiff_t start = (from_right ? width - 1 : 0) + (from_bottom ? (height - 1) * width : 0);
    const std::ptrdiff_t along = from_right ? -1 : 1;
    const std::ptrdiff_t across = from_bottom ? -width : width;
    return turned ? Placement{size, start, across, along} : Placement{size, start, along, across};
}

/// Meaning of the numbers of the file.
struct Encoding {
    enum class Curve { Srgb, Gamma, Linear };

    std::ptrdiff_t channels = 1;
    bool colour = false;  ///< the first three are red, green, blue; else the first is grey
    int alpha = -1;       ///< its channel; -1: none
    bool premultiplied = false;
    Curve curve = Curve::Srgb;
    float gamma = 1;  ///< of Curve::Gamma

    float to_linear(float value) const {
        if (curve == Curve::Linear) return value;
        if (curve == Curve::Gamma) return std::pow(value, gamma);
        return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
    }
};

Encoding encoding_of(const OIIO::ImageSpec& spec) {
    Encoding encoding;
    encoding.channels = spec.nchannels;
    encoding.colour = spec.nchannels >= 3;
    encoding.alpha = spec.alpha_channel;
    encoding.premultiplied = spec.alpha_channel >= 0 && spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0;
    const bool floats = spec.format.is_floating_point();
    const std::string space = spec.get_string_attribute("oiio:ColorSpace", floats ? "linear" : "sRGB");
    const float gamma = spec.get_float_attribute("oiio:Gamma", 0);
    if (OIIO::Strutil::iequals(space, "linear")) {
        encoding.curve = Encoding::Curve::Linear;
    } else if (gamma > 0) {
        encoding.curve = Encoding::Curve::Gamma;
        encoding.gamma = gamma;
    }
    return encoding;
}

/// Turns samples of one type into shares of the full range; integers to linear light by a table.
template <class Sample>
class SampleReader {
public:
    explicit SampleReader(const Encoding& encoding) : encoding_(encoding) {
        if constexpr (std::is_integral_v<Sample>) {
            table_.resize(std::size_t{kFull} + 1);
            for (std::size_t i = 0; i < table_.size(); ++i) {
                table_[i] = encoding.to_linear(static_cast<float>(i) / static_cast<float>(kFull));
            }
        }
    }

    static float share(Sample sample) {
        if constexpr (std::is_integral_v<Sample>) {
            return static_cast<float>(sample) / static_cast<float>(kFull);
        } else {
            return sample > 0 ? std::min(sample, Sample{1}) : 0;  // not a number: 0
        }
    }

    float linear(Sample sample) const {
        if constexpr (std::is_integral_v<Sample>) {
            return table_[sample];
        } else {
            return encoding_.to_linear(share(sample));
        }
    }

    /// Divides a sample by the alpha that it was multiplied by.
    float linear(Sample sample, float alpha) const {
        if (!encoding_.premultiplied) return linear(sample);
        return alpha > 0 ? encoding_.to_linear(std::min(share(sample) / alpha, 1.0F)) : 0;
    }

private:
    static constexpr Sample kFull = std::numeric_limits<Sample>::max();

    const Encoding& encoding_;
    std::vector<float> table_;
};

/// Planes being filled.
class Draft {
public:
    /// @param light  planes besides alpha; without that the picture is opaque
    Draft(Size size, std::size_t light, bool has_alpha, const NewPlane& make_plane)
        : width_(static_cast<int>(size.width)),
          height_(static_cast<int>(size.height)),
          pixels_(static_cast<std::size_t>(size.width * size.height)) {
        for (std::size_t i = 0; i < light; ++i) light_[i] = make_plane(pixels_);
        if (has_alpha) alpha_ = make_plane(pixels_);
    }

    void set_alpha(std::ptrdiff_t pixel, float alpha) const { alpha_[pixel] = alpha; }

protected:
    void set(std::size_t plane, std::ptrdiff_t pixel, float light) const {
        light_[plane][pixel] = std::min(light, 1.0F);
    }

    int width() const { return width_; }
    int height() const { return height_; }
    Plane light(std::size_t plane) const { return {light_[plane], pixels_}; }
    Plane alpha() const { return alpha_ ? Plane(alpha_, pixels_) : Plane(); }

private:
    int width_;
    int height_;
    std::size_t pixels_;
    std::array<std::shared_ptr<float[]>, 3> light_;
    std::shared_ptr<float[]> alpha_;
};

class GreyDraft : public Draft {
public:
    GreyDraft(Size size, bool has_alpha, const NewPlane& make_plane) : Draft(size, 1, has_alpha, make_plane) {}

    void set_grey(std::ptrdiff_t pixel, float grey) const { set(0, pixel, grey); }

    void set_colour(std::ptrdiff_t pixel, float red, float green, float blue) const {
        set(0, pixel, 0.2126F * red + 0.7152F * green + 0.0722F * blue);
    }

    Picture picture() const { return {width(), height(), light(0), alpha()}; }
};

class ColourDraft : public Draft {
public:
    ColourDraft(Size size, bool has_alpha, const NewPlane& make_plane) : Draft(size, 3, has_alpha, make_plane) {}

    void set_grey(std::ptrdiff_t pixel, float grey) const { set_colour(pixel, grey, grey, grey); }

    void set_colour(std::ptrdiff_t pixel, float red, float green, float blue) const {
        set(0, pixel, red);
        set(1, pixel, green);
        set(2, pixel, blue);
    }

    ColourPicture picture() const { return {width(), height(), light(0), light(1), light(2), alpha()}; }
};

template <class AnyDraft>
using PictureOf = decltype(std::declval<AnyDraft>().picture());

/// Puts one row of the file into the picture.
template <class Sample, class AnyDraft>
void store_row(const Sample* sample, std::ptrdiff_t count, const SampleReader<Sample>& reader, const Encoding& encoding,
               const Placement& placement, std::ptrdiff_t row, const AnyDraft& draft) {
    std::ptrdiff_t to = placement.start + row * placement.down;
    for (std::ptrdiff_t i = 0; i < count; ++i, sample += encoding.channels, to += placement.right) {
        const float alpha = encoding.alpha < 0 ? 1.0F : reader.share(sample[encoding.alpha]);
        if (encoding.alpha >= 0) draft.set_alpha(to, alpha);
        const float first = reader.linear(sample[0], alpha);
        if (encoding.colour) {
            draft.set_colour(to, first, reader.linear(sample[1], alpha), reader.linear(sample[2], alpha));
        } else {
            draft.set_grey(to, first);
        }
    }
}

/// Rows that are read at once: whole tiles, or about a megabyte.
int rows_at_once(const OIIO::ImageSpec& spec) {
    if (spec.tile_width > 0) return spec.tile_height;
    const std::uint64_t row_bytes =
        static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.nchannels) * 4;
    return static_cast<int>(std::clamp<std::uint64_t>((1 << 20) / row_bytes, 1, 256));
}

bool read_rows(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, int begin, int end, const OIIO::TypeDesc& type,
               void* rows) {
    // Rows that need no conversion are read where they belong; else the library takes 64 MiB to convert them in.
    const bool as_stored = spec.format == type && spec.channelformats.empty();
    const OIIO::TypeDesc to = as_stored ? OIIO::TypeDesc::UNKNOWN : type;
    if (spec.tile_width == 0) return input.read_scanlines(0, 0, begin, end, 0, 0, spec.nchannels, to, rows);
    return input.read_tiles(0, 0, 0, spec.width, begin, end, 0, 1, 0, spec.nchannels, type, rows);
}

template <class AnyDraft, class Sample>
Result<PictureOf<AnyDraft>> read_pixels(OIIO::ImageInput& input, const OIIO::ImageSpec& spec,
                                        const Placement& placement, const NewPlane& make_plane) {
    const Encoding encoding = encoding_of(spec);
    const SampleReader<Sample> reader(encoding);
    const int step = rows_at_once(spec);
    const auto width = static_cast<std::size_t>(spec.width);
    const std::size_t row_size = width * static_cast<std::size_t>(spec.nchannels);
    std::vector<Sample> rows(static_cast<std::size_t>(std::min(step, spec.height)) * row_size);

    const AnyDraft draft(placement.size, encoding.alpha >= 0, make_plane);
    for (int begin = 0; begin < spec.height; begin += std::min(step, spec.height - begin)) {
        const int end = begin + std::min(step, spec.height - begin);
        // A shortened file may read "well" and only leave a note.
        if (!read_rows(input, spec, begin, end, OIIO::BaseTypeFromC<Sample>::value, rows.data()) || input.has_error()) {
            return broken();
        }
        for (int y = begin; y < end; ++y) {
            store_row(rows.data() + static_cast<std::size_t>(y - begin) * row_size, spec.width, reader, encoding,
                      placement, y, draft);
        }
    }
    return draft.picture();
}

/// Checks that the reader makes of the header what was made of it before.
Result<void> check_spec(const OIIO::ImageSpec& spec, const ImageHeader& header) {
    constexpr int kMaxChannels = 5;  // CMYK and alpha
    if (spec.width < 1 || spec.height < 1) return broken();
    if (pixels_of(spec.width, spec.height) != header.pixels()) return broken();
    if (spec.depth > 1 || spec.deep) return unusual("more than two dimensions");
    if (spec.nchannels < 1 || spec.nchannels > kMaxChannels) return unusual("an odd number of channels");
    if (spec.tile_width > 0 && pixels_of(spec.tile_width, spec.tile_height) > header.pixels() + kMostTilePixels)
        return unusual("tiles much larger than their picture");
    return {};
}

/// Tells a TIFF whose rows the reader turns over by itself, though not as its orientation says.
bool is_converted_ycbcr(const OIIO::ImageSpec& spec) {
    constexpr int kYCbCr = 6;
    constexpr int kJpeg = 7;
    return spec.get_int_attribute("tiff:PhotometricInterpretation") == kYCbCr &&
           spec.get_int_attribute("tiff:Compression") != kJpeg;
}

/// Fetches errors: the library keeps what an input notes until it is fetched, or the thread ends. It may name files of
/// the server, so nobody reads it.
struct NoteDropper {
    OIIO::ImageInput& input;

    ~NoteDropper() { static_cast<void>(input.geterror()); }
};

template <class AnyDraft>
Result<PictureOf<AnyDraft>> read_file(std::string_view bytes, const ImageHeader& header, const NewPlane& make_plane) {
    OIIO::Filesystem::IOMemReader file(bytes.data(), bytes.size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(plugin_name(header.format));
    if (!input) return failure(ErrorCode::Internal, "the image reader is missing");
    const NoteDropper dropper{*input};
    input->threads(1);
    input->set_ioproxy(&file);
    OIIO::ImageSpec wishes;
    OIIO::ImageSpec spec;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    if (!input->open("image", spec, wishes)) return broken();
    if (auto checked = check_spec(spec, header); !checked) return tl::unexpected(checked.error());

    const int orientation =
        header.format == ImageFormat::WebP ? webp_orientation(bytes) : spec.get_int_attribute("Orientation", 1);
    if (orientation != 1 && is_converted_ycbcr(spec)) return unusual("a TIFF of YCbCr that is stored turned");
    const Size size{static_cast<std::uint64_t>(spec.width), static_cast<std::uint64_t>(spec.height)};
    const Placement placement = place(size, orientation);
    const auto read = [&]<class Sample>(Sample) {
        return read_pixels<AnyDraft, Sample>(*input, spec, placement, make_plane);
    };
    if (spec.format == OIIO::TypeDesc::UINT8) return read(std::uint8_t{});
    if (spec.format == OIIO::TypeDesc::UINT16) return read(std::uint16_t{});
    return read(float{});
}

void configure_library() {
    static std::once_flag once;
    std::call_once(once, [] {
        OIIO::attribute("threads", 1);          // a request has one core
        OIIO::attribute("try_all_readers", 0);  // only those that are allowed
    });
}

/// Lock of the library's reader of TIFF, which has known faults with threads.
std::mutex& tiff_mutex() {
    static std::mutex mutex;
    return mutex;
}

template <class AnyDraft>
Result<PictureOf<AnyDraft>> decode(std::string_view bytes, std::size_t max_pixels, const NewPlane& make_plane) {
    const auto header = read_image_header(bytes, max_pixels);
    if (!header) return tl::unexpected(header.error());
    configure_library();
    std::unique_lock<std::mutex> lock;
    if (header->format == ImageFormat::Tiff) lock = std::unique_lock(tiff_mutex());
    try {
        return read_file<AnyDraft>(bytes, *header, make_plane);
    } catch (...) {
        return broken();
    }
}

}  // namespace

std::shared_ptr<float[]> new_plane(std::size_t size) {
    return std::make_shared_for_overwrite<float[]>(size);
}

Result<Picture> decode_image(std::string_view bytes, std::size_t max_pixels, const NewPlane& make_plane) {
    return decode<GreyDraft>(bytes, max_pixels, make_plane);
}

Result<ColourPicture> decode_colour_image(std::string_view bytes, std::size_t max_pixels, const NewPlane& make_plane) {
    return decode<ColourDraft>(bytes, max_pixels, make_plane);
}

Decode decode_inline() {
    return {[](std::string_view bytes, std::size_t max_pixels, const std::stop_token&) {
                return decode_image(bytes, max_pixels);
            },
            [](std::string_view bytes, std::size_t max_pixels, const std::stop_token&) {
                return decode_colour_image(bytes, max_pixels);
            }};
}

}  // namespace ccdt::api
