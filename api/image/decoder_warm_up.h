// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::api {

/// Decodes a picture of one pixel in each format except GIF and BMP. So the decoders do their one-time work now, such
/// as searching the disk for plugins.
void warm_up_decoder();

}  // namespace ccdt::api
