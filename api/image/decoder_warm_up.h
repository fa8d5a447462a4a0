// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::api {

/// Makes the decoder do its one-time work, such as searching the disk for plugins, by decoding a pixel of each format.
void warm_up_decoder();

}  // namespace ccdt::api
