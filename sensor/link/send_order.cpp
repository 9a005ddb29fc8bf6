#include "sensor/link/send_order.hpp"

#include <algorithm>

namespace divemesh::sensor {

std::optional<SendOrder::Next> SendOrder::next() const {
    for (const MessageKind kind :
         {MessageKind::Hello, MessageKind::Outcome, MessageKind::Status, MessageKind::Preview})
        if (const auto key = live(kind)) return Next{*key, false};
    for (const auto pile : {MessageRing::Pile::Texts, MessageRing::Pile::Previews})
        if (const auto key = ring_.oldest(pile, in_flight_)) return Next{*key, true};
    return std::nullopt;
}

// Returns the newest message of its kind, unless a newer one has been sent.
std::optional<MessageRing::Key> SendOrder::live(MessageKind kind) const {
    const auto key = ring_.newest(kind);
    if (!key || in_flight_.contains(*key)) return std::nullopt;
    const auto newest = newest_sent_.find(kind);
    if (newest != newest_sent_.end() && key->sequence <= newest->second) return std::nullopt;
    return key;
}

void SendOrder::sent(MessageRing::Key key, MessageKind kind) {
    in_flight_.insert(key);
    kinds_[key] = kind;
    if (!ring_.is_of_this_boot(key)) return;
    auto& newest = newest_sent_.emplace(kind, key.sequence).first->second;
    newest = std::max(newest, key.sequence);
}

void SendOrder::committed(MessageRing::Key key) {
    const auto kind = kinds_.find(key);
    in_flight_.erase(key);
    if (kind == kinds_.end()) return;
    if (ring_.is_of_this_boot(key)) {
        auto& newest = newest_committed_.emplace(kind->second, key.sequence).first->second;
        newest = std::max(newest, key.sequence);
    }
    kinds_.erase(kind);
}

void SendOrder::give_back() {
    in_flight_.clear();
    kinds_.clear();
    newest_sent_ = newest_committed_;
}

}  // namespace divemesh::sensor
