// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "api/input/colour.h"
#include "api/input/option_reader.h"
#include "core/base/result.h"

namespace ccdt::api {

/// A device whose pixels each show one of a few colours.
struct Device {
    std::string name;
    std::string title;         ///< name for people
    std::vector<Colour> sent;  ///< colours in files for the device, in the order of the pixel values
    std::vector<Colour> seen;  ///< the same colours as they look on the device

    /// Returns the number of bits of a pixel: 1, 2 or 4.
    int bits() const { return sent.size() <= 2 ? 1 : sent.size() <= 4 ? 2 : 4; }

    /// Returns whether the sent colours are 2, 4 or 16 greys in equal steps from black to white, so that files can
    /// store grey values instead of a palette.
    bool is_grey() const;
};

/// Returns all devices. The device `custom` has no colours; these come from read_device_colours().
std::vector<Device> devices();

/// Reads the name of a device.
/// Errors: Malformed.
Result<Device> read_device(const Input& input);

/// Reads 2 to kMaxDeviceColours (core/dither/device_colours.h) different colours: text with commas between them, or a
/// JSON array of strings.
/// Errors: Malformed.
Result<std::vector<Colour>> read_device_colours(const Input& input);

}  // namespace ccdt::api
