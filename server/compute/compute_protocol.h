// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>

#include "api/run/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/processes/unique_fd.h"
#include "server/work/computation.h"

namespace ccdt::server {

/// Messages between the server, the fork server and the processes that compute. They are built together, so
/// structs travel as they are.
///
/// A process has two sockets. Over its channel, a stream, come calls and go replies. Over the other one, which keeps
/// messages apart, go its orders to the decoder, as decoder_protocol.h has them, and, when it has ended, comes from the
/// fork server how. How many threads it may have it reads in memory that it shares with the server.

/// What a process that computes has of the server.
struct ComputeFiles {
    UniqueFd channel;
    UniqueFd events;
    UniqueFd threads;  ///< of a SharedNumber: how many a computation may have now
};

/// Order to the fork server, with the files: another process is wanted.
struct ForkOrder {
    std::int32_t nice = 0;  ///< how much it gives way to others
};

/// News from the fork server: the process has ended, or there was none.
struct ChildEnd {
    std::int32_t fork_error = 0;  ///< errno for why there was none; 0: there was
    std::int32_t status = 0;      ///< as waitpid tells it
};

/// Message to a process that computes. Kind Ask is followed by the texts of the request.
struct Call {
    enum class Kind : std::uint32_t { Ask, Stop };
    static constexpr std::size_t kTexts = 5;  ///< path, query, content type, accept, body

    Kind kind = Kind::Ask;
    std::uint32_t compressed = 0;
    std::uint64_t number = 0;  ///< of the computation: a stop that comes late must not end the next one
    api::Limits limits;
    std::array<std::uint64_t, kTexts> sizes{};
};

/// Message from a process that computes, followed by texts: any number of times Step, then Answer or Failure. The body
/// of a large answer comes before it, as Head, with all else of the answer, and any number of Pieces.
struct Reply {
    enum class Kind : std::uint32_t { Step, Head, Piece, Answer, Failure };
    /// Media type, coding, body or a piece of it, what was repaired, warnings; of a failure: message, field, nothing.
    static constexpr std::size_t kTexts = 5;

    Kind kind = Kind::Step;
    std::uint32_t code = 0;  ///< ErrorCode of a failure
    Progress progress;
    api::Timings timings;
    std::uint64_t decoder_deaths = 0;  ///< of the computation
    std::uint64_t sites = 0;
    std::uint64_t pixels = 0;
    std::uint32_t partial = 0;
    std::uint32_t repeats = 0;
    std::uint32_t streamed = 0;
    double radius = 0;  ///< of a halftone's dots; 0: none is told
    double tone = 0;
    double plot_seconds = -1;  ///< that a plotter draws the answer; below 0: none is told
    std::array<std::uint64_t, kTexts> sizes{};
};

static_assert(std::is_trivially_copyable_v<Call> && std::is_trivially_copyable_v<Reply>);

}  // namespace ccdt::server
