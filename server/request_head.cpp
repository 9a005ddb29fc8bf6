#include "server/request_head.hpp"

#include <vector>

#include "api/field_values.hpp"

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

}  // namespace

std::optional<HeadFault> find_head_fault(const RequestBody& request) {
    return transfer_encoding_fault(request);
}

}  // namespace divemesh::server
