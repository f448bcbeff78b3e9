// SPDX-License-Identifier: GPL-2.0-or-later
// LCM -> ticks -> WebSocket -> page; page -> goal -> the pointer's device -> LCM
#include "host/page/live/live.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/json.hpp"
#include "host/link/connection.hpp"
#include "host/page/live/page_server.hpp"
#include "host/page/live/pointer.hpp"
#include "host/page/pointer_device.hpp"

namespace haptable {

namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kLook{4};    // how long LCM may keep us from the pages
constexpr std::chrono::milliseconds kPush{16};   // a picture
constexpr std::chrono::milliseconds kAway{500};  // after which a servo is not heard any more
constexpr double kMostGain = 1e6, kLeastStiffness = 1.0, kMostStiffness = 1e5;

/// Three finite numbers.
std::optional<Eigen::Vector3d> vector_of(const json& message, const char* key) {
    const auto list = message.find(key);
    if (list == message.end() || !list->is_array() || list->size() != 3) return std::nullopt;
    Eigen::Vector3d x;
    for (std::size_t a = 0; a < 3; ++a) {
        if (!(*list)[a].is_number()) return std::nullopt;
        x[static_cast<Eigen::Index>(a)] = (*list)[a].get<double>();
    }
    return x.allFinite() ? std::optional(x) : std::nullopt;
}

double number_of(const json& message, const char* key, double least, double most, double otherwise) {
    const auto value = message.find(key);
    if (value == message.end() || !value->is_number()) return otherwise;
    return std::clamp(value->get<double>(), least, most);
}

class LiveSession {
public:
    LiveSession(const TablesFolder& folder, const LiveOptions& options)
        : options_(options),
          scene_(folder),
          fingers_(scene_.pair() != nullptr ? HAPTABLE_FINGERS : 1),
          is_free_(scene_.body() != nullptr),
          modes_(scene_.modes() != nullptr ? scene_.modes()->count : 0),
          ticks_(scene_.tables(), scene_.servo(), scene_.model().hash, fingers_, is_free_, modes_),
          live_(options.tell),
          server_(options.port, events()) {
        server_.set_page(make_page(folder, page_parts(), options.most_bytes, server_.socket_url()).html);
        each_channel([this]<typename Message>(const char* channel, std::size_t finger) {
            if (finger >= fingers_) return;
            connection_.subscribe<Message>(
                channel, [this, finger](const Message& message, std::int64_t) { take(message, finger); });
        });
        for (std::size_t finger = 0; options.touch && finger < fingers_; ++finger)
            pointers_.emplace_back(pointer_device(scene_.tables(), folder), hash(), options.tell, finger);
    }

    LiveReport run() {
        if (options_.show) options_.show(server_.url());
        const Clock::time_point begin = Clock::now();
        const std::chrono::duration<double> length(options_.seconds);
        Clock::time_point next_push = begin;
        while (!interrupted() && (options_.seconds <= 0.0 || Clock::now() - begin < length)) {
            const Clock::time_point until = Clock::now() + kLook;
            while (Clock::now() < until && connection_.handle_until(until)) {
            }
            server_.serve();
            if (Clock::now() < next_push) continue;
            next_push = Clock::now() + kPush;
            push();
        }
        return report();
    }

private:
    std::int64_t hash() const { return static_cast<std::int64_t>(scene_.model().hash); }

    template <typename Message>
    void take(const Message& message, std::size_t finger) {
        ticks_.take(message, finger);
    }
    // A tool is drawn by haptable-view's pictures.
    void take(const hand_pose&, std::size_t) {}
    void take(const tool_wrench&, std::size_t) {}
    void take(const servo_status& status, std::size_t) {
        if (status.model_hash == hash()) servo_seen_ = Clock::now();
    }

    PageServer::Events events() {
        return {[this](int page) { open(page); }, [this](int page) { close(page); },
                [this](int page, std::string_view text) { hear(page, text); }};
    }

    void open(int page) {
        ++report_.sockets;
        pages_.push_back({page, ""});
        if (!pointers_.empty() && holder_ == 0) holder_ = page;
    }

    void close(int page) {
        std::erase_if(pages_, [page](const Page& one) { return one.id == page; });
        if (page != holder_) return;
        holder_ = 0;
        for (PointerDevice& pointer : pointers_)
            pointer.desk().ask([](PointerWish& wish) {
                wish.is_there = false;
                wish.buttons = 0;
            });
    }

    /// What a page that only looks says, or what is no wish, changes nothing.
    void hear(int page, std::string_view text) {
        const json message = parse_json_or_discard(text);
        if (page != holder_ || !message.is_object()) return;
        const std::string kind = message.value("/kind"_json_pointer, json()).is_string()
                                     ? message.at("kind").get<std::string>()
                                     : std::string();
        if (kind == "goal") return ask_goal(message);
        for (PointerDevice& pointer : pointers_)
            pointer.desk().ask([&](PointerWish& wish) { change(wish, kind, message); });
    }

    static void change(PointerWish& wish, const std::string& kind, const json& message) {
        if (kind == "hand") {
            wish.gain = number_of(message, "gain", 0.0, kMostGain, wish.gain);
            wish.stiffness_n_per_m =
                number_of(message, "stiffness_n_per_m", kLeastStiffness, kMostStiffness, wish.stiffness_n_per_m);
        }
        if (kind == "buttons")
            wish.buttons = static_cast<std::int32_t>(number_of(message, "held", 0.0, 7.0, 0.0)) & ~kClutchButton;
    }

    void ask_goal(const json& message) {
        const std::optional<Eigen::Vector3d> at_m = vector_of(message, "at");
        if (!at_m) return;
        const bool is_elsewhere = message.value("/place"_json_pointer, json()) == true;
        const bool is_second = message.value("/finger"_json_pointer, json()) == 1;
        if (is_second && fingers_ == 1) return;
        pointers_[is_second ? 1 : 0].desk().ask([&](PointerWish& wish) {
            if (is_elsewhere || !wish.is_there) ++wish.place;
            wish.is_there = true;
            wish.goal_m = *at_m;
        });
    }

    void push() {
        const std::vector<LiveTick> ticks = ticks_.ticks();
        report_.ticks += static_cast<std::int64_t>(ticks.size() / fingers_);
        const std::string bytes = records(ticks);
        const Clock::time_point now = Clock::now();
        tell(now);
        for (Page& page : pages_) {
            if (!ticks.empty()) server_.send_binary(page.id, bytes);
            const std::string said = status(page.id, now);
            if (said != page.said && server_.send_text(page.id, said)) page.said = said;
        }
    }

    /// Fingers of a tick and, of a body that rings, how far it has swung; of one that nothing holds, where it is.
    std::string records(const std::vector<LiveTick>& ticks) const {
        std::string bytes;
        for (std::size_t i = 0; i < ticks.size(); i += fingers_) {
            bytes.append(reinterpret_cast<const char*>(&ticks[i]), fingers_ * sizeof(LiveTick));
            bytes.append(reinterpret_cast<const char*>(ticks_.swings().data() + i / fingers_ * modes_),
                         modes_ * sizeof(float));
            if (is_free_) bytes.append(reinterpret_cast<const char*>(&ticks_.poses()[i / fingers_]), sizeof(LivePose));
        }
        return bytes;
    }

    std::string status(int page, Clock::time_point now) const {
        return json_text(json{{"kind", "status"},
                              {"touch", !pointers_.empty()},
                              {"yours", page == holder_},
                              {"lost", ticks_.lost()},
                              {"trouble", trouble(now)}});
    }

    /// Why nothing moves, for people; empty where a servo answers.
    std::string trouble(Clock::time_point now) const {
        if (refused_ && now - *refused_ < kAway) return "Another device has the servo: end that one first.";
        if (now - ticks_.heard() < kAway) return "";
        if (servo_seen_ && now - *servo_seen_ < kAway)
            return !pointers_.empty() ? "The servo is there: press on the body." : "The servo waits for a device.";
        if (ticks_.left_out().other_tables > 0)
            return fmt::format("A servo of other tables ({:016x}) speaks here: serve the folder of that one.",
                               ticks_.other_hash());
        return fmt::format("No servo is heard on {}: start build/{}/servo --lcm.", connection_.url(),
                           scene_.tables().name);
    }

    void tell(Clock::time_point now) {
        if (ticks_.refusals() > refusals_) refused_ = now;
        refusals_ = ticks_.refusals();
        live_.look("other_tables", ticks_.left_out().other_tables, now, [this] {
            return fmt::format("a servo of other tables ({:016x}) speaks on {}: it is left out; serve its own folder",
                               ticks_.other_hash(), connection_.url());
        });
        live_.look("other_servo", ticks_.left_out().other_servo, now,
                   [] { return "a second servo answers on the channel: it is left out"; });
        live_.look("damaged", ticks_.left_out().damaged, now,
                   [] { return "messages come that no servo of these tables sends: they are left out"; });
    }

    LiveReport report() {
        LiveReport report = report_;
        report.pages = server_.pages();
        report.lost_ticks = ticks_.lost();
        report.left_out = ticks_.left_out();
        for (PointerDevice& pointer : pointers_) {
            report.pointer_ticks += pointer.finish();
            report.pointer_sessions += pointer.sessions();
        }
        return report;
    }

    struct Page {
        int id;
        std::string said;  ///< the last status that it got
    };

    const LiveOptions& options_;
    LoadedScene scene_;
    std::size_t fingers_;
    bool is_free_;       ///< nothing holds the body
    std::size_t modes_;  ///< by which it rings
    LiveTicks ticks_;
    LiveState live_;
    Connection connection_;
    std::vector<Page> pages_;
    int holder_ = 0;                      ///< the page that has the pointer; 0: none
    std::deque<PointerDevice> pointers_;  ///< by finger; none: pages only look
    PageServer server_;
    std::optional<Clock::time_point> servo_seen_, refused_;
    std::int64_t refusals_ = 0;
    LiveReport report_;
};

}  // namespace

LiveReport serve_session(const TablesFolder& folder, const LiveOptions& options) {
    return LiveSession(folder, options).run();
}

}  // namespace haptable
