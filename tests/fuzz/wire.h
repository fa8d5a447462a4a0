// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

/// A pair of sockets that preserves message boundaries, so that pieces arrive as they were sent.
class Wire {
public:
    Wire() { CCDT_CHECK(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends_.data()) == 0); }
    ~Wire() {
        close(ends_[0]);
        close(ends_[1]);
    }
    Wire(const Wire&) = delete;
    Wire& operator=(const Wire&) = delete;

    int server() const { return ends_[0]; }

    void send(std::string_view piece) {
        const auto sent = ::send(ends_[1], piece.data(), piece.size(), MSG_DONTWAIT);
        CCDT_CHECK(sent == static_cast<ssize_t>(piece.size()));
    }
    void hang_up() { shutdown(ends_[1], SHUT_WR); }

    /// Receives the pieces that the server has sent.
    std::vector<std::string> receive() {
        std::vector<std::string> pieces;
        std::array<char, 32'768> buffer;
        while (true) {
            const auto size = recv(ends_[1], buffer.data(), buffer.size(), MSG_DONTWAIT);
            if (size <= 0) return pieces;
            pieces.emplace_back(buffer.data(), static_cast<std::size_t>(size));
        }
    }

private:
    std::array<int, 2> ends_{};
};

}  // namespace ccdt::fuzz
