// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/run/deadline.h"

namespace ccdt::api {
namespace {

Result<void> stopped_if(bool stopped) {
    if (stopped) return failure(ErrorCode::Stopped, "the computation was stopped");
    return {};
}

}  // namespace

Result<void> check_stop(const std::stop_token& stop) {
    return stopped_if(stop.stop_requested());
}

Result<void> check_whole(bool stopped, OnStop on_stop) {
    return stopped_if(stopped && on_stop == OnStop::Error);
}

std::stop_token stop_of_writing(const Control& control, OnStop on_stop) {
    return on_stop == OnStop::Partial ? std::stop_token() : control.stop;
}

}  // namespace ccdt::api
