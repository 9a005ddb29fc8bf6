#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "schemas/file_descriptor.hpp"

namespace divemesh {

using Headers = std::vector<std::pair<std::string, std::string>>;

struct RawResponse {
    int status = 0;
    std::map<std::string, std::string> headers;  // names in lower case
    std::string body;

    std::string header(const std::string& name) const;  // "" if missing
    nlohmann::json json() const { return nlohmann::json::parse(body); }
};

// An HTTP client that sends any bytes, valid or not, and can reset the connection at any point. It
// times out after 20 s without a byte.
class RawClient {
public:
    explicit RawClient(int port, int receive_buffer_bytes = 0);

    bool send(std::string_view bytes);  // false: the server has closed
    // Returns the next response, without 100 Continue; nullopt if the connection ends before it is
    // complete. `head`: the response has no body.
    std::optional<RawResponse> receive(bool head = false);
    std::string read_available();  // blocks for the first byte; "" at the end
    bool at_end();                 // waits; true if the server closes without another byte
    void reset();                  // closes with RST

    // Sends a request and returns the response. Fails the test if it breaks api/openapi.yaml;
    // throws std::runtime_error without a response.
    RawResponse request(const std::string& method,
                        const std::string& target,
                        const Headers& headers = {},
                        std::string_view body = {});

private:
    std::optional<RawResponse> receive_one(bool head);
    std::optional<std::string> receive_chunks();  // nullopt: the connection ended before
    bool receive_bytes(std::size_t size);         // until `received_` has so many

    FileDescriptor socket_;
    std::string received_;
};

std::string request_head(const std::string& method,
                         const std::string& target,
                         const Headers& headers,
                         std::optional<std::size_t> content_length);

std::string base64(std::string_view bytes);

}  // namespace divemesh
