// SPDX-License-Identifier: GPL-2.0-or-later
// Haply's Inverse3 by its service (3.x): JSON over WebSocket. The service greets with what is plugged in; then each
// message of ours, which sets a force, is answered by one state. Metres, newtons; x, y, z of the device's plaque.
#include <libwebsockets.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/json.hpp"
#include "host/base/text.hpp"
#include "host/device/drivers.hpp"
#include "host/device/exchange_driver.hpp"

namespace haptable {

namespace {

using Json = nlohmann::json;

constexpr std::size_t kLongest = 1 << 20;  // bytes of a message; an inventory has some thousand

/// "ws://HOST:PORT/PATH"
struct Address {
    std::string host, path = "/";
    int port = 80;
};

Address address_of(const std::string& url) {
    constexpr std::string_view kScheme = "ws://";
    Address address;
    if (!url.starts_with(kScheme)) throw BadCommandLine("--url: " + url + " is not ws://HOST:PORT");
    address.host = url.substr(kScheme.size());
    if (const auto slash = address.host.find('/'); slash != std::string::npos) {
        address.path = address.host.substr(slash);
        address.host.erase(slash);
    }
    if (const auto colon = address.host.rfind(':'); colon != std::string::npos) {
        if (!read_number(address.host.substr(colon + 1), address.port))
            throw BadCommandLine("--url: " + url + " has no port number");
        address.host.erase(colon);
    }
    return address;
}

/// One client's side of a WebSocket: texts out and in, without waiting.
class WebSocket {
public:
    explicit WebSocket(const std::string& url) : address_(address_of(url)) {
        lws_set_log_level(0, nullptr);
        lws_context_creation_info info{};
        info.port = CONTEXT_PORT_NO_LISTEN;
        info.protocols = kProtocols.data();
        info.gid = static_cast<gid_t>(-1);
        info.uid = static_cast<uid_t>(-1);
        info.user = this;
        context_.reset(lws_create_context(&info));
        if (!context_) throw Error(url + ": no WebSocket could be made");
        lws_client_connect_info to{};
        to.context = context_.get();
        to.address = to.host = to.origin = address_.host.c_str();
        to.port = address_.port;
        to.path = address_.path.c_str();
        to.local_protocol_name = kProtocols[0].name;
        to.pwsi = &socket_;
        if (lws_client_connect_via_info(&to) == nullptr) closed_ = true;
    }

    bool is_open() const { return open_; }
    bool is_closed() const { return closed_; }
    /// Sends `text` as soon as the socket takes it; one that waits is overwritten.
    void send(const std::string& text) {
        to_send_ = text;
        if (open_ && !closed_) lws_callback_on_writable(socket_);
        serve();
    }
    /// The newest whole text that came since the last call.
    std::optional<std::string> take() {
        serve();
        return std::exchange(newest_, std::nullopt);
    }
    /// Texts that were too long.
    std::int64_t too_long() const { return too_long_; }

private:
    struct End {
        void operator()(lws_context* context) const { lws_context_destroy(context); }
    };

    void serve() {
        // Below 0: what there is, without waiting. What is read makes room to write.
        for (int i = 0; i < 3; ++i) lws_service(context_.get(), -1);
    }

    void receive(lws* socket, const char* text, std::size_t size) {
        if (held_.size() + size > kLongest) {
            ++too_long_;
            held_.clear();
            skip_ = true;
        }
        if (!skip_) held_.append(text, size);
        if (lws_remaining_packet_payload(socket) != 0 || lws_is_final_fragment(socket) == 0) return;
        if (!skip_) newest_ = std::move(held_);
        held_.clear();
        skip_ = false;
    }

    void write() {
        if (to_send_.empty()) return;
        std::string room(LWS_PRE, '\0');
        room += to_send_;
        auto* text = reinterpret_cast<unsigned char*>(room.data()) + LWS_PRE;
        if (lws_write(socket_, text, to_send_.size(), LWS_WRITE_TEXT) < 0) closed_ = true;
        to_send_.clear();
    }

    static int on_event(lws* socket, lws_callback_reasons reason, void*, void* in, std::size_t size) {
        auto* self = static_cast<WebSocket*>(lws_context_user(lws_get_context(socket)));
        if (reason == LWS_CALLBACK_CLIENT_ESTABLISHED) self->open_ = true;
        if (reason == LWS_CALLBACK_CLIENT_RECEIVE) self->receive(socket, static_cast<const char*>(in), size);
        if (reason == LWS_CALLBACK_CLIENT_WRITEABLE) self->write();
        if (reason == LWS_CALLBACK_CLIENT_CONNECTION_ERROR || reason == LWS_CALLBACK_CLIENT_CLOSED)
            self->closed_ = true;
        return 0;
    }

    static constexpr std::array<lws_protocols, 2> kProtocols{
        {{"haptable", on_event, 0, 65536, 0, nullptr, 0}, {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};

    Address address_;
    std::unique_ptr<lws_context, End> context_;
    lws* socket_ = nullptr;
    std::string to_send_, held_;
    std::optional<std::string> newest_;
    bool open_ = false, closed_ = false, skip_ = false;
    std::int64_t too_long_ = 0;
};

/// The first device of a kind: null where there is none.
const Json& first_of(const Json& message, const char* kind) {
    static const Json none;
    const auto list = message.find(kind);
    return list != message.end() && list->is_array() && !list->empty() ? list->front() : none;
}

/// What `keys` lead to; null where they do not.
const Json& at(const Json& message, std::initializer_list<const char*> keys) {
    static const Json none;
    const Json* here = &message;
    for (const char* key : keys) {
        if (!here->is_object() || !here->contains(key)) return none;
        here = &(*here)[key];
    }
    return *here;
}

bool read_vector(const Json& from, Eigen::Vector3d& into) {
    Eigen::Index i = 0;
    for (const char* axis : {"x", "y", "z"}) {
        const Json& value = at(from, {axis});
        if (!value.is_number()) return false;
        into[i++] = value.get<double>();
    }
    return into.allFinite();
}

class Inverse3Driver : public ExchangeDriver {
public:
    explicit Inverse3Driver(const DriverOptions& options) : ExchangeDriver(options.url, options), socket_(options.url) {
        wait_for_first(options.patience_s, "does Haply's service run, with an Inverse3 plugged in?");
    }
    ~Inverse3Driver() override { send_no_force(); }

private:
    void send(const Eigen::Vector3d& force_n) override {
        if (socket_.is_closed())
            throw Error(name() + ": the service has closed the connection, or does not listen: start it again");
        if (device_.empty()) return;  // the greeting names it
        Json command;
        command["device_id"] = device_;
        Json& values = command["commands"]["set_cursor_force"]["values"];
        values["x"] = force_n.x();
        values["y"] = force_n.y();
        values["z"] = force_n.z();
        Json message;
        message["inverse3"] = Json::array({command});
        socket_.send(json_text(message));
    }

    bool take(Reading& reading) override {
        const std::optional<std::string> text = socket_.take();
        if (socket_.is_closed())
            throw Error(name() + ": the service has closed the connection, or does not listen: start it again");
        if (!text) return false;
        const Json message = Json::parse(*text, nullptr, false);
        const Json& device = message.is_object() ? first_of(message, "inverse3") : message;
        const Json& id = at(device, {"device_id"});
        const bool is_ours = id.is_string() && (device_.empty() || id == device_);
        // A greeting need not have a state: the first force asks for one.
        if (is_ours && device_.empty()) {
            device_ = id.get<std::string>();
            if (at(device, {"state"}).is_null()) return false;
        }
        if (!is_ours || !read_vector(at(device, {"state", "cursor_position"}), reading.position_m)) {
            count_odd();
            return false;
        }
        if (!read_vector(at(device, {"state", "cursor_velocity"}), reading.velocity_m_s))
            reading.velocity_m_s.setZero();
        reading.buttons = buttons_of(message);
        return true;
    }

    /// Buttons of a grip: a, b and c, where there is one.
    static std::int32_t buttons_of(const Json& message) {
        std::int32_t buttons = 0;
        for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
            const Json& pressed = at(first_of(message, kind), {"state", "buttons"});
            if (at(pressed, {"a"}) == true) buttons |= kClutchButton;
            if (at(pressed, {"b"}) == true) buttons |= kGrabButton;
            if (at(pressed, {"c"}) == true) buttons |= kAcknowledgeButton;
        }
        return buttons;
    }

    WebSocket socket_;
    std::string device_;  ///< empty until the service has named one
};

}  // namespace

std::unique_ptr<Driver> open_inverse3(const DriverOptions& options) {
    return std::make_unique<Inverse3Driver>(options);
}

}  // namespace haptable
