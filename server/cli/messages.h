// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "api/run/options.h"
#include "server/cli/interruption.h"

namespace ccdt::server {

/// Prints the messages of the program on standard error.
///
/// A bar of progress is shown only on a terminal. As JSON, each message is an object on a line of its own.
class Messages {
public:
    enum class Style { Text, Quiet, Json };

    /// @param interruption  ends the line of the bar if the program is interrupted; must outlive this object
    Messages(Style style, Interruption& interruption);

    /// Reports that a share of an answer is done. Prints at most ten reports a second.
    /// @param done  in [0, 1]
    void report_progress(std::string_view input, double done);

    struct Finished {
        std::string_view input;
        std::string_view output;
        std::string_view media_type;
        std::size_t bytes;
        std::size_t sites;
        double seconds;
        std::optional<api::DotSize> dots = {};    ///< of a halftone
        std::optional<api::PlotSize> plot = {};   ///< of a drawing by a plotter
        std::span<const std::string> files = {};  ///< files that replace `output`, if there are several
    };
    /// Reports that an answer is complete. As text, the report is printed only on a terminal.
    void report_result(const Finished& finished);

    void warn(std::string_view input, std::string_view message);

    struct Failure {
        int status;              ///< exit status for this error
        std::string_view input;  ///< may be empty
        std::string option;      ///< such as `--sites`; may be empty
        std::string message;
    };
    void report_error(const Failure& failure);

private:
    void clear_bar();
    void print(const std::string& text);

    const Style style_;
    const bool on_terminal_;
    Interruption& interruption_;
    bool bar_is_shown_ = false;
    std::chrono::steady_clock::time_point last_report_ = std::chrono::steady_clock::now();
};

}  // namespace ccdt::server
