#pragma once

namespace ccdt::api {

/// Has the decoder do what it does but once, such as looking for plugins among the machine's files, by decoding a pixel
/// of each format.
void warm_up_decoder();

}  // namespace ccdt::api
