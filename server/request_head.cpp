#include "server/request_head.hpp"

#include <limits>
#include <vector>

#include "api/field_values.hpp"
#include "api/target.hpp"

namespace divemesh::server {
namespace {

namespace http = boost::beast::http;

HeadFault bad_request(std::string detail) { return {http::status::bad_request, std::move(detail)}; }

// Returns the transfer codings of all fields Transfer-Encoding, in their order.
std::vector<std::string> transfer_codings(const RequestBody::Message& message) {
    std::string list;
    const auto [begin, end] = message.equal_range(http::field::transfer_encoding);
    for (auto field = begin; field != end; ++field) list.append(field->value()).append(",");
    return api::list_elements(list);
}

std::optional<HeadFault> transfer_encoding_fault(const RequestBody& request) {
    const auto& message = request.message();
    if (message.count(http::field::transfer_encoding) == 0) return std::nullopt;
    if (message.version() < 11)
        return bad_request("HTTP/1.0 has no Transfer-Encoding: send Content-Length or HTTP/1.1");
    if (message.count(http::field::content_length) > 0)
        return bad_request("send either Content-Length or Transfer-Encoding, not both");
    const auto codings = transfer_codings(message);
    for (const std::string& coding : codings)
        if (coding.substr(0, coding.find_first_of("; \t")) != "chunked")
            return HeadFault{http::status::not_implemented,
                             "the transfer coding " + coding + " is not known: send chunked"};
    if (codings != std::vector<std::string>{"chunked"} || request.length_bytes())
        return bad_request("Transfer-Encoding must be chunked, once and without parameters");
    return std::nullopt;
}

std::optional<HeadFault> content_length_fault(const RequestBody& request) {
    constexpr auto kMaxBytes = std::numeric_limits<std::int64_t>::max();
    if (request.content_length().value_or(0) <= std::uint64_t{kMaxBytes}) return std::nullopt;
    return bad_request("Content-Length must be at most " + std::to_string(kMaxBytes));
}

std::optional<HeadFault> host_fault(const RequestBody::Message& message) {
    const std::size_t num_hosts = message.count(http::field::host);
    if (num_hosts == 0 && message.version() < 11) return std::nullopt;
    if (num_hosts != 1) return bad_request("a request must have exactly one Host header");
    if (!api::is_host(message[http::field::host]))
        return bad_request("the header Host is invalid: send a host, and its port if it has one");
    return std::nullopt;
}

}  // namespace

std::optional<HeadFault> find_head_fault(const RequestBody& request) {
    if (auto fault = transfer_encoding_fault(request)) return fault;
    if (auto fault = content_length_fault(request)) return fault;
    return host_fault(request.message());
}

}  // namespace divemesh::server
