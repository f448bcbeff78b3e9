// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/live/page_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <libwebsockets.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"

namespace haptable {

namespace {

constexpr const char* kHere = "127.0.0.1";
constexpr std::size_t kPiece_bytes = 65536;          // of a page at once
constexpr std::size_t kMostWaiting_bytes = 1 << 20;  // some seconds of ticks
constexpr std::size_t kLongestText = 4096;           // of a page's word; a goal has a hundred
constexpr unsigned kMostConnections = 64;            // browsers, and who says nothing; further ones wait
constexpr unsigned kOwnDescriptors = 8;              // of the library: it listens, and wakes itself
constexpr unsigned kPatience_s = 5;                  // with a connection that asks for nothing
constexpr int kRounds = 3, kRoundsOfDownload = 32;   // of the library's service

std::string random_token() {
    std::array<unsigned char, 16> bytes{};
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw Error("no random numbers for a token: " + std::string(std::strerror(errno)));
    std::string token;
    for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
    return token;
}

/// Equal in a time that does not tell how much of it is.
bool is_same(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) return false;
    unsigned different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different |= static_cast<unsigned char>(a[i] ^ b[i]);
    return different == 0;
}

/// The library says nothing of why it cannot listen.
void require_free(int port) {
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int yes = 1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, kHere, &at.sin_addr);
    const bool failed = bind(fd, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0;
    const int why = errno;
    ::close(fd);
    if (!failed) return;
    if (why == EADDRINUSE)
        throw Error(fmt::format("--port {}: is in use: give another one, or leave it out for any that is free", port));
    throw Error(fmt::format("--port {}: cannot be listened on: {}", port, std::strerror(why)));
}

std::string header(lws* socket, lws_token_indexes token) {
    std::array<char, 256> text{};
    const int size = lws_hdr_copy(socket, text.data(), static_cast<int>(text.size()), token);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
}

}  // namespace

struct PageServer::Callback {
    static int call(lws* socket, lws_callback_reasons reason, void*, void* in, std::size_t size) {
        auto* server = static_cast<PageServer*>(lws_context_user(lws_get_context(socket)));
        return server->on_event(socket, reason, in, size);
    }
    static constexpr std::array<lws_protocols, 2> kProtocols{
        {{"haptable", call, 0, kLongestText, 0, nullptr, 0}, {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};
};

void PageServer::End::operator()(lws_context* context) const { lws_context_destroy(context); }

PageServer::PageServer(int port, Events events) : events_(std::move(events)), port_(port), token_(random_token()) {
    require_free(port);
    lws_set_log_level(0, nullptr);
    lws_context_creation_info info{};
    info.port = port;
    info.iface = kHere;
    info.protocols = Callback::kProtocols.data();
    info.gid = static_cast<gid_t>(-1);
    info.uid = static_cast<uid_t>(-1);
    info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_DISABLE_IPV6;
    info.user = this;
    // What connects takes no descriptor that the session needs: beyond its own the library aborts.
    info.fd_limit_per_thread = kMostConnections + kOwnDescriptors;
    info.timeout_secs = kPatience_s;
    context_.reset(lws_create_context(&info));
    if (!context_) throw Error(fmt::format("--port {}: no page can be served there", port));
    port_ = lws_get_vhost_listen_port(lws_get_vhost_by_name(context_.get(), "default"));
}

PageServer::~PageServer() {
    events_ = {};
    context_.reset();
}

std::string PageServer::url() const { return fmt::format("http://{}:{}/{}/", kHere, port_, token_); }
std::string PageServer::socket_url() const { return fmt::format("ws://{}:{}", kHere, port_); }

void PageServer::serve() {
    for (int i = 0; i < (downloads_.empty() ? kRounds : kRoundsOfDownload); ++i) lws_service(context_.get(), -1);
}

bool PageServer::send(int client, std::string_view bytes, bool is_binary) {
    for (auto& [socket, to] : clients_) {
        if (to.id != client) continue;
        if (to.waiting_bytes + bytes.size() > kMostWaiting_bytes) return false;
        to.waiting_bytes += bytes.size();
        to.out.push_back({std::string(bytes), is_binary});
        lws_callback_on_writable(socket);
        return true;
    }
    return false;
}

/// A path with the token, asked for under our own name: another name that leads here is another site's.
bool PageServer::is_ours(lws* socket, std::string_view path) const {
    return is_same(path.substr(0, std::min(path.size(), token_.size() + 1)), "/" + token_) &&
           header(socket, WSI_TOKEN_HOST) == fmt::format("{}:{}", kHere, port_);
}

int PageServer::begin_page(lws* socket, std::string_view path) {
    const std::string_view rest = path.substr(std::min(path.size(), token_.size() + 1));
    if (!is_ours(socket, path) || (rest != "/" && !rest.empty()) ||
        lws_hdr_total_length(socket, WSI_TOKEN_GET_URI) == 0)
        return lws_return_http_status(socket, HTTP_STATUS_FORBIDDEN,
                                      "This is not the whole address: open the one that haptable-view printed. It has "
                                      "another token each time that it is started.") < 0 ||
                       lws_http_transaction_completed(socket) != 0
                   ? -1
                   : 0;
    std::array<unsigned char, LWS_PRE + 1024> room{};
    unsigned char *begin = room.data() + LWS_PRE, *at = begin, *end = room.data() + room.size() - 1;
    const auto add = [&](const char* name, std::string_view value) {
        return lws_add_http_header_by_name(socket, reinterpret_cast<const unsigned char*>(name),
                                           reinterpret_cast<const unsigned char*>(value.data()),
                                           static_cast<int>(value.size()), &at, end);
    };
    if (lws_add_http_common_headers(socket, HTTP_STATUS_OK, "text/html; charset=utf-8", page_.size(), &at, end) != 0 ||
        add("cache-control:", "no-store") != 0 || add("referrer-policy:", "no-referrer") != 0 ||
        add("x-content-type-options:", "nosniff") != 0 || add("x-frame-options:", "DENY") != 0 ||
        lws_finalize_write_http_header(socket, begin, &at, end) != 0)
        return -1;
    downloads_[socket] = 0;
    ++pages_;
    lws_callback_on_writable(socket);
    return 0;
}

int PageServer::send_page(lws* socket) {
    const auto download = downloads_.find(socket);
    if (download == downloads_.end()) return 0;
    std::size_t& sent = download->second;
    const std::size_t now = std::min(kPiece_bytes, page_.size() - sent);
    const bool is_last = sent + now == page_.size();
    std::string room(LWS_PRE, '\0');
    room.append(page_, sent, now);
    auto* bytes = reinterpret_cast<unsigned char*>(room.data()) + LWS_PRE;
    if (lws_write(socket, bytes, now, is_last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0) return -1;
    sent += now;
    if (!is_last) return lws_callback_on_writable(socket) < 0 ? -1 : 0;
    downloads_.erase(download);
    return lws_http_transaction_completed(socket) != 0 ? -1 : 0;
}

void PageServer::open(lws* socket) {
    const int id = next_id_++;
    clients_.emplace(socket, Client{id, {}, 0, {}, false});
    if (events_.on_open) events_.on_open(id);
}

void PageServer::close(lws* socket) {
    const auto client = clients_.find(socket);
    if (client == clients_.end()) return;
    const int id = client->second.id;
    clients_.erase(client);
    if (events_.on_close) events_.on_close(id);
}

void PageServer::receive(lws* socket, std::string_view bytes) {
    Client& from = clients_.at(socket);
    from.is_too_long = from.is_too_long || from.in.size() + bytes.size() > kLongestText;
    if (!from.is_too_long) from.in.append(bytes);
    if (lws_remaining_packet_payload(socket) != 0 || lws_is_final_fragment(socket) == 0) return;
    const std::string text = std::exchange(from.in, {});
    if (!std::exchange(from.is_too_long, false) && events_.on_text) events_.on_text(from.id, text);
}

int PageServer::write(lws* socket) {
    Client& to = clients_.at(socket);
    if (to.out.empty()) return 0;
    const Message message = std::move(to.out.front());
    to.out.pop_front();
    to.waiting_bytes -= message.bytes.size();
    std::string room(LWS_PRE, '\0');
    room += message.bytes;
    auto* bytes = reinterpret_cast<unsigned char*>(room.data()) + LWS_PRE;
    if (lws_write(socket, bytes, message.bytes.size(), message.is_binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT) < 0)
        return -1;
    if (!to.out.empty()) lws_callback_on_writable(socket);
    return 0;
}

int PageServer::on_event(lws* socket, int reason, void* in, std::size_t size) {
    const std::string_view bytes(static_cast<const char*>(in), in != nullptr ? size : 0);
    switch (reason) {
        case LWS_CALLBACK_HTTP:
            return begin_page(socket, bytes);
        case LWS_CALLBACK_HTTP_WRITEABLE:
            return send_page(socket);
        case LWS_CALLBACK_CLOSED_HTTP:
            downloads_.erase(socket);
            return 0;
        case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
            return is_ours(socket, header(socket, WSI_TOKEN_GET_URI)) ? 0 : -1;
        case LWS_CALLBACK_ESTABLISHED:
            open(socket);
            return 0;
        case LWS_CALLBACK_CLOSED:
            close(socket);
            return 0;
        case LWS_CALLBACK_RECEIVE:
            receive(socket, bytes);
            return 0;
        case LWS_CALLBACK_SERVER_WRITEABLE:
            return write(socket);
        default:
            return 0;
    }
}

}  // namespace haptable
