// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Messages between processes of one machine, through sockets. No function raises SIGPIPE; interrupted calls are
/// repeated.

/// The two connected sockets of a pair.
struct SocketPair {
    UniqueFd ours;
    UniqueFd theirs;
};

/// @param type  SOCK_SEQPACKET or SOCK_STREAM
/// @returns     none, with errno set, if the system has no more descriptors
std::optional<SocketPair> make_sockets(int type);

/// Sends one message with open files, whose descriptors are duplicated, over a socket that preserves message
/// boundaries.
/// @returns  false if the other end is closed
bool send_message(int socket, std::span<const std::byte> bytes, std::span<const int> files = {});

/// Waits for a message that was sent by send_message.
/// @param bytes  receives the message, from the beginning; a longer message is cut off
/// @param files  files of the message, in order; elements without a file stay unchanged
/// @returns      number of bytes received; 0: the other end is closed
std::size_t receive_message(int socket, std::span<std::byte> bytes, std::span<UniqueFd> files = {});

/// Size of the message by which the server asks a program whether it is alive. The message carries a socket for the
/// reply.
inline constexpr std::size_t kProbeSize = 1;

/// Sends a probe without waiting.
/// @returns  our end of the reply socket, on which one byte is the reply; none if the probe could not be sent now
UniqueFd send_probe(int socket);

/// Replies to a probe through the socket that it carried.
void answer_probe(const UniqueFd& answer);

/// Whether a probe was answered. Must be called only once our end of the reply socket is readable.
bool is_answered(const UniqueFd& answer);

/// Sends texts one after another over a stream.
/// @returns  false if the other end is closed
bool send_texts(int socket, std::initializer_list<std::string_view> texts);

/// Receives from a stream until `bytes` is full.
/// @returns  false if the stream ends before that
bool receive_all(int socket, std::span<char> bytes);

/// Returns the time-out to pass to poll() so that it ends at a point in time.
/// @param time  none: no time-out
int milliseconds_until(std::optional<std::chrono::steady_clock::time_point> time);

/// Returns the bytes of a value, for other processes of the same build.
template <class T>
std::span<const std::byte> bytes_of(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}
template <class T>
std::span<std::byte> writable_bytes_of(T& value) {
    return std::as_writable_bytes(std::span(&value, 1));
}
template <class T>
std::string_view text_of(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

}  // namespace ccdt::server
