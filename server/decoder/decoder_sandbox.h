// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

namespace ccdt::server {

/// Resources that decoding one file may use.
struct DecoderLimits {
    std::size_t memory = 0;            ///< bytes, besides the program's own, the file and the picture
    std::chrono::milliseconds time{};  ///< from the order to the picture
};

/// A sandbox for a process that decodes: it can compute, take memory and write to its standard output.
///
/// Sanitizers reserve address space without end, open files and pipes and make system calls of their own: where they
/// are built in, neither memory nor files are limited and system calls are not filtered.
class Sandbox {
public:
    static constexpr bool kIsWhole =
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
        false;
#else
        true;
#endif

    /// Bytes of a process.
    struct Memory {
        std::size_t space = 0;  ///< of addresses
        std::size_t data = 0;   ///< that it may write to and does not share
    };

    /// Takes the measure of the calling process, which its children will start from, and has it forgo new privileges.
    Sandbox();
    ~Sandbox();
    Sandbox(const Sandbox&) = delete;
    Sandbox& operator=(const Sandbox&) = delete;

    /// errno for why this machine does not filter system calls, told by trying; 0: it does. Without it `enter` sets
    /// the other limits only.
    int filter_error() const {
        return filter_error_;
    }

    /// errno for why there is no Landlock, in the same way, which denies access to all files, ports and processes
    /// outside.
    int landlock_error() const {
        return landlock_error_;
    }

    /// Has the calling process end first if the machine runs out of memory. Where that cannot be said, the limit on
    /// memory has to do.
    /// @param proc  where /proc is open
    static void volunteer_for_out_of_memory(int proc);

    /// Shuts the calling process in, for good.
    /// @param mapped  bytes that it has mapped besides
    /// @returns       false, with errno, if that failed; it must then end. ENOMEM: the limits that it was started with
    ///                (ulimit) leave too little memory
    bool enter(const DecoderLimits& limits, std::size_t mapped) const;

private:
    struct Filter;

    bool limit_resources(const DecoderLimits& limits, std::size_t mapped) const;
    bool filter_calls() const;

    const Memory own_;  ///< of the calling process
    const std::unique_ptr<const Filter> filter_;
    const int filter_error_;
    const int landlock_error_;
};

}  // namespace ccdt::server
