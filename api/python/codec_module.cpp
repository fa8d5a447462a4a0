// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/pybind11.h>

#include "api/decode/decode.h"
#include "api/python/decode_capsule.h"

/// The module ccdt._codec: decoders of picture files, which ccdt._core calls.
PYBIND11_MODULE(_codec, module) {
    static const ccdt::api::Decode decode = ccdt::api::decode_inline();
    module.doc() = "Decoders of picture files, which ccdt._core calls.";
    module.attr("decode") = pybind11::capsule(&decode, ccdt::python::kDecodeCapsule);
}
