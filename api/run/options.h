// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::api {

/// Limits on what one request may ask for.
struct Limits {
    std::size_t max_sites = 2'000'000;
    std::size_t max_pixels = 64'000'000;  ///< of a decoded picture, and of one that is drawn
};

/// Estimate of what computing takes.
struct Cost {
    std::size_t memory = 0;  ///< bytes at most, the answer among them; not those that the request holds itself
    double seconds = 0;      ///< about, on one core of 2020 or so
    std::size_t answer = 0;  ///< bytes of the answer's body at least, as far as that is known
};

/// Option that came as text: a query parameter or a form field.
struct TextOption {
    std::string name;
    std::string value;
};

/// Milliseconds spent, for Server-Timing.
struct Timings {
    double decode = 0;
    double optimise = 0;
    double encode = 0;
    double processor = 0;       ///< of all threads, but for decoding; filled, as the next one, by whoever has them
    std::uint32_t threads = 0;  ///< that have worked at once, at most; 0: nothing was computed
};

/// Dots of a halftone, for whoever draws them himself.
struct DotSize {
    double radius = 0;  ///< pixels of the picture
    double tone = 1;    ///< what they cover over what they should
};

/// Answer to a request, as it goes back to the client.
struct Answer {
    std::string media_type;
    std::string body;
    bool streamed = false;             ///< the body was taken piece by piece: see BodyTaker
    std::string coding = {};           ///< in which the body is compressed; empty: not
    std::size_t sites = 0;             ///< placed for it
    std::size_t pixels = 0;            ///< of a picture decoded for it
    std::string repaired = {};         ///< what was wrong with a polygon, as JSON; empty: nothing, or the body tells
    std::string warnings = {};         ///< about the request, in the same way
    bool partial = false;              ///< of a run that was stopped, which the request allows
    bool repeats = true;               ///< to the byte, however often it is computed
    std::optional<DotSize> dots = {};  ///< of a halftone
    std::optional<double> plot_seconds = {};  ///< that a plotter draws it
};

}  // namespace ccdt::api
