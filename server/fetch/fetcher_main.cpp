// SPDX-License-Identifier: GPL-3.0-or-later
#include <curl/curl.h>
#include <fcntl.h>
#include <sys/prctl.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "server/decoder/decoder_confinement.h"
#include "server/decoder/decoder_sandbox.h"
#include "server/fetch/fetch_protocol.h"
#include "server/http/authorities.h"
#include "server/processes/child_program.h"
#include "server/processes/messages.h"
#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;
constexpr long kOk = 200;

/// Limits of the process, apart from the body, which is passed on in pieces.
constexpr DecoderLimits kLimits{std::size_t{64} << 20, std::chrono::seconds(10)};

/// Data of the callbacks of the transfer.
struct Context {
    UniqueFd server;
    UniqueFd connection;  ///< empty once the transfer has it
    CURL* transfer = nullptr;
    std::uint64_t remaining = 0;  ///< number of bytes that the body may still have
    bool begun = false;

    bool send(FetchNews news, std::string_view text) const {
        std::string message(1, static_cast<char>(news));
        message += text.substr(0, kMaxFetchNews - 1);
        return send_message(server.get(), std::as_bytes(std::span(message)));
    }
};

curl_socket_t pass_connection(void* data, curlsocktype /*purpose*/, curl_sockaddr* /*address*/) {
    auto& connection = static_cast<Context*>(data)->connection;
    return connection ? connection.release() : CURL_SOCKET_BAD;
}

int confirm_connection(void* /*data*/, curl_socket_t /*socket*/, curlsocktype /*purpose*/) {
    return CURL_SOCKOPT_ALREADY_CONNECTED;
}

/// @returns  the number of bytes that were passed on; 0 ends the transfer
std::size_t pass_body(const char* bytes, std::size_t size, std::size_t count, void* data) {
    auto& context = *static_cast<Context*>(data);
    long status = 0;
    curl_easy_getinfo(context.transfer, CURLINFO_RESPONSE_CODE, &status);
    if (status != kOk) return size * count;
    if (size * count > context.remaining) return 0;
    context.remaining -= size * count;
    if (!std::exchange(context.begun, true)) {
        curl_off_t length = -1;
        curl_easy_getinfo(context.transfer, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
        if (!context.send(FetchNews::Size, length < 0 ? "" : std::to_string(length))) return 0;
    }
    return context.send(FetchNews::Piece, {bytes, size * count}) ? size * count : 0;
}

/// Reads the certificates of the authorities, before the process loses access to files.
std::string read_authorities() {
    std::ifstream file(authorities_file(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Gives up all rights except computing and the use of the two sockets. From now on, the process ends with the thread
/// of the server that has started it.
bool confine(const Sandbox& sandbox) {
    Confinement confinement;
    enter_namespaces(confinement);
    drop_privileges(confinement);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    return sandbox.enter(kLimits, 0);
}

/// Reports how the transfer has ended.
void report(const Context& context, CURLcode code) {
    long status = 0;
    const char* redirect = nullptr;
    curl_easy_getinfo(context.transfer, CURLINFO_RESPONSE_CODE, &status);
    curl_easy_getinfo(context.transfer, CURLINFO_REDIRECT_URL, &redirect);
    if (code == CURLE_WRITE_ERROR || code == CURLE_FILESIZE_EXCEEDED)
        context.send(FetchNews::TooLarge, {});
    else if (code != CURLE_OK)
        context.send(FetchNews::Failed, curl_easy_strerror(code));
    else if (redirect != nullptr)
        context.send(FetchNews::Redirect, redirect);
    else if (status != kOk || !context.begun)
        context.send(FetchNews::Failed,
                     status == kOk ? "the file is empty" : "the status of the answer is " + std::to_string(status));
    else
        context.send(FetchNews::Done, {});
}

int fetch(Context& context, const FetchOrder& order) {
    const Sandbox sandbox(Sandbox::Channels::Sockets);
    std::string authorities = read_authorities();
    if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) return kFailed;
    context.transfer = curl_easy_init();
    curl_slist* const any_name = curl_slist_append(nullptr, "::127.0.0.1:");  // the connection exists already
    if (context.transfer == nullptr || any_name == nullptr || !confine(sandbox)) return kFailed;
    curl_blob blob{authorities.data(), authorities.size(), CURL_BLOB_NOCOPY};
    const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(context.transfer, option, value); };
    set(CURLOPT_URL, order.url.data());
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_PROXY, "");
    set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
    set(CURLOPT_USERAGENT, "ccdt-server");
    set(CURLOPT_CONNECT_TO, any_name);
    set(CURLOPT_OPENSOCKETFUNCTION, pass_connection);
    set(CURLOPT_OPENSOCKETDATA, &context);
    set(CURLOPT_SOCKOPTFUNCTION, confirm_connection);
    set(CURLOPT_CAINFO_BLOB, &blob);
    set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));
    set(CURLOPT_TIMEOUT_MS, static_cast<long>(order.timeout_ms));
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(order.max_bytes));
    set(CURLOPT_WRITEFUNCTION, pass_body);
    set(CURLOPT_WRITEDATA, &context);
    report(context, curl_easy_perform(context.transfer));
    return 0;
}

}  // namespace
}  // namespace ccdt::server

/// The main function of ccdt-fetcher, which the server starts for each exchange with another host.
int main() {
    using namespace ccdt::server;
    Context context{UniqueFd(ChildProgram::kSocket), {}};
    if (fcntl(context.server.get(), F_GETFD) < 0) {
        std::fputs("ccdt-fetcher: ccdt-server starts this program\n", stderr);
        return kWrongUsage;
    }
    leave_signals_to_server();
    FetchOrder order;
    const std::span connection(&context.connection, 1);
    if (receive_message(context.server.get(), writable_bytes_of(order), connection) != sizeof(order)) return kFailed;
    context.remaining = order.max_bytes;
    return fetch(context, order);
}
