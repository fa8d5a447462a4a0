// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>

#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "server/processes/unique_fd.h"
#include "server/requests/compute.h"

namespace ccdt::server {

/// Messages between the server, the fork server and the computation processes. These programs are built together, so
/// structs are sent as they are in memory.
///
/// Two sockets connect a computation process to the server. The channel is a stream of calls and replies. The events
/// socket carries single messages: orders of the process to the decoder (see decoder_protocol.h) and, at the end of the
/// process, the fork server's report. Shared memory holds the number of threads that the process may use.

/// Files that the server sends to a computation process.
struct ComputeFiles {
    UniqueFd channel;
    UniqueFd events;
    UniqueFd threads;  ///< file of a SharedNumber: number of threads that a computation may use
};

/// Order to the fork server to fork a computation process. The message carries the files of ComputeFiles.
struct ForkOrder {
    std::int32_t nice = 0;  ///< nice value of the process
};

/// Report of the fork server that a process has ended or could not be forked.
struct ChildEnd {
    std::int32_t fork_error = 0;  ///< errno of fork; 0: the process was forked
    std::int32_t status = 0;      ///< status of waitpid
};

/// Message to a computation process. If the kind is Ask, the texts of the request follow. Yield lowers the priority of
/// the process for good.
struct Call {
    enum class Kind : std::uint32_t { Ask, Stop, Yield };
    static constexpr std::size_t kTexts = 5;  ///< path, query, content type, Accept header, body

    Kind kind = Kind::Ask;
    std::uint32_t compressed = 0;  ///< 1: compress the body if that is worthwhile
    std::int32_t nice = 0;         ///< nice value for the kind Yield
    std::uint64_t number = 0;      ///< number of the computation, so that a late Stop does not stop the next one
    api::Limits limits;
    std::array<std::uint64_t, kTexts> sizes{};
};

/// Message from a computation process, followed by texts. For each request, the process sends any number of Steps
/// (progress), then an Answer or a Failure. If the body is large, the process sends it before the Answer: first a Head,
/// which is the answer without its body, then the Pieces of the body.
struct Reply {
    enum class Kind : std::uint32_t { Step, Head, Piece, Answer, Failure };
    /// Media type, coding, body or piece of a body, list of repairs, warnings. For a failure: message, field.
    static constexpr std::size_t kTexts = 5;

    Kind kind = Kind::Step;
    std::uint32_t code = 0;  ///< ErrorCode of a failure
    Progress progress;
    api::Timings timings;
    std::uint64_t decoder_deaths = 0;  ///< count for this computation: see ComputeSupervisor::Counts
    // Members of api::Answer that are not texts:
    std::uint64_t sites = 0;
    std::uint64_t pixels = 0;
    std::uint32_t partial = 0;
    std::uint32_t repeats = 0;
    std::uint32_t streamed = 0;
    double radius = 0;  ///< radius of a halftone's dots; 0: unknown
    double tone = 0;
    double plot_seconds = -1;  ///< time in which a plotter draws the answer; < 0: unknown
    std::array<std::uint64_t, kTexts> sizes{};
};

static_assert(std::is_trivially_copyable_v<Call> && std::is_trivially_copyable_v<Reply>);

}  // namespace ccdt::server
