// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/messages.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include <sys/socket.h>

namespace ccdt::server {
namespace {

constexpr std::size_t kMaxFiles = 4;

/// Maximum size of a text, in bytes, that send_texts() joins with adjacent texts and sends in one call.
constexpr std::size_t kShortText = 16'384;

/// A message for sendmsg() or recvmsg(), with space for descriptors.
struct Envelope {
    Envelope(void* bytes, std::size_t size) : body{bytes, size} {
        message.msg_iov = &body;
        message.msg_iovlen = 1;
    }

    void set_file_count(std::size_t count) {
        assert(count <= kMaxFiles);
        message.msg_control = count > 0 ? files.data() : nullptr;
        message.msg_controllen = count > 0 ? CMSG_SPACE(count * sizeof(int)) : 0;
    }

    iovec body;
    alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(kMaxFiles * sizeof(int))> files{};
    msghdr message{};
};

bool send_text(int socket, std::string_view text) {
    while (!text.empty()) {
        const ssize_t sent = ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR) return false;
        text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(sent, 0)));
    }
    return true;
}

}  // namespace

std::optional<SocketPair> make_sockets(int type) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends.data()) != 0) return std::nullopt;
    return SocketPair{UniqueFd(ends[0]), UniqueFd(ends[1])};
}

namespace {

bool send_with(int flags, int socket, std::span<const std::byte> bytes, std::span<const int> files) {
    // sendmsg() takes a pointer to non-const, but does not write to the bytes.
    Envelope envelope(const_cast<std::byte*>(bytes.data()), bytes.size());
    envelope.set_file_count(files.size());
    if (!files.empty()) {
        cmsghdr* const header = CMSG_FIRSTHDR(&envelope.message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(files.size_bytes());
        std::memcpy(CMSG_DATA(header), files.data(), files.size_bytes());
    }
    ssize_t sent = 0;
    do sent = ::sendmsg(socket, &envelope.message, MSG_NOSIGNAL | flags);
    while (sent < 0 && errno == EINTR);
    return sent == static_cast<ssize_t>(bytes.size());
}

}  // namespace

bool send_message(int socket, std::span<const std::byte> bytes, std::span<const int> files) {
    return send_with(0, socket, bytes, files);
}

UniqueFd send_probe(int socket) {
    auto answer = make_sockets(SOCK_SEQPACKET);
    const std::array<std::byte, kProbeSize> probe{};
    if (!answer) return {};
    const std::array files = {answer->theirs.get()};
    return send_with(MSG_DONTWAIT, socket, probe, files) ? std::move(answer->ours) : UniqueFd();
}

void answer_probe(const UniqueFd& answer) {
    const std::array<std::byte, kProbeSize> alive{};
    static_cast<void>(send_with(MSG_DONTWAIT, answer.get(), alive, {}));
}

bool is_answered(const UniqueFd& answer) {
    std::byte alive{};
    return recv(answer.get(), &alive, sizeof(alive), MSG_DONTWAIT) == sizeof(alive);
}

std::size_t receive_message(int socket, std::span<std::byte> bytes, std::span<UniqueFd> files) {
    Envelope envelope(bytes.data(), bytes.size());
    envelope.set_file_count(files.size());
    ssize_t received = 0;
    do received = ::recvmsg(socket, &envelope.message, MSG_CMSG_CLOEXEC);
    while (received < 0 && errno == EINTR);
    if (received <= 0) return 0;
    const cmsghdr* const header = CMSG_FIRSTHDR(&envelope.message);
    if (header != nullptr && header->cmsg_type == SCM_RIGHTS) {
        std::array<int, kMaxFiles> numbers{};
        const std::size_t count = std::min((header->cmsg_len - CMSG_LEN(0)) / sizeof(int), files.size());
        std::memcpy(numbers.data(), CMSG_DATA(header), count * sizeof(int));
        for (std::size_t i = 0; i < count; ++i) files[i] = UniqueFd(numbers[i]);
    }
    return static_cast<std::size_t>(received);
}

bool send_texts(int socket, std::initializer_list<std::string_view> texts) {
    std::string together;
    for (const auto text : texts) {
        if (text.size() <= kShortText) {
            together += text;
            continue;
        }
        if (!send_text(socket, together) || !send_text(socket, text)) return false;
        together.clear();
    }
    return send_text(socket, together);
}

bool receive_all(int socket, std::span<char> bytes) {
    while (!bytes.empty()) {
        const ssize_t received = ::recv(socket, bytes.data(), bytes.size(), 0);
        if (received == 0 || (received < 0 && errno != EINTR)) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(std::max<ssize_t>(received, 0)));
    }
    return true;
}

int milliseconds_until(std::optional<std::chrono::steady_clock::time_point> time) {
    if (!time) return -1;
    const auto remaining =
        std::chrono::ceil<std::chrono::milliseconds>(*time - std::chrono::steady_clock::now()).count();
    return static_cast<int>(std::clamp<std::int64_t>(remaining, 0, 1'000'000'000));
}

}  // namespace ccdt::server
