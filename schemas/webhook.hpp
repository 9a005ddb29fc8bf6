#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// The topics of events that a webhook can subscribe to.
inline constexpr std::array<std::string_view, 4> kWebhookTopics = {
    "upload", "dive", "job", "sensor"};

// An external receiver of a project's events (Standard Webhooks 1.0).
struct Webhook {
    std::string id;
    std::string project;
    std::string url;
    std::vector<std::string> topics;  // of kWebhookTopics
    bool enabled = true;              // false: the receiver has answered 410
    std::int64_t created_at_ms = 0;
};

// One event for one webhook, and the state of its delivery.
struct WebhookDelivery {
    std::string id;  // the message's, the same for each attempt
    std::string webhook_id;
    std::string type;   // of the event
    std::string state;  // waiting, delivered, failed
    int num_attempts = 0;
    std::int64_t next_at_ms = 0;  // of the next attempt, while waiting
    int last_status = 0;          // HTTP status; 0: no response
    std::string last_error;       // "" after a success
    std::int64_t created_at_ms = 0;
    std::int64_t finished_at_ms = 0;
};

}  // namespace divemesh
