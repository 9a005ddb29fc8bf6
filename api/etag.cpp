#include "api/etag.hpp"

#include <algorithm>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::string_view kGzip = "-gzip\"";

// The tag of a compressed answer names the same state.
std::string without_coding(std::string_view tag) {
    if (!tag.ends_with(kGzip)) return std::string(tag);
    return std::string(tag.substr(0, tag.size() - kGzip.size())) + '"';
}

bool lists(std::string_view list, std::string_view etag, bool weakly) {
    for (std::size_t start = 0; start <= list.size();) {
        const auto end = std::min(list.find(',', start), list.size());
        auto tag = list.substr(start, end - start);
        start = end + 1;
        while (!tag.empty() && tag.front() == ' ') tag.remove_prefix(1);
        while (!tag.empty() && tag.back() == ' ') tag.remove_suffix(1);
        if (weakly && tag.starts_with("W/")) tag.remove_prefix(2);
        if (!tag.empty() && (without_coding(tag) == etag || tag == "*")) return true;
    }
    return false;
}

}  // namespace

std::string etag_of(std::string_view body) { return '"' + sha256_hex(body).substr(0, 32) + '"'; }

std::string gzip_etag(std::string_view etag) {
    return std::string(etag.substr(0, etag.size() - 1)).append(kGzip);
}

bool matches_etag(std::string_view list, std::string_view etag) { return lists(list, etag, true); }

void require_listed(std::string_view list, std::string_view etag) {
    if (!lists(list, etag, false))
        throw Error(ErrorCode::PreconditionFailed,
                    "it has changed since you read it: read it again");
}

void require_match(const Request& request, std::string_view body) {
    if (!request.has_header("if-match"))
        throw Error(ErrorCode::PreconditionRequired,
                    "there is no If-Match: read it first and send its ETag as If-Match, or send "
                    "If-Match: *");
    require_listed(request.header("if-match"), etag_of(body));
}

void add_etag(const Request& request, Response& response) {
    const auto* body = std::get_if<std::string>(&response.body);
    const bool reads = request.method == verb::get || request.method == verb::head;
    if (response.status != http::status::ok || body == nullptr || body->empty() || !reads ||
        response.has("Cache-Control"))
        return;
    const std::string etag = etag_of(*body);
    if (matches_etag(request.header("if-none-match"), etag)) {
        std::erase_if(response.headers,
                      [](const auto& header) { return header.first == "Content-Type"; });
        response.status = http::status::not_modified;
        response.body = std::string();
    }
    response.set("ETag", etag);
    response.set("Cache-Control", "private, no-cache");
}

}  // namespace divemesh::api
