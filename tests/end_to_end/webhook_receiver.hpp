#pragma once

#include <string>
#include <vector>

#include "tests/end_to_end/service.hpp"

namespace divemesh {

// A receiver of webhooks as a process, which checks signatures by Standard Webhooks' own library.
class WebhookReceiver {
public:
    static bool is_installed();  // false: run npm ci in tests/end_to_end/js first

    // Starts the service with so many workers, lets it speak to loopback, and subscribes.
    WebhookReceiver(Service& service, int num_workers, const std::vector<std::string>& topics);

    // Waits until an event of that type came, well signed.
    bool hears(const std::string& type, std::chrono::seconds timeout);
    // The data of the events that came.
    std::vector<nlohmann::json> events(const std::string& type) const;
    std::string heard() const { return node_.stdout_text(); }

private:
    Process node_;
};

}  // namespace divemesh
