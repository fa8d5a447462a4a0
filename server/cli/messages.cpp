// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/messages.h"

#include <cmath>
#include <cstdio>

#include <unistd.h>

#include "api/json/json_document.h"
#include "api/output/json_pieces.h"
#include "api/text/numbers.h"

namespace ccdt::server {
namespace {

/// Writes an object of JSON in a line.
class JsonLine {
public:
    explicit JsonLine(std::string_view type) { add("type", type); }

    void add(std::string_view name, std::string_view text) {
        begin(name);
        api::append_json_text(line_, text);
    }

    void add(std::string_view name, double value, int decimals) {
        begin(name);
        api::append_rounded(line_, value, decimals);
    }

    void add(std::string_view name, std::size_t value) {
        begin(name);
        line_ += std::to_string(value);
    }

    void add(std::string_view name, std::span<const std::string> texts) {
        begin(name);
        api::append_array(line_, texts,
                          [](std::string& out, const std::string& text) { api::append_json_text(out, text); });
    }

    std::string finish() { return line_ + "}\n"; }

private:
    void begin(std::string_view name) { line_.append(line_.empty() ? "{\"" : ",\"").append(name).append("\":"); }

    std::string line_;
};

}  // namespace

Messages::Messages(Style style, Interruption& interruption)
    : style_(style), on_terminal_(isatty(STDERR_FILENO) != 0), interruption_(interruption) {}

void Messages::print(const std::string& text) {
    clear_bar();
    std::fputs(text.c_str(), stderr);
}

void Messages::clear_bar() {
    if (!bar_is_shown_) return;
    bar_is_shown_ = false;
    interruption_.set_last_words({});
    std::fputs("\r\x1b[K", stderr);
}

void Messages::report_progress(std::string_view input, double done) {
    constexpr std::chrono::milliseconds kPause{100};
    const auto now = std::chrono::steady_clock::now();
    if (style_ == Style::Quiet || (style_ == Style::Text && !on_terminal_) || now - last_report_ < kPause) return;
    last_report_ = now;
    if (style_ == Style::Json) {
        JsonLine line("progress");
        line.add("input", input);
        line.add("done", done, 3);
        return print(line.finish());
    }
    constexpr std::size_t kLength = 30;
    const auto filled = static_cast<std::size_t>(std::floor(done * kLength));
    const std::string bar = std::string(filled, '#') + std::string(kLength - filled, '-');
    if (!bar_is_shown_) interruption_.set_last_words("\n");
    bar_is_shown_ = true;
    std::fprintf(stderr, "\r\x1b[K[%s] %3d %%  %.40s", bar.c_str(), static_cast<int>(std::floor(100 * done)),
                 std::string(input).c_str());
}

void Messages::report_result(const Finished& finished) {
    const auto& [input, output, media_type, bytes, sites, seconds, dots, plot, files] = finished;
    if (style_ == Style::Json) {
        JsonLine line("result");
        line.add("input", input);
        line.add("output", output);
        if (!files.empty()) line.add("files", files);
        line.add("media_type", media_type);
        line.add("bytes", bytes);
        line.add("sites", sites);
        line.add("seconds", seconds, 3);
        if (dots) line.add("radius", dots->radius, 3);
        if (dots) line.add("tone", dots->tone, 4);
        if (plot) {
            line.add("plot_seconds", plot->seconds, 0);
            line.add("path_mm", plot->path_mm, 0);
            line.add("pen_mm", plot->pen_mm, 3);
        }
        return print(line.finish());
    }
    clear_bar();
    if (style_ == Style::Quiet || !on_terminal_ || output == "-") return;
    std::string text(output);
    text += ": ";
    if (sites > 0) text += std::to_string(sites) + " sites, ";
    if (dots) {
        text += "tone ";
        api::append_rounded(text, dots->tone, 2);
        text += ", ";
    }
    if (plot) {
        api::append_rounded(text += "pen ", plot->pen_mm, 2);
        api::append_rounded(text += " mm, path ", plot->path_mm / 1000, 2);
        api::append_rounded(text += " m, a plotter needs ", plot->seconds / 60, 1);
        text += " min, ";
    }
    text += std::to_string(bytes) + " bytes, ";
    api::append_rounded(text, seconds, 2);
    print(text + " s\n");
}

void Messages::warn(std::string_view input, std::string_view message) {
    if (style_ == Style::Json) {
        JsonLine line("warning");
        line.add("input", input);
        line.add("message", message);
        print(line.finish());
    } else if (style_ == Style::Text) {
        print("ccdt: " + std::string(input) + (input.empty() ? "" : ": ") + "warning: " + std::string(message) + '\n');
    }
}

void Messages::report_error(const Failure& failure) {
    if (style_ != Style::Json) {
        const std::string input(failure.input);
        return print("ccdt: " + input + (input.empty() ? "" : ": ") + failure.message + '\n');
    }
    JsonLine line("error");
    line.add("status", static_cast<std::size_t>(failure.status));
    if (!failure.input.empty()) line.add("input", failure.input);
    if (!failure.option.empty()) line.add("option", failure.option);
    line.add("message", failure.message);
    print(line.finish());
}

}  // namespace ccdt::server
