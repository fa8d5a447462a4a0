// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

namespace ccdt::server {

/// Limits of the resources for decoding one file.
struct DecoderLimits {
    std::size_t memory = 0;       ///< in bytes, in addition to the program, the file and the picture
    std::chrono::seconds time{};  ///< processor time; at least 1 s
};

/// A sandbox in which a process can only compute, allocate memory and use its channels.
///
/// In builds with sanitizers, memory and files are not limited and system calls are not filtered, because sanitizers
/// reserve terabytes of address space, open files and make further system calls.
class Sandbox {
public:
    static constexpr bool kIsWhole =
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
        false;
#else
        true;
#endif

    /// Memory of a process, in bytes.
    struct Memory {
        std::size_t space = 0;  ///< address space
        std::size_t data = 0;   ///< private writable memory
    };

    /// Descriptors that the process may use.
    enum class Channels {
        Output,  ///< standard output, for writing
        Sockets  ///< all sockets that it has, of which none has a number above 15
    };

    /// Measures the memory of the calling process, which its children inherit, and tries the filter and Landlock in a
    /// child. Afterwards, the calling process can gain no privileges (PR_SET_NO_NEW_PRIVS).
    explicit Sandbox(Channels channels = Channels::Output);
    ~Sandbox();
    Sandbox(const Sandbox&) = delete;
    Sandbox& operator=(const Sandbox&) = delete;

    /// Returns 0 if the kernel can filter system calls, otherwise errno. After an error, `enter` omits the filter.
    int filter_error() const {
        return filter_error_;
    }

    /// Returns 0 if Landlock is available, otherwise the errno of the attempt. Landlock denies access to files, ports
    /// and processes outside the sandbox.
    int landlock_error() const {
        return landlock_error_;
    }

    /// Makes the kernel kill the calling process first if the machine runs out of memory. Ignores failures.
    /// @param proc  descriptor of the folder /proc
    static void volunteer_for_out_of_memory(int proc);

    /// Confines the calling process irrevocably.
    /// @param mapped  number of bytes that the process has mapped since the constructor was called
    /// @returns       false, with errno set, on failure; the process must then end. ENOMEM: the inherited limits
    ///                (ulimit) leave too little memory
    bool enter(const DecoderLimits& limits, std::size_t mapped) const;

private:
    struct Filter;

    bool limit_resources(const DecoderLimits& limits, std::size_t mapped) const;
    bool filter_calls() const;

    const Channels channels_;
    const Memory own_;  ///< memory of the process that called the constructor
    const std::unique_ptr<const Filter> filter_;
    const int filter_error_;
    const int landlock_error_;
};

}  // namespace ccdt::server
