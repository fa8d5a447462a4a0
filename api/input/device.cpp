// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/device.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "core/dither/device_colours.h"

namespace ccdt::api {
namespace {

constexpr Colour kRed = {255, 0, 0}, kGreen = {0, 255, 0}, kBlue = {0, 0, 255}, kYellow = {255, 255, 0},
                 kOrange = {255, 128, 0};

constexpr std::array<Colour, 3> kBlackWhiteRed = {kBlack, kWhite, kRed};
constexpr std::array<Colour, 3> kBlackWhiteYellow = {kBlack, kWhite, kYellow};
constexpr std::array<Colour, 6> kSpectra6 = {kBlack, kWhite, kYellow, kRed, kBlue, kGreen};
constexpr std::array<Colour, 7> kAcep7 = {kBlack, kWhite, kGreen, kBlue, kRed, kYellow, kOrange};

// Colours as they look on panels, measured by other projects. The colours of bwr and bwy are from a panel of 3.97
// inches with black, white, yellow and red (EP397YR, 2026-03-06), and the colours of spectra6 are from a panel of 7.3
// inches (2026-02-03). Both were measured by OpenDisplay/epaper-dithering (measured_palettes.rs). The colours of acep7
// are from Utzel-Butzel/epdoptimize (default-palettes.json).
constexpr std::array<Colour, 3> kBlackWhiteRedSeen = {{{10, 7, 14}, {173, 178, 174}, {85, 24, 14}}};
constexpr std::array<Colour, 3> kBlackWhiteYellowSeen = {{{10, 7, 14}, {173, 178, 174}, {172, 128, 0}}};
constexpr std::array<Colour, 6> kSpectra6Seen = {
    {{26, 13, 35}, {185, 202, 205}, {202, 184, 0}, {121, 9, 0}, {0, 69, 139}, {40, 82, 57}}};
constexpr std::array<Colour, 7> kAcep7Seen = {
    {{25, 30, 33}, {241, 241, 241}, {83, 164, 40}, {49, 49, 143}, {210, 14, 19}, {243, 207, 17}, {184, 94, 28}}};

struct KnownDevice {
    std::string_view name;
    std::string_view title;
    std::span<const Colour> sent;
    std::span<const Colour> seen;
    std::size_t greys = 0;  ///< number of greys in equal steps of sRGB values; 0: the colours are `sent` and `seen`
};

constexpr std::array<KnownDevice, 8> kDevices = {{
    {"1bit", "Black and white", {}, {}, 2},
    {"gray4", "4 greys", {}, {}, 4},
    {"gray16", "16 greys", {}, {}, 16},
    {"bwr", "Black, white and red", kBlackWhiteRed, kBlackWhiteRedSeen},
    {"bwy", "Black, white and yellow", kBlackWhiteYellow, kBlackWhiteYellowSeen},
    {"spectra6", "Spectra 6", kSpectra6, kSpectra6Seen},
    {"acep7", "ACeP, 7 colours", kAcep7, kAcep7Seen},
    {"custom", "Custom colours", {}, {}},
}};

std::vector<Colour> greys(std::size_t count) {
    std::vector<Colour> colours;
    for (std::size_t i = 0; i < count; ++i) {
        const auto value = static_cast<unsigned char>(255 * i / (count - 1));
        colours.push_back({value, value, value});
    }
    return colours;
}

Device device_of(const KnownDevice& known) {
    Device device;
    device.name = known.name;
    device.title = known.title;
    device.sent = known.greys > 0 ? greys(known.greys) : std::vector(known.sent.begin(), known.sent.end());
    device.seen = known.greys > 0 ? device.sent : std::vector(known.seen.begin(), known.seen.end());
    return device;
}

}  // namespace

bool Device::is_grey() const {
    const bool has_grey_count = sent.size() == 2 || sent.size() == 4 || sent.size() == 16;
    return has_grey_count && sent == greys(sent.size());
}

std::vector<Device> devices() {
    std::vector<Device> all;
    all.reserve(kDevices.size());
    for (const KnownDevice& known : kDevices) all.push_back(device_of(known));
    return all;
}

Result<Device> read_device(const Input& input) {
    std::vector<std::string_view> names;
    names.reserve(kDevices.size());
    for (const KnownDevice& known : kDevices) names.push_back(known.name);
    return read_word(input, names).map([](std::size_t i) { return device_of(kDevices[i]); });
}

Result<std::vector<Colour>> read_device_colours(const Input& input) {
    return read_colours(input, 2, kMaxDeviceColours);
}

}  // namespace ccdt::api
