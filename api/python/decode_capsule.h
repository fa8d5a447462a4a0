// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::python {

/// Name of the capsule by which ccdt._codec gives ccdt._core a pointer to its api::Decode. Both modules are built
/// together. Decoders are in a module of their own, because their shared libraries take longer to load than everything
/// else, and pictures in memory do not need them.
inline constexpr const char* kDecodeCapsule = "ccdt._codec.decode";

}  // namespace ccdt::python
