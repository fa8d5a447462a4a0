// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

namespace ccdt::server {

/// Ends the program on SIGHUP, SIGINT, SIGQUIT and SIGTERM, after the removal of an incomplete file. The program then
/// dies by the signal, so that a shell that runs the program in a loop ends the loop as well. This works at any
/// time, even while the program waits for its input or for the reader of its output.
///
/// Must be created before all other threads, because they inherit its signal mask. There may be one object at a time.
class Interruption {
public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// Creates a file by a function that returns its name. From then on, an interruption removes the file.
    /// @returns  the result of the function
    std::string create_file(const std::function<std::string()>& create);

    /// Forgets the file, which is complete or was removed.
    void release_file();

    /// Sets the text that ends the current line of the terminal when the program is interrupted; may be empty.
    void set_last_words(std::string text);

private:
    void wait_for_signals(const std::stop_token& stop);

    sigset_t signals_{};
    sigset_t before_{};

    std::mutex mutex_;  ///< guards the members from here to `last_words_`
    std::string file_;
    std::string last_words_;

    std::jthread watcher_;  ///< last, because it uses all other members
};

}  // namespace ccdt::server
