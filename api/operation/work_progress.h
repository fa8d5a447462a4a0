// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string_view>

#include "api/decode/decode.h"
#include "api/run/options.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Reports the progress of a whole computation: while pictures are decoded, before points move, while they move, and
/// while the answer is written. Must outlive the decoders and the control that it returns.
///
/// Decoders and moving points report their own progress. In between, the tasks of the calling thread report an estimate
/// that approaches the share at the end of the current step as the time passes.
class WorkProgress : private Executor {
public:
    /// @param cost  of the whole computation, including the decoding
    WorkProgress(const Control& control, const Cost& cost);

    /// Returns the same decoders, which report progress while they decode pictures. `decode` must outlive them.
    Decode observe(const Decode& decode);

    /// Returns the same control, which reports the progress of later steps as a part of the whole computation.
    Control control();

private:
    using Clock = std::chrono::steady_clock;

    template <class AnyPicture>
    Decode::To<AnyPicture> observe(const Decode::To<AnyPicture>& decode);

    double moving() const;
    double share_of(std::string_view file, const Reading& reading) const;
    void run(std::size_t count, const std::function<void(std::size_t)>& task) override;
    void move();
    void reach(double share, double next);
    void report(double share);

    const Control& control_;
    const double seconds_;        ///< estimated time of the whole computation
    const double after_;          ///< share of the work after points have moved
    double before_;               ///< share of the work before points move
    double reached_ = 0;          ///< share at the beginning of the current step
    double next_ = 0;             ///< estimated share at the end of the current step
    Clock::time_point since_;     ///< beginning of the current step
    Progress state_;              ///< the latest report
    double shown_ = 0;            ///< the latest reported share
    Clock::time_point reported_;  ///< time of the latest report
};

}  // namespace ccdt::api
