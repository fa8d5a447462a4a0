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

/// Messages between processes of this machine, through sockets. Nothing here raises SIGPIPE, and interrupted calls
/// are made again.

/// The two ends of a connection.
struct SocketPair {
    UniqueFd ours;
    UniqueFd theirs;
};

/// @param type  SOCK_SEQPACKET or SOCK_STREAM
/// @returns     none, with errno, if the system has no more
std::optional<SocketPair> make_sockets(int type);

/// Sends one message with open files, which the receiver gets copies of, over a socket that keeps messages apart.
/// @returns  false if nobody is at the other end
bool send_message(int socket, std::span<const std::byte> bytes, std::span<const int> files = {});

/// Waits for such a message.
/// @param bytes  filled from the beginning; what does not fit is lost
/// @param files  of the message, in order; descriptors that did not arrive stay as they are
/// @returns      how many bytes came; 0: the other end is closed
std::size_t receive_message(int socket, std::span<std::byte> bytes, std::span<UniqueFd> files = {});

/// Size of the message with which the server asks a program whether it is alive. A socket comes with it.
inline constexpr std::size_t kProbeSize = 1;

/// Sends such a message without waiting.
/// @returns  our end of the socket, at which one byte is the answer; none if the message could not be sent now
UniqueFd send_probe(int socket);

/// Answers such a message, whose socket that is.
void answer_probe(const UniqueFd& answer);

/// Whether a probe was answered, once there is news at our end.
bool is_answered(const UniqueFd& answer);

/// Sends texts one after the other over a stream.
/// @returns  false if nobody takes them
bool send_texts(int socket, std::initializer_list<std::string_view> texts);

/// Waits until all of it has come over a stream.
/// @returns  false if the stream ends before
bool receive_all(int socket, std::span<char> bytes);

/// Time that `poll` may wait.
/// @param time  none: for ever
int milliseconds_until(std::optional<std::chrono::steady_clock::time_point> time);

/// The bytes of a value as others of this program may read them.
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
