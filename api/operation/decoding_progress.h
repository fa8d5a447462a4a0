// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/decode/decode.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {

/// Adds the decoding of pictures to the progress of a computation. Must outlive the decoders and the control that it
/// returns.
class DecodingProgress {
public:
    /// @param seconds  estimated time of the whole computation, including the decoding
    DecodingProgress(const Control& control, double seconds) : control_(control), seconds_(seconds) {}

    /// Returns the same decoders, which report progress while they decode pictures. `decode` must outlive them.
    Decode observe(const Decode& decode);

    /// Returns the same control. It reports the progress of later steps as a part of the work after the decoding.
    Control control();

private:
    template <class AnyPicture>
    Decode::To<AnyPicture> observe(const Decode::To<AnyPicture>& decode);

    double share_of(std::string_view file, const Reading& reading) const;

    const Control& control_;
    const double seconds_;
    double before_ = 0;  ///< share of the work that is completed by decoding
};

}  // namespace ccdt::api
