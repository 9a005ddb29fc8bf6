#include <cstdlib>

#include "tests/fuzz/input.hpp"
#include "tests/portless_service.hpp"

// The first byte says which request, the rest is its body.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace divemesh;
    static PortlessService service;
    static const std::pair<api::verb, std::string> requests[] = {
        {api::verb::post, "/api/v1/dives"},
        {api::verb::patch, "/api/v1/dives/" + service.dive_id()},
        {api::verb::post, "/api/v1/dives/" + service.dive_id() + "/jobs"},
        {api::verb::patch, "/api/v1/jobs/" + service.job_id()},
        {api::verb::patch, "/api/v1/queue"},
        {api::verb::post, "/api/v1/queue/redrive"},
        {api::verb::patch, "/api/v1/workers/fuzz:1"},
        {api::verb::post, "/api/v1/tokens"},
        {api::verb::post, "/api/v1/one_shot_tokens"},
        {api::verb::post, "/api/v1/webhooks"},
        {api::verb::post, "/api/v1/sensors/fuzz/status"},
        {api::verb::post, "/api/v1/jobs/" + service.job_id() + "/shares"},
    };
    fuzz::Input input(data, size);
    api::Request request;
    std::tie(request.method, request.target) = requests[input.choice(std::size(requests))];
    request.headers.emplace("content-type", "application/json");
    const auto response = service.ask(request, input.rest());
    if (response.status == api::status::internal_server_error) std::abort();
    return 0;
}
