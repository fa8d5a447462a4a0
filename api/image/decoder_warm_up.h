// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::api {

/// Decodes a picture of one pixel in each format except GIF and BMP. The decoders then have done their one-time work,
/// such as searching the disk for plugins.
void warm_up_decoder();

}  // namespace ccdt::api
