#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "sensor/ring/message_ring.hpp"

namespace divemesh::sensor {

// What is said first when there is little time: who this is, what became of commands, how it is
// now, what it sees now; then what is left from before, words before pictures, the oldest first.
// One thread at a time.
class SendOrder {
public:
    explicit SendOrder(MessageRing& ring) : ring_(ring) {}

    struct Next {
        MessageRing::Key key;
        bool is_historical = false;  // it is not how it is now
    };
    // Nothing when everything is under way.
    std::optional<Next> next() const;

    void sent(MessageRing::Key key, MessageKind kind);
    void committed(MessageRing::Key key);
    void refused(MessageRing::Key key) { in_flight_.erase(key); }
    // The connection ended: what was under way is to be sent again.
    void give_back();

    const std::set<MessageRing::Key>& in_flight() const { return in_flight_; }

private:
    std::optional<MessageRing::Key> live(MessageKind kind) const;

    MessageRing& ring_;
    std::set<MessageRing::Key> in_flight_;
    std::map<MessageKind, std::int64_t> newest_sent_;  // of this boot
    std::map<MessageKind, std::int64_t> newest_committed_;
    std::map<MessageRing::Key, MessageKind> kinds_;  // of what is under way
};

}  // namespace divemesh::sensor
