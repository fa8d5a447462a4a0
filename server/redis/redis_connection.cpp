// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_connection.h"

#include <hiredis/hiredis.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace ccdt::server {
namespace {

constexpr std::size_t kReadAtOnce = 65'536;

struct FreeAddresses {
    void operator()(addrinfo* list) const { freeaddrinfo(list); }
};

RedisReply reply_of(const redisReply& from) {
    RedisReply reply;
    switch (from.type) {
        case REDIS_REPLY_STATUS:
        case REDIS_REPLY_STRING:
            reply.kind = RedisReply::Kind::Text;
            reply.text.assign(from.str, from.len);
            break;
        case REDIS_REPLY_ERROR:
            reply.kind = RedisReply::Kind::Error;
            reply.text.assign(from.str, from.len);
            break;
        case REDIS_REPLY_INTEGER:
            reply.kind = RedisReply::Kind::Number;
            reply.number = from.integer;
            break;
        case REDIS_REPLY_ARRAY:
            reply.kind = RedisReply::Kind::List;
            for (std::size_t i = 0; i < from.elements; ++i) reply.items.push_back(reply_of(*from.element[i]));
            break;
        default:
            break;
    }
    return reply;
}

}  // namespace

/// Encrypts and decrypts with TLS in memory. RedisConnection sends and receives the bytes.
class RedisConnection::Tls {
public:
    explicit Tls(const std::string& host) : tls_(SSL_new(context()), SSL_free) {
        if (!tls_) throw std::bad_alloc();
        SSL_set_bio(tls_.get(), BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
        SSL_set_tlsext_host_name(tls_.get(), host.c_str());
        SSL_set1_host(tls_.get(), host.c_str());
        SSL_set_connect_state(tls_.get());
    }

    bool is_ready() const { return SSL_is_init_finished(tls_.get()) != 0; }

    /// Continues the handshake; returns false after a failure.
    bool shake_hands() { return is_fine(SSL_do_handshake(tls_.get())); }

    void take_received(std::string_view bytes) {
        BIO_write(SSL_get_rbio(tls_.get()), bytes.data(), static_cast<int>(bytes.size()));
    }

    /// Encrypts bytes to be sent; returns false after a failure.
    bool encrypt(std::string_view bytes) {
        return bytes.empty() || SSL_write(tls_.get(), bytes.data(), static_cast<int>(bytes.size())) > 0;
    }

    /// Removes and returns the encrypted bytes to be sent.
    std::string take_to_send() {
        std::string bytes(BIO_ctrl_pending(SSL_get_wbio(tls_.get())), '\0');
        if (!bytes.empty()) BIO_read(SSL_get_wbio(tls_.get()), bytes.data(), static_cast<int>(bytes.size()));
        return bytes;
    }

    /// Decrypts the received bytes, and appends them to `bytes`.
    /// @returns  false after a failure, or if the other end closed the connection
    bool decrypt(std::string& bytes) {
        char part[16'384];
        int count = 0;
        while ((count = SSL_read(tls_.get(), part, sizeof(part))) > 0)
            bytes.append(part, static_cast<std::size_t>(count));
        return is_fine(count);
    }

    std::string why() const {
        const long verified = SSL_get_verify_result(tls_.get());
        if (verified != X509_V_OK) return std::string("its certificate: ") + X509_verify_cert_error_string(verified);
        const char* reason = ERR_reason_error_string(ERR_peek_last_error());
        return std::string("TLS: ") + (reason != nullptr ? reason : "the connection was closed");
    }

private:
    /// Returns the TLS settings. They trust the certificate authorities of the system, or of SSL_CERT_FILE.
    static SSL_CTX* context() {
        static const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> kContext = [] {
            std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> made(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
            if (!made) throw std::bad_alloc();
            SSL_CTX_set_min_proto_version(made.get(), TLS1_2_VERSION);
            SSL_CTX_set_default_verify_paths(made.get());
            SSL_CTX_set_verify(made.get(), SSL_VERIFY_PEER, nullptr);
            return made;
        }();
        return kContext.get();
    }

    bool is_fine(int result) const { return result > 0 || SSL_get_error(tls_.get(), result) == SSL_ERROR_WANT_READ; }

    std::unique_ptr<SSL, decltype(&SSL_free)> tls_;
};

RedisConnection::RedisConnection(const RedisAddress& address)
    : address_(address), reader_(redisReaderCreate(), redisReaderFree) {
    if (!reader_) throw std::bad_alloc();
}

RedisConnection::~RedisConnection() = default;

Result<std::unique_ptr<RedisConnection>> RedisConnection::open(const RedisAddress& address,
                                                               Clock::time_point deadline) {
    std::unique_ptr<RedisConnection> connection(new RedisConnection(address));
    return connection->connect(deadline)
        .and_then([&] { return address.encrypted ? connection->encrypt(deadline) : Result<void>(); })
        .and_then([&] { return connection->introduce(deadline); })
        .map([&] { return std::move(connection); });
}

tl::unexpected<Error> RedisConnection::away(const std::string& why) const {
    return failure(ErrorCode::Stopped, "Redis at " + address_.name() + ": " + why);
}

/// Waits for an event on the socket; returns false if none has occurred by `until`.
bool RedisConnection::wait(short events, Clock::time_point until) const {
    pollfd waited{socket_.get(), events, 0};
    const auto remaining = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    return poll(&waited, 1, static_cast<int>(std::max<std::int64_t>(remaining, 0))) > 0;
}

Result<void> RedisConnection::connect(Clock::time_point deadline) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int code = getaddrinfo(address_.host.c_str(), address_.port.c_str(), &hints, &found); code != 0)
        return away(gai_strerror(code));
    const std::unique_ptr<addrinfo, FreeAddresses> list(found);
    int error = 0;
    for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
        socket_ = UniqueFd(::socket(each->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
        error = ::connect(socket_.get(), each->ai_addr, each->ai_addrlen) == 0 ? 0 : errno;
        if (error == EINPROGRESS) {
            socklen_t size = sizeof(error);
            if (!wait(POLLOUT, deadline))
                error = ETIMEDOUT;
            else
                getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
        }
        if (error != 0) continue;
        const int on = 1;
        setsockopt(socket_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
        return {};
    }
    return away(std::strerror(error));
}

Result<void> RedisConnection::encrypt(Clock::time_point deadline) {
    ERR_clear_error();
    tls_ = std::make_unique<Tls>(address_.host);
    while (true) {
        const bool fine = tls_->shake_hands();
        const std::string why = fine ? "" : tls_->why();
        if (auto sent = send_bytes("", deadline); !sent) return sent;
        if (!fine) return away(why);
        if (tls_->is_ready()) return {};
        if (!wait(POLLIN, deadline)) return away("it did not reply in time");
        char part[kReadAtOnce];
        const ssize_t count = recv(socket_.get(), part, sizeof(part), 0);
        if (count <= 0) return away("TLS: the connection was closed");
        tls_->take_received({part, static_cast<std::size_t>(count)});
    }
}

/// Authenticates and selects the database.
Result<void> RedisConnection::introduce(Clock::time_point deadline) {
    std::vector<RedisCommand> commands;
    if (!address_.password.empty() && address_.user.empty()) commands.push_back({"AUTH", address_.password});
    if (!address_.user.empty()) commands.push_back({"AUTH", address_.user, address_.password});
    const std::string database = std::to_string(address_.database);
    commands.push_back({"SELECT", database});
    const auto replies = run(commands, deadline);
    if (!replies) return tl::unexpected(replies.error());
    const auto refused = std::ranges::find(*replies, RedisReply::Kind::Error, &RedisReply::kind);
    return refused == replies->end() ? Result<void>() : away(refused->text);
}

Result<void> RedisConnection::send_bytes(std::string_view bytes, Clock::time_point deadline) {
    std::string encrypted;
    if (tls_) {
        if (!tls_->encrypt(bytes)) return away(tls_->why());
        encrypted = tls_->take_to_send();
        bytes = encrypted;
    }
    while (!bytes.empty()) {
        const ssize_t sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
        if (sent > 0 || errno == EINTR) continue;
        if (errno != EAGAIN) return away(std::strerror(errno));
        if (!wait(POLLOUT, deadline)) return away("it did not reply in time");
    }
    return {};
}

/// Receives and decrypts bytes; returns an empty text if none have arrived by `until`.
Result<std::string_view> RedisConnection::receive_bytes(Clock::time_point until) {
    if (!wait(POLLIN, until)) return std::string_view();
    received_.resize(kReadAtOnce);
    const ssize_t count = recv(socket_.get(), received_.data(), received_.size(), 0);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return std::string_view();
    if (count < 0) return away(std::strerror(errno));
    if (count == 0) return away("the connection was closed");
    received_.resize(static_cast<std::size_t>(count));
    if (!tls_) return received_;
    tls_->take_received(received_);
    received_.clear();
    if (!tls_->decrypt(received_)) return away(tls_->why());
    return received_;
}

Result<void> RedisConnection::send(const RedisCommand& command, Clock::time_point deadline) {
    std::vector<const char*> arguments;
    std::vector<std::size_t> sizes;
    for (const std::string_view argument : command) {
        arguments.push_back(argument.data());
        sizes.push_back(argument.size());
    }
    char* text = nullptr;
    const int size = redisFormatCommandArgv(&text, static_cast<int>(command.size()), arguments.data(), sizes.data());
    if (size < 0) throw std::bad_alloc();
    const std::unique_ptr<char, void (*)(char*)> owner(text, redisFreeCommand);
    return send_bytes({text, static_cast<std::size_t>(size)}, deadline);
}

/// Parses the next reply from the received bytes.
/// @returns  none if no reply is complete
Result<std::optional<RedisReply>> RedisConnection::take_reply() {
    void* found = nullptr;
    if (redisReaderGetReply(reader_.get(), &found) != REDIS_OK)
        return failure(ErrorCode::Internal,
                       "Redis at " + address_.name() + " sent a malformed reply: " + std::string(reader_->errstr));
    if (found == nullptr) return std::nullopt;
    const std::unique_ptr<void, void (*)(void*)> owner(found, freeReplyObject);
    return reply_of(*static_cast<redisReply*>(found));
}

Result<std::optional<RedisReply>> RedisConnection::receive(Clock::time_point until) {
    while (true) {
        auto reply = take_reply();
        if (!reply || *reply) return reply;
        if (Clock::now() >= until) return std::nullopt;
        const auto bytes = receive_bytes(until);
        if (!bytes) return tl::unexpected(bytes.error());
        redisReaderFeed(reader_.get(), bytes->data(), bytes->size());
    }
}

Result<std::vector<RedisReply>> RedisConnection::run(std::span<const RedisCommand> commands,
                                                     Clock::time_point deadline) {
    for (const RedisCommand& command : commands)
        if (auto sent = send(command, deadline); !sent) return tl::unexpected(sent.error());
    std::vector<RedisReply> replies;
    for (std::size_t i = 0; i < commands.size(); ++i) {
        auto reply = receive(deadline);
        if (!reply) return tl::unexpected(reply.error());
        if (!*reply) return away("it did not reply in time");
        replies.push_back(**std::move(reply));
    }
    return replies;
}

}  // namespace ccdt::server
