// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/operation/work_progress.h"

#include <algorithm>
#include <thread>

#include "api/image/image_header.h"
#include "api/output/stage_costs.h"
#include "core/base/elementary.h"

namespace ccdt::api {
namespace {

/// Estimated share that the start has in moving the points. It is needed while the numbers of iterations and rounds are
/// not known yet.
constexpr double kStart = 0.1;

/// Share that the last step approaches.
constexpr double kNearlyDone = 0.99;

/// Returns a part of an estimated cost as a share.
double share_in(const Cost& cost, double seconds) {
    return cost.seconds > 0 ? seconds / cost.seconds : 0;
}

}  // namespace

WorkProgress::WorkProgress(const Control& control, const Cost& cost)
    : control_(control),
      seconds_(cost.seconds),
      after_(share_in(cost, cost.after)),
      before_(share_in(cost, cost.before)),
      since_(Clock::now()),
      reported_(since_) {
    next_ = before_ + kStart * moving();
}

Decode WorkProgress::observe(const Decode& decode) {
    if (!control_.progress) return decode;
    return {observe(decode.grey), observe(decode.colour), decode.surface};
}

template <class AnyPicture>
Decode::To<AnyPicture> WorkProgress::observe(const Decode::To<AnyPicture>& decode) {
    if (!decode) return {};
    return [this, &decode](std::string_view bytes, const Reading& reading, const std::stop_token& stop) {
        const double first = reached_, share = (1 - first) * share_of(bytes, reading);
        Reading own = reading;
        own.progress = [&](double decoded) { reach(first + share * decoded, first + share); };
        auto picture = decode(bytes, own, stop);
        before_ = std::max(before_, first + share);
        reach(first + share, before_ + kStart * moving());
        return picture;
    };
}

Control WorkProgress::control() {
    Control own = control_;
    if (!control_.progress) return own;
    own.executor = this;
    own.progress = [this](const Progress& progress) {
        state_ = progress;
        const double share = before_ + moving() * progress.done();
        const double steps = 3.0 + progress.iterations + progress.rounds;
        const bool is_last = progress.iteration + progress.round >= progress.iterations + progress.rounds;
        reach(share, is_last ? kNearlyDone : share + moving() / steps);
    };
    return own;
}

/// Returns the share of the work in which points move.
double WorkProgress::moving() const {
    return std::max(1 - before_ - after_, 0.0);
}

/// Returns the estimated share of the decoding of a picture in the whole computation.
double WorkProgress::share_of(std::string_view file, const Reading& reading) const {
    constexpr double kMax = 0.9;
    const auto header = read_image_header(file, reading.max_pixels);
    return header ? std::min(decoding_cost({file, *header}).seconds / seconds_, kMax) : 0;
}

void WorkProgress::run(std::size_t count, const std::function<void(std::size_t)>& task) {
    control_.executor->run(count, [&, caller = std::this_thread::get_id()](std::size_t number) {
        task(number);
        if (std::this_thread::get_id() == caller) move();
    });
    move();
}

/// Reports the estimated progress of the current step, unless the latest report is recent.
void WorkProgress::move() {
    constexpr std::chrono::milliseconds kInterval{100};
    constexpr double kMin = 1e-3;  // seconds
    const auto now = Clock::now();
    if (now - reported_ < kInterval) return;
    const double remaining = next_ - reached_;
    const std::chrono::duration<double> elapsed = now - since_;
    report(reached_ + remaining * (1 - elementary::exp(-elapsed.count() / std::max(remaining * seconds_, kMin))));
}

/// Begins the next step.
/// @param share  share of the work that is completed
/// @param next   estimated share at the end of the step
void WorkProgress::reach(double share, double next) {
    reached_ = std::max(share, shown_);
    next_ = std::max(next, reached_);
    since_ = Clock::now();
    report(reached_);
}

void WorkProgress::report(double share) {
    shown_ = share;
    state_.share = share;
    reported_ = Clock::now();
    control_.progress(state_);
}

}  // namespace ccdt::api
