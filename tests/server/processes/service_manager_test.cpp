// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/service_manager.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

/// Sets NOTIFY_SOCKET during a test.
class NotifySocket {
public:
    explicit NotifySocket(const std::string& name) { setenv("NOTIFY_SOCKET", name.c_str(), 1); }
    ~NotifySocket() { unsetenv("NOTIFY_SOCKET"); }
    NotifySocket(const NotifySocket&) = delete;
    NotifySocket& operator=(const NotifySocket&) = delete;
};

TEST(ServiceManager, ReceivesTheStateAtAnAbstractSocket) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "@ccdt-notify-" + std::to_string(getpid());
    std::memcpy(address.sun_path + 1, name.data() + 1, name.size() - 1);
    const UniqueFd receiver(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    ASSERT_EQ(bind(receiver.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    const NotifySocket variable(name);
    ASSERT_TRUE(notify_service_manager("READY=1\nSTATUS=a test"));
    std::array<char, 100> text{};
    ASSERT_GT(recv(receiver.get(), text.data(), text.size() - 1, MSG_DONTWAIT), 0);
    EXPECT_STREQ(text.data(), "READY=1\nSTATUS=a test");
}

TEST(ServiceManager, DoesNothingWithoutASocket) {
    EXPECT_TRUE(notify_service_manager("READY=1"));
    const NotifySocket variable("");
    EXPECT_TRUE(notify_service_manager("READY=1"));
}

TEST(ServiceManager, ReportsSocketsThatDoNotReceive) {
    {
        const NotifySocket variable("/no/such/socket");
        EXPECT_EQ(notify_service_manager("READY=1").error().message,
                  "NOTIFY_SOCKET: cannot send to '/no/such/socket': No such file or directory");
    }
    const NotifySocket variable(std::string(sizeof(sockaddr_un::sun_path), 'x'));
    EXPECT_NE(notify_service_manager("READY=1").error().message.find("File name too long"), std::string::npos);
}

}  // namespace
}  // namespace ccdt::server
