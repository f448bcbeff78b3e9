// SPDX-License-Identifier: GPL-2.0-or-later
// One page for browsers of this machine, and a WebSocket for each of them.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

struct lws;
struct lws_context;

namespace haptable {

/// Listens on 127.0.0.1 alone, and answers nothing but what has its token in the path: 128 random bits for each run. Of
/// connections it has 64 at most; others wait until one ends, which one that asks for nothing does after 5 s. For one
/// thread, which calls serve().
class PageServer {
public:
    /// A WebSocket, by a number that none after it gets.
    struct Events {
        std::function<void(int client)> on_open, on_close;
        std::function<void(int client, std::string_view text)> on_text;
    };

    /// port 0: any that is free. Throws Error where it is in use or may not be had.
    PageServer(int port, Events events);
    ~PageServer();
    PageServer(const PageServer&) = delete;
    PageServer& operator=(const PageServer&) = delete;

    std::string url() const;         ///< of the page
    std::string socket_url() const;  ///< of where its WebSockets are, without the token
    /// The page's text.
    void set_page(std::string html) { page_ = std::move(html); }

    /// Does what there is to do, without waiting.
    void serve();
    /// Sends a message when the client takes it. What a client that takes nothing lets wait is dropped: false then.
    bool send_text(int client, std::string_view text) { return send(client, text, false); }
    bool send_binary(int client, std::string_view bytes) { return send(client, bytes, true); }
    std::int64_t pages() const { return pages_; }  ///< sent so far

private:
    struct Message {
        std::string bytes;
        bool is_binary;
    };
    struct Client {
        int id;
        std::deque<Message> out;
        std::size_t waiting_bytes = 0;
        std::string in;
        bool is_too_long = false;
    };
    struct End {
        void operator()(lws_context* context) const;
    };

    bool send(int client, std::string_view bytes, bool is_binary);
    bool is_ours(lws* socket, std::string_view path) const;
    int begin_page(lws* socket, std::string_view path);
    int send_page(lws* socket);
    void open(lws* socket);
    void close(lws* socket);
    void receive(lws* socket, std::string_view bytes);
    int write(lws* socket);
    int on_event(lws* socket, int reason, void* in, std::size_t size);
    struct Callback;  ///< of libwebsockets

    Events events_;
    int port_;
    std::string token_, page_;
    std::map<lws*, Client> clients_;
    std::map<lws*, std::size_t> downloads_;  ///< bytes of the page that were sent
    int next_id_ = 1;
    std::int64_t pages_ = 0;
    std::unique_ptr<lws_context, End> context_;
};

}  // namespace haptable
