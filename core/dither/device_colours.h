// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/halftone/inks/overprint.h"

namespace ccdt {

/// Largest number of colours of a device.
inline constexpr std::size_t kMaxDeviceColours = 16;

/// Colours of a device, in an opponent space. Each pixel of the device shows one of these colours.
///
/// The space is linear in light. Its axes are luminance, and the differences red-green and blue-yellow of linearised
/// CIELAB. So the blur of the eye is a mean of these values, and distances are about proportional to visible
/// differences. A device that has only greys has a single channel, the luminance.
/// Source: Flohr, Kolpatzik, Balasubramanian, Carrara, Bouman, Allebach 1993, Model based color image quantization.
class DeviceColours {
public:
    using Opponent = std::array<float, 3>;

    /// @param colours  2 to kMaxDeviceColours different colours in linear light; white is (1, 1, 1)
    explicit DeviceColours(std::span<const Light> colours);

    std::size_t count() const { return colours_.size(); }
    bool is_grey() const { return is_grey_; }

    /// Returns a colour of the device.
    const Opponent& operator[](std::size_t number) const { return colours_[number]; }

    /// Returns the number of the device's colour nearest to a given colour. Of several, returns the first.
    std::size_t nearest(const Opponent& colour) const;

    /// Converts light to the opponent space.
    static Opponent opponent(const Light& light);

private:
    std::vector<Opponent> colours_;
    bool is_grey_ = true;
};

}  // namespace ccdt
