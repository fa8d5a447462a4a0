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

/// Messages between processes, through sockets. No function raises SIGPIPE. Interrupted calls are repeated.

/// A pair of connected sockets.
struct SocketPair {
    UniqueFd ours;
    UniqueFd theirs;
};

/// Creates a pair of connected sockets.
/// @param type  SOCK_SEQPACKET or SOCK_STREAM
/// @returns     none, with errno set, if the system has no more descriptors
std::optional<SocketPair> make_sockets(int type);

/// Sends one message over a socket that preserves message boundaries. The receiver gets duplicates of the descriptors.
/// @returns  false if the other end is closed
bool send_message(int socket, std::span<const std::byte> bytes, std::span<const int> files = {});

/// Waits for a message from send_message.
/// @param bytes  receives the message; a longer message is truncated
/// @param files  receives the files of the message; further elements stay unchanged
/// @returns      number of bytes received; 0: the other end is closed
std::size_t receive_message(int socket, std::span<std::byte> bytes, std::span<UniqueFd> files = {});

/// Size of a probe in bytes. A probe is a message by which the server asks whether a program is alive. It carries a
/// socket for the reply.
inline constexpr std::size_t kProbeSize = 1;

/// Sends a probe without waiting.
/// @returns  the socket on which one byte will arrive as the reply; none if the probe could not be sent
UniqueFd send_probe(int socket);

/// Replies to a probe through the socket that arrived with the probe.
void answer_probe(const UniqueFd& answer);

/// Whether a probe was answered. Must be called only when the socket from send_probe() is readable.
bool is_answered(const UniqueFd& answer);

/// Sends texts one after another over a stream.
/// @returns  false if the other end is closed
bool send_texts(int socket, std::initializer_list<std::string_view> texts);

/// Receives from a stream until `bytes` is full.
/// @returns  false if the stream ends earlier
bool receive_all(int socket, std::span<char> bytes);

/// Returns the time-out in milliseconds with which poll() returns at a point in time.
/// @param time  none: never
int milliseconds_until(std::optional<std::chrono::steady_clock::time_point> time);

/// Returns the bytes of a value, for a process of the same build.
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
