#include "api/content_coding.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

#include "api/etag.hpp"
#include "api/field_values.hpp"
#include "api/gzip.hpp"
#include "api/in_pool.hpp"
#include "api/routes.hpp"

namespace divemesh::api {
namespace {

constexpr std::int64_t kMinBytes = 1024;
constexpr std::int64_t kManyBytes = std::int64_t{32} << 10;  // take their time, in the pool

std::string* find_header(Response& response, std::string_view name) {
    for (auto& [field, value] : response.headers)
        if (field == name) return &value;
    return nullptr;
}

void erase_header(Response& response, std::string_view name) {
    std::erase_if(response.headers, [&](const auto& header) { return header.first == name; });
}

bool is_compressible(const std::string& media_type) {
    static constexpr std::array<std::string_view, 5> kTypes = {"application/json",
                                                               "application/problem+json",
                                                               "application/vnd.ply",
                                                               "application/xml",
                                                               "model/obj"};
    return media_type.starts_with("text/") ||
           std::find(kTypes.begin(), kTypes.end(), media_type) != kTypes.end();
}

// Returns the size of a body that may be compressed; nullopt for others.
std::optional<std::int64_t> size_of(const Response& response) {
    if (const auto* text = std::get_if<std::string>(&response.body))
        return static_cast<std::int64_t>(text->size());
    if (const auto* file = std::get_if<FilePart>(&response.body)) return file->length;
    return std::nullopt;
}

// Headers that describe the bytes as they were.
void describe_gzip(Response& response) {
    response.set("Content-Encoding", "gzip");
    if (auto* etag = find_header(response, "ETag")) *etag = gzip_etag(*etag);
    for (const char* name : {"Accept-Ranges", "Content-Digest", "Repr-Digest"})
        erase_header(response, name);
}

// Not what holds a secret (BREACH), and not the files of the page, which are compressed already.
bool may_be_compressed(const Route* route) {
    return route == nullptr || (route->kind != RouteKind::Secret && route->kind != RouteKind::Page);
}

// A client that has the compressed answer is told the tag of that.
void tell_known_tag(const Request& request, Response& response) {
    auto* etag = find_header(response, "ETag");
    if (etag != nullptr &&
        request.header("if-none-match").find(gzip_etag(*etag)) != std::string::npos)
        *etag = gzip_etag(*etag);
}

}  // namespace

bool accepts_gzip(std::string_view accept_encoding) {
    std::optional<bool> takes_gzip;
    std::optional<bool> takes_any;
    for (const std::string& element : list_elements(accept_encoding)) {
        const auto end = element.find_first_of("; \t");
        const std::string coding = element.substr(0, end);
        const auto quality = element.find("q=");
        const bool is_taken =
            quality == std::string::npos || std::strtod(element.c_str() + quality + 2, nullptr) > 0;
        if (coding == "gzip" || coding == "x-gzip") takes_gzip = is_taken;
        if (coding == "*") takes_any = is_taken;
    }
    return takes_gzip.value_or(takes_any.value_or(false));
}

Awaitable<Response> with_content_coding(Request request, Services services, Response response) {
    const bool reads = request.method == verb::get || request.method == verb::head;
    if (!reads || !may_be_compressed(response.route)) co_return response;
    if (response.status == http::status::not_modified) {
        tell_known_tag(request, response);
        response.add_vary("Accept-Encoding");
        co_return response;
    }
    const auto size = size_of(response);
    const auto* type = find_header(response, "Content-Type");
    if (response.status == http::status::partial_content || !size || type == nullptr ||
        !is_compressible(media_type_of(*type)))
        co_return response;
    response.add_vary("Accept-Encoding");
    if (*size < kMinBytes || request.has_header("range") ||
        !accepts_gzip(request.header("accept-encoding")))
        co_return response;
    describe_gzip(response);
    if (const auto* file = std::get_if<FilePart>(&response.body)) {
        response.body = StreamedBody{gzip_source(*file)};
        co_return response;
    }
    auto work = [text = std::move(std::get<std::string>(response.body))] { return gzip(text); };
    if (*size < kManyBytes)
        response.body = work();
    else
        response.body = co_await in_pool(services.pool, std::move(work));
    co_return response;
}

}  // namespace divemesh::api
