#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "sensor/ring/message_ring.hpp"

namespace divemesh::sensor {

// The order of sending when time is short: hello, outcomes of commands, the current status, the
// current preview; then older messages, texts before previews, oldest first. Use it from one thread
// at a time.
class SendOrder {
public:
    explicit SendOrder(MessageRing& ring) : ring_(ring) {}

    struct Next {
        MessageRing::Key key;
        bool is_historical = false;  // it does not describe the present
    };
    // Returns the next message; nullopt if all are under way.
    std::optional<Next> next() const;

    void sent(MessageRing::Key key, MessageKind kind);
    void committed(MessageRing::Key key);
    void refused(MessageRing::Key key) { in_flight_.erase(key); }
    // Call it when the connection ended: messages under way have to be sent again.
    void give_back();

private:
    std::optional<MessageRing::Key> live(MessageKind kind) const;

    MessageRing& ring_;
    std::set<MessageRing::Key> in_flight_;
    std::map<MessageKind, std::int64_t> newest_sent_;  // of this boot
    std::map<MessageKind, std::int64_t> newest_committed_;
    std::map<MessageRing::Key, MessageKind> kinds_;  // of the messages under way
};

}  // namespace divemesh::sensor
