// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/picture_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "api/image/broken_image.h"
#include "core/base/elementary.h"
#include "core/picture/srgb.h"

namespace ccdt::api {
namespace {

struct Size {
    std::uint64_t width = 0;
    std::uint64_t height = 0;
};

/// Maps the pixels of the file's rows to the upright picture.
struct Placement {
    Size size;                 ///< size of the upright picture
    std::ptrdiff_t start = 0;  ///< index of the file's first pixel in the upright picture
    std::ptrdiff_t right = 0;  ///< index step from a pixel to the next one in the same row of the file
    std::ptrdiff_t down = 0;   ///< index step from a pixel to the pixel below it in the file
};

/// @param orientation  orientation of EXIF, 1 to 8; other values are treated as 1, upright
Placement position(Size file, int orientation) {
    if (orientation < 1 || orientation > 8) orientation = 1;
    const bool turned = orientation >= 5;
    const Size size = turned ? Size{file.height, file.width} : file;
    const auto width = static_cast<std::ptrdiff_t>(size.width);
    const auto height = static_cast<std::ptrdiff_t>(size.height);
    // Whether the first pixel of the file is at the right side of the upright picture, and whether it is at the bottom.
    const bool from_right = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
    const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
    const std::ptrdiff_t start = (from_right ? width - 1 : 0) + (from_bottom ? (height - 1) * width : 0);
    const std::ptrdiff_t along = from_right ? -1 : 1;
    const std::ptrdiff_t across = from_bottom ? -width : width;
    return turned ? Placement{size, start, across, along} : Placement{size, start, along, across};
}

/// Interpretation of the samples of the file.
struct Encoding {
    std::ptrdiff_t channels = 1;
    bool colour = false;  ///< if true, the first three channels are red, green, blue; otherwise the first is grey
    int alpha = -1;       ///< channel of alpha; -1: none
    bool premultiplied = false;
    RowSource::Curve curve = RowSource::Curve::Srgb;
    float gamma = 1;                    ///< exponent of Curve::Gamma
    std::vector<ToneCurve> curves;      ///< one for grey or three for colours; used instead of `curve` if not empty
    std::optional<LightMatrix> matrix;  ///< applied to linear light; none: the primaries are those of sRGB
    /// sRGB values of the ground, red, green and blue; none: there is no alpha, or it is kept.
    std::optional<std::array<float, 3>> ground;

    float to_linear(float value, std::size_t channel) const {
        if (!curves.empty()) return curves[channel](value);
        if (curve == RowSource::Curve::Linear) return value;
        if (curve == RowSource::Curve::Gamma) return elementary::pow(value, gamma);
        return light_of_srgb(value);
    }
};

/// Converts samples of one type to fractions of the full range, and to linear light. Uses tables for integers.
template <class Sample>
class SampleReader {
public:
    explicit SampleReader(const Encoding& encoding) : encoding_(encoding) {
        if constexpr (std::is_integral_v<Sample>) {
            tables_.resize(std::max<std::size_t>(encoding.curves.size(), 1));
            for (std::size_t channel = 0; channel < tables_.size(); ++channel) tables_[channel] = make_table(channel);
            for (std::size_t channel = 0; channel < 3; ++channel)
                values_[channel] = tables_[std::min(channel, tables_.size() - 1)].data();
        }
    }

    static float share(Sample sample) {
        if constexpr (std::is_integral_v<Sample>) {
            return static_cast<float>(sample) / static_cast<float>(kFull);
        } else {
            return sample > 0 ? std::min(sample, Sample{1}) : 0;  // NaN: 0
        }
    }

    float linear(Sample sample, std::size_t channel) const {
        if constexpr (std::is_integral_v<Sample>) {
            return values_[channel][sample];
        } else {
            return encoding_.to_linear(share(sample), channel);
        }
    }

    /// Returns the light of a premultiplied sample.
    float linear(Sample sample, std::size_t channel, float alpha) const {
        return alpha > 0 ? encoding_.to_linear(std::min(share(sample) / alpha, 1.0F), channel) : 0;
    }

private:
    static constexpr Sample kFull = std::numeric_limits<Sample>::max();

    std::vector<float> make_table(std::size_t channel) const {
        std::vector<float> table(std::size_t{kFull} + 1);
        for (std::size_t i = 0; i < table.size(); ++i)
            table[i] = encoding_.to_linear(static_cast<float>(i) / static_cast<float>(kFull), channel);
        return table;
    }

    const Encoding& encoding_;
    std::vector<std::vector<float>> tables_;
    std::array<const float*, 3> values_{};
};

/// Converts linear light from other primaries to those of sRGB. Computes in doubles, because large terms cancel if the
/// primaries nearly coincide.
class ForeignLight {
public:
    explicit ForeignLight(const LightMatrix& matrix) : matrix_(matrix) {
        for (std::size_t i = 0; i < 3; ++i)
            weights_[i] = ccdt::luminance_of<double>(matrix[0][i], matrix[1][i], matrix[2][i]);
    }

    float luminance_of(float red, float green, float blue) const {
        return settle(weights_[0] * red + weights_[1] * green + weights_[2] * blue);
    }

    /// Returns the light with the primaries of sRGB. A colour outside the gamut of sRGB is mixed with just enough grey
    /// of the same luminance. Clipping would change the luminance.
    std::array<float, 3> convert(float red, float green, float blue) const {
        std::array<double, 3> light{};
        for (std::size_t i = 0; i < 3; ++i)
            light[i] = double{matrix_[i][0]} * red + double{matrix_[i][1]} * green + double{matrix_[i][2]} * blue;
        const double low = std::min(std::min(light[0], light[1]), light[2]);
        const double high = std::max(std::max(light[0], light[1]), light[2]);
        if (low >= 0 && high <= 1) return {settle(light[0]), settle(light[1]), settle(light[2])};
        const double grey = luminance_of(red, green, blue);
        double kept = 1;
        if (low < 0) kept = std::min(kept, grey / (grey - low));
        if (high > 1) kept = std::min(kept, (1 - grey) / (high - grey));
        const auto mixed = [&](double value) { return settle(grey + kept * (value - grey)); };
        return {mixed(light[0]), mixed(light[1]), mixed(light[2])};
    }

private:
    /// Rounds light that is nearly white to exactly white, so that white areas get no dots.
    static float settle(double light) {
        constexpr double kWhite = 1 - 1e-6;
        return light >= kWhite ? 1.0F : static_cast<float>(std::max(light, 0.0));
    }

    LightMatrix matrix_;
    std::array<double, 3> weights_{};
};

/// Picture whose planes are being filled.
class Draft {
public:
    /// @param light      number of planes, without alpha
    /// @param has_alpha  if false, the picture is opaque
    Draft(Size size, std::size_t light, bool has_alpha, const NewPlane& make_plane)
        : width_(static_cast<int>(size.width)),
          height_(static_cast<int>(size.height)),
          pixels_(static_cast<std::size_t>(size.width * size.height)) {
        for (std::size_t i = 0; i < light; ++i) light_[i] = make_plane(pixels_);
        if (has_alpha) alpha_ = make_plane(pixels_);
    }

    void set_alpha(std::ptrdiff_t pixel, float alpha) const { alpha_[pixel] = alpha; }
    float alpha_of(std::ptrdiff_t pixel) const { return alpha_[pixel]; }

    /// Sets a row of pixels to the means of the squares in `squares`, a draft that is one square high.
    /// @tparam kSide  side of the squares
    /// @param first   index of the first pixel
    /// @param step    difference between the indices of successive pixels of the row
    template <int kSide>
    void set_means(const Draft& squares, std::ptrdiff_t first, std::ptrdiff_t step) const {
        const std::ptrdiff_t width = squares.width_;
        for (std::size_t plane = 0; plane < light_.size() && light_[plane]; ++plane) {
            const float* from = squares.light_[plane].get();
            float* to = light_[plane].get() + first;
            for (std::ptrdiff_t x = 0; x < width; x += kSide, to += step) {
                float sum = 0;
                for (std::ptrdiff_t row = 0; row < kSide; ++row) {
                    for (std::ptrdiff_t column = 0; column < kSide; ++column) sum += from[row * width + x + column];
                }
                *to = sum / (kSide * kSide);
            }
        }
    }

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
        set(0, pixel, luminance_of(red, green, blue));
    }

    void set_colour(std::ptrdiff_t pixel, float red, float green, float blue, const ForeignLight& primaries) const {
        set(0, pixel, primaries.luminance_of(red, green, blue));
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

    void set_colour(std::ptrdiff_t pixel, float red, float green, float blue, const ForeignLight& primaries) const {
        const auto light = primaries.convert(red, green, blue);
        set_colour(pixel, light[0], light[1], light[2]);
    }

    ColourPicture picture() const { return {width(), height(), light(0), light(1), light(2), alpha()}; }
};

/// Stores pixels in a draft as they look on a ground. The alpha of a pixel must be set before its colour.
template <class AnyDraft>
class DraftOnGround {
public:
    /// @param ground  sRGB values, red, green and blue
    DraftOnGround(const AnyDraft& draft, const std::array<float, 3>& ground)
        : draft_(draft), ground_(ground), is_grey_(ground[0] == ground[1] && ground[1] == ground[2]) {}

    void set_alpha(std::ptrdiff_t pixel, float alpha) const { draft_.set_alpha(pixel, alpha); }

    void set_grey(std::ptrdiff_t pixel, float grey) const {
        if (!is_grey_) return set_colour(pixel, grey, grey, grey);
        draft_.set_grey(pixel, seen(pixel, 0, grey));
        make_opaque(pixel);
    }

    void set_colour(std::ptrdiff_t pixel, float red, float green, float blue) const {
        draft_.set_colour(pixel, seen(pixel, 0, red), seen(pixel, 1, green), seen(pixel, 2, blue));
        make_opaque(pixel);
    }

    void set_colour(std::ptrdiff_t pixel, float red, float green, float blue, const ForeignLight& primaries) const {
        const auto light = primaries.convert(red, green, blue);
        set_colour(pixel, light[0], light[1], light[2]);
    }

private:
    float seen(std::ptrdiff_t pixel, std::size_t channel, float light) const {
        return displayed_light(light, ground_[channel], draft_.alpha_of(pixel));
    }

    void make_opaque(std::ptrdiff_t pixel) const { draft_.set_alpha(pixel, draft_.alpha_of(pixel) > 0 ? 1 : 0); }

    const AnyDraft& draft_;
    const std::array<float, 3>& ground_;
    bool is_grey_;
};

template <class AnyDraft>
using PictureOf = decltype(std::declval<AnyDraft>().picture());

/// Stores a row of the file in the picture. For speed, each kind of row has its own short loop.
/// @param count  number of pixels in the row
/// @param y      number of the row in the file
template <class Sample, class AnyDraft>
void store_row(const Sample* row, std::ptrdiff_t count, const SampleReader<Sample>& reader, const Encoding& encoding,
               const Placement& placement, std::ptrdiff_t y, const AnyDraft& draft) {
    const auto for_each = [&, step = encoding.channels, start = placement.start + y * placement.down,
                           right = placement.right](const auto& store) {
        for (std::ptrdiff_t i = 0; i < count; ++i) store(row + i * step, start + i * right);
    };
    const auto store_colours = [&](const auto& linear) {
        if (!encoding.colour) {
            for_each([&](const Sample* pixel, std::ptrdiff_t to) { draft.set_grey(to, linear(pixel, 0)); });
        } else if (encoding.matrix) {
            for_each([&, primaries = ForeignLight(*encoding.matrix)](const Sample* pixel, std::ptrdiff_t to) {
                draft.set_colour(to, linear(pixel, 0), linear(pixel, 1), linear(pixel, 2), primaries);
            });
        } else {
            for_each([&](const Sample* pixel, std::ptrdiff_t to) {
                draft.set_colour(to, linear(pixel, 0), linear(pixel, 1), linear(pixel, 2));
            });
        }
    };
    const auto alpha_of = [&](const Sample* pixel) { return reader.share(pixel[encoding.alpha]); };
    if (encoding.alpha >= 0)
        for_each([&](const Sample* pixel, std::ptrdiff_t to) { draft.set_alpha(to, alpha_of(pixel)); });
    if (encoding.premultiplied) {
        store_colours([&](const Sample* pixel, std::size_t channel) {
            return reader.linear(pixel[channel], channel, alpha_of(pixel));
        });
    } else {
        store_colours([&](const Sample* pixel, std::size_t channel) { return reader.linear(pixel[channel], channel); });
    }
}

/// Returns the interpretation of a source's samples.
/// @param conversion  gives the curves and the matrix; null: none
/// @param ground      as Reading::ground
Encoding encoding_of(const RowSource& source, const ColourConversion* conversion, const std::optional<Light>& ground) {
    Encoding encoding{source.channels,
                      source.channels >= 3,
                      source.alpha,
                      source.premultiplied,
                      source.curve,
                      source.gamma,
                      {},
                      {},
                      {}};
    if (ground && source.alpha >= 0) {
        const auto value = [](float light) { return static_cast<float>(srgb_of_light(static_cast<double>(light))); };
        encoding.ground = {value(ground->red), value(ground->green), value(ground->blue)};
    }
    if (conversion != nullptr) {
        encoding.curves = conversion->curves;
        encoding.matrix = conversion->matrix;
    }
    return encoding;
}

template <class AnyDraft, class Sample>
Result<PictureOf<AnyDraft>> read_pixels(const RowSource& source, const Encoding& encoding, const NewPlane& make_plane) {
    const SampleReader<Sample> reader(encoding);
    const Size size{static_cast<std::uint64_t>(source.width), static_cast<std::uint64_t>(source.height)};
    const Placement placement = position(size, source.orientation);
    const int step = std::min(source.step, source.height);
    const std::size_t row_size = static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.channels);
    std::vector<Sample> rows(static_cast<std::size_t>(step) * row_size);

    const AnyDraft draft(placement.size, encoding.alpha >= 0, make_plane);
    const auto store = [&](int y, const Sample* row) {
        if (encoding.ground) {
            store_row(row, source.width, reader, encoding, placement, y, DraftOnGround(draft, *encoding.ground));
        } else {
            store_row(row, source.width, reader, encoding, placement, y, draft);
        }
    };
    for (int begin = 0; begin < source.height; begin += std::min(step, source.height - begin)) {
        const int end = begin + std::min(step, source.height - begin);
        if (!source.read(begin, end, rows.data())) return broken_image();
        for (int y = begin; y < end; ++y) store(y, rows.data() + static_cast<std::size_t>(y - begin) * row_size);
    }
    return draft.picture();
}

/// Reads each square of pixels as one pixel with the square's mean light. The picture must be opaque and consist of
/// whole squares.
template <int kSide, class AnyDraft, class Sample>
Result<PictureOf<AnyDraft>> read_means(const RowSource& source, const Encoding& encoding, const NewPlane& make_plane) {
    const SampleReader<Sample> reader(encoding);
    const auto width = static_cast<std::uint64_t>(source.width), height = static_cast<std::uint64_t>(source.height);
    const Placement placement = position({width / kSide, height / kSide}, source.orientation);
    const int step = std::min(source.step, source.height);
    const std::size_t row_size = static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.channels);
    std::vector<Sample> rows(static_cast<std::size_t>(step) * row_size);

    const AnyDraft draft(placement.size, false, make_plane);
    const Placement in_squares = position({width, kSide}, 1);
    const AnyDraft squares(in_squares.size, false, new_plane);
    for (int begin = 0; begin < source.height; begin += std::min(step, source.height - begin)) {
        const int end = begin + std::min(step, source.height - begin);
        if (!source.read(begin, end, rows.data())) return broken_image();
        for (int y = begin; y < end; ++y) {
            store_row(rows.data() + static_cast<std::size_t>(y - begin) * row_size, source.width, reader, encoding,
                      in_squares, y % kSide, squares);
            if (y % kSide == kSide - 1)
                draft.template set_means<kSide>(squares, placement.start + y / kSide * placement.down, placement.right);
        }
    }
    return draft.picture();
}

/// @param reduce  as Reading::reduce
template <class AnyDraft, class Sample>
Result<PictureOf<AnyDraft>> read_samples(const RowSource& source, const Encoding& encoding, int reduce,
                                         const NewPlane& make_plane) {
    static_assert(Reading::kMaxReduced == 4);
    const bool whole = source.width % reduce == 0 && source.height % reduce == 0;
    if (whole && encoding.alpha < 0) {
        if (reduce == 2) return read_means<2, AnyDraft, Sample>(source, encoding, make_plane);
        if (reduce == 3) return read_means<3, AnyDraft, Sample>(source, encoding, make_plane);
        if (reduce == 4) return read_means<4, AnyDraft, Sample>(source, encoding, make_plane);
    }
    return read_pixels<AnyDraft, Sample>(source, encoding, make_plane);
}

/// Returns the same source, which reports the share of its rows that are read.
RowSource with_progress(const RowSource& source, const std::function<void(double)>& progress) {
    RowSource observed = source;
    if (!progress) return observed;
    observed.read = [read = source.read, height = source.height, &progress](int begin, int end, void* rows) {
        const bool is_read = read(begin, end, rows);
        if (is_read && end < height) progress(static_cast<double>(end) / height);
        return is_read;
    };
    return observed;
}

template <class AnyPicture>
using DraftOf = std::conditional_t<std::is_same_v<AnyPicture, Picture>, GreyDraft, ColourDraft>;

}  // namespace

std::shared_ptr<float[]> new_plane(std::size_t size) {
    return std::make_shared_for_overwrite<float[]>(size);
}

template <class AnyPicture>
Result<AnyPicture> read_picture(const RowSource& source, const ColourConversion* conversion, const Reading& reading,
                                const NewPlane& make_plane) {
    using AnyDraft = DraftOf<AnyPicture>;
    const RowSource observed = with_progress(source, reading.progress);
    const Encoding encoding = encoding_of(source, conversion, reading.ground);
    switch (source.sample) {
        case RowSource::Sample::Byte:
            return read_samples<AnyDraft, std::uint8_t>(observed, encoding, reading.reduce, make_plane);
        case RowSource::Sample::Word:
            return read_samples<AnyDraft, std::uint16_t>(observed, encoding, reading.reduce, make_plane);
        case RowSource::Sample::Float:
            break;
    }
    return read_samples<AnyDraft, float>(observed, encoding, reading.reduce, make_plane);
}

template Result<Picture> read_picture(const RowSource&, const ColourConversion*, const Reading&, const NewPlane&);
template Result<ColourPicture> read_picture(const RowSource&, const ColourConversion*, const Reading&, const NewPlane&);

}  // namespace ccdt::api
