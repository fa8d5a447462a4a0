// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/decode/decode.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

/// Makes decoders that return a small picture for any file. The picture may be transparent. Its values lie at the ends
/// of their range or outside it, and most of them are equal.
///
/// @param input  remaining input, which determines the picture
api::Decode decode_of(Bytes input);

}  // namespace ccdt::fuzz
