#include "tests/end_to_end/webhook_receiver.hpp"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

fs::path scripts() { return source_directory() / "tests/end_to_end/js"; }

}  // namespace

bool WebhookReceiver::is_installed() {
    return fs::exists(scripts() / "node_modules/standardwebhooks");
}

WebhookReceiver::WebhookReceiver(Service& service,
                                 int num_workers,
                                 const std::vector<std::string>& topics)
    : node_({"/usr/bin/env",
             "node",
             (scripts() / "webhook_receiver.mjs").string(),
             (service / "secret").string()},
            service / ".") {
    if (!wait_until(30s, [&] { return node_.stdout_text().ends_with('\n'); }))
        throw std::runtime_error("no receiver of webhooks: " + node_.stderr_text());
    const std::string address = node_.stdout_text().substr(0, node_.stdout_text().find('\n'));
    setenv("DIVEMESH_WEBHOOK_NETWORK", "127.0.0.1", 1);
    service.start_server(num_workers);
    unsetenv("DIVEMESH_WEBHOOK_NETWORK");
    const auto webhook =
        service.rest().post("/api/v1/webhooks", {{"url", address}, {"topics", topics}});
    std::ofstream(service / "secret") << webhook.at("secret").get<std::string>();
}

bool WebhookReceiver::hears(const std::string& type, std::chrono::seconds timeout) {
    return wait_until(timeout, [&] { return !events(type).empty(); });
}

std::vector<nlohmann::json> WebhookReceiver::events(const std::string& type) const {
    const std::string start = "good " + type + " ";
    std::vector<nlohmann::json> found;
    std::istringstream lines(heard());
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with(start) && !lines.eof())
            found.push_back(nlohmann::json::parse(line.substr(start.size())).at("data"));
    return found;
}

}  // namespace divemesh
