// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/row_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

namespace ccdt::api {
namespace {

constexpr float kFull = std::numeric_limits<std::uint16_t>::max();

template <class Sample>
std::uint16_t to_word(Sample sample) {
    if constexpr (std::is_same_v<Sample, std::uint8_t>) {
        return static_cast<std::uint16_t>(sample * 257);
    } else if constexpr (std::is_same_v<Sample, std::uint16_t>) {
        return sample;
    } else {
        return sample > 0 ? static_cast<std::uint16_t>(std::lround(std::min(sample, 1.0F) * kFull)) : 0;
    }
}

/// Transforms rows whose samples are of one type.
template <class Sample>
class Transformer {
public:
    Transformer(RowSource source, WordTransform transform)
        : source_(std::move(source)),
          transform_(std::move(transform)),
          width_(static_cast<std::size_t>(source_.width)),
          channels_(static_cast<std::size_t>(source_.channels)),
          colours_(source_.space == RowSource::Space::Inks ? 4 : 3) {}

    bool operator()(int begin, int end, void* rows) {
        const auto count = static_cast<std::size_t>(end - begin);
        samples_.resize(count * width_ * channels_);
        words_.resize(width_ * colours_);
        light_.resize(width_ * 3);
        if (!source_.read(begin, end, samples_.data())) return false;
        auto* to = static_cast<std::uint16_t*>(rows);
        for (std::size_t i = 0; i < count; ++i) to = transform_row(samples_.data() + i * width_ * channels_, to);
        return true;
    }

private:
    std::uint16_t* transform_row(const Sample* samples, std::uint16_t* to) {
        for (std::size_t i = 0; i < width_; ++i) take_colours(samples + i * channels_, &words_[i * colours_]);
        transform_(words_.data(), light_.data(), width_);
        for (std::size_t i = 0; i < width_; ++i) {
            to = std::copy_n(&light_[3 * i], 3, to);
            if (source_.alpha >= 0) *to++ = alpha_of(samples + i * channels_);
        }
        return to;
    }

    std::uint16_t alpha_of(const Sample* pixel) const { return to_word(pixel[source_.alpha]); }

    /// Reads the colours of a pixel. Divides premultiplied colours by alpha.
    void take_colours(const Sample* pixel, std::uint16_t* to) const {
        for (std::size_t i = 0; i < colours_; ++i) to[i] = to_word(pixel[i]);
        if (!source_.premultiplied) return;
        const auto alpha = static_cast<float>(alpha_of(pixel));
        for (std::size_t i = 0; i < colours_; ++i)
            to[i] = alpha > 0 ? to_word(static_cast<float>(to[i]) / alpha) : std::uint16_t{0};
    }

    RowSource source_;
    WordTransform transform_;
    std::size_t width_;
    std::size_t channels_;
    std::size_t colours_;
    std::vector<Sample> samples_;
    std::vector<std::uint16_t> words_;
    std::vector<std::uint16_t> light_;
};

}  // namespace

RowSource transform_rows(RowSource source, WordTransform transform) {
    RowSource transformed = source;
    transformed.sample = RowSource::Sample::Word;
    transformed.channels = source.alpha < 0 ? 3 : 4;
    transformed.alpha = source.alpha < 0 ? -1 : 3;
    transformed.premultiplied = false;
    transformed.space = RowSource::Space::Light;
    const auto sample = source.sample;
    if (sample == RowSource::Sample::Byte)
        transformed.read = Transformer<std::uint8_t>(std::move(source), std::move(transform));
    else if (sample == RowSource::Sample::Word)
        transformed.read = Transformer<std::uint16_t>(std::move(source), std::move(transform));
    else
        transformed.read = Transformer<float>(std::move(source), std::move(transform));
    return transformed;
}

}  // namespace ccdt::api
