// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/operation/decoding_progress.h"

#include <algorithm>

#include "api/image/image_header.h"
#include "api/output/stage_costs.h"

namespace ccdt::api {

Decode DecodingProgress::observe(const Decode& decode) {
    if (!control_.progress) return decode;
    return {observe(decode.grey), observe(decode.colour), decode.surface};
}

template <class AnyPicture>
Decode::To<AnyPicture> DecodingProgress::observe(const Decode::To<AnyPicture>& decode) {
    if (!decode) return {};
    return [this, &decode](std::string_view bytes, const Reading& reading, const std::stop_token& stop) {
        const double first = before_, share = (1 - first) * share_of(bytes, reading);
        Reading own = reading;
        own.progress = [&](double decoded) {
            before_ = std::max(before_, first + share * decoded);
            control_.progress({.before = before_, .begun = false});
        };
        auto picture = decode(bytes, own, stop);
        before_ = first + share;
        return picture;
    };
}

Control DecodingProgress::control() {
    Control own = control_;
    if (!control_.progress) return own;
    own.progress = [this](Progress progress) {
        progress.before = before_;
        control_.progress(progress);
    };
    return own;
}

/// Returns the estimated share of the decoding of a picture in the whole computation.
double DecodingProgress::share_of(std::string_view file, const Reading& reading) const {
    constexpr double kMost = 0.9;
    const auto header = read_image_header(file, reading.max_pixels);
    return header ? std::min(decoding_cost({file, *header}).seconds / seconds_, kMost) : 0;
}

}  // namespace ccdt::api
