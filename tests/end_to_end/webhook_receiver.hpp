#pragma once

#include <string>
#include <vector>

#include "tests/end_to_end/service.hpp"

namespace divemesh {

// A process that receives webhooks and checks their signatures with the library of Standard
// Webhooks.
class WebhookReceiver {
public:
    static bool is_installed();  // false: run npm ci in tests/end_to_end/js first

    // Starts the service with `num_workers`, allows it to reach loopback, and subscribes to
    // `topics`.
    WebhookReceiver(Service& service, int num_workers, const std::vector<std::string>& topics);

    // Waits until an event of that type arrives with a valid signature; false after the timeout.
    bool hears(const std::string& type, std::chrono::seconds timeout);
    // Returns the data of the events of that type until now, those with a valid signature.
    std::vector<nlohmann::json> events(const std::string& type) const;
    std::string heard() const { return node_.stdout_text(); }

private:
    Process node_;
};

}  // namespace divemesh
