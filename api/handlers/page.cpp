#include "api/handlers/page.hpp"

#include <algorithm>

#include "api/content_coding.hpp"
#include "api/etag.hpp"
#include "api/plain_share.hpp"
#include "api/public_url.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::string_view kNoPage =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>divemesh</title>"
    "<p>This server was built without the web page, because Node.js was missing."
    "<p>Its API is at <code>/api/v1</code>, described by <a "
    "href=\"/openapi.json\">/openapi.json</a>."
    "</html>\n";

// No script but our own files, and no other server. Only attributes may hold styles.
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "style-src-attr 'unsafe-inline'; img-src 'self' blob: data:; media-src 'self' blob:; "
    "font-src 'self'; connect-src 'self' blob:; worker-src 'self' blob:; frame-src 'self' blob:; "
    "manifest-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors ";

// Bytes that live as long as the program, sent piece by piece like those of a blob.
class BytesReader : public storage::BlobReader {
public:
    explicit BytesReader(std::string_view bytes) : bytes_(bytes) {}

    std::int64_t size_bytes() const override { return std::ssize(bytes_); }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        const auto rest = bytes_.substr(std::min(static_cast<std::size_t>(offset), bytes_.size()));
        return rest.copy(buffer.data(), buffer.size());
    }

private:
    std::string_view bytes_;
};

const PageFile* find_file(const Services& services, std::string_view name) {
    const auto found = std::find_if(services.page.begin(),
                                    services.page.end(),
                                    [&](const PageFile& file) { return file.name == name; });
    return found == services.page.end() ? nullptr : &*found;
}

void protect(Response& response, const std::string& frame_ancestors) {
    response.set("Content-Security-Policy", std::string(kPolicy) + frame_ancestors);
    response.set("Referrer-Policy", "no-referrer");
}

Response send_file(const Request& request, const PageFile& file, std::string_view freshness) {
    const bool compressed = !file.gzip.empty() && accepts_gzip(request.header("accept-encoding"));
    const std::string plain_etag = '"' + std::string(file.sha256.substr(0, 32)) + '"';
    const std::string etag = compressed ? gzip_etag(plain_etag) : plain_etag;
    const bool is_known = matches_etag(request.header("if-none-match"), plain_etag);
    Response response = empty_response(is_known ? http::status::not_modified : http::status::ok);
    response.set("ETag", etag);
    response.set("Cache-Control", std::string(freshness));
    if (!file.gzip.empty()) response.add_vary("Accept-Encoding");
    if (is_known) return response;
    const std::string_view bytes = compressed ? file.gzip : file.bytes;
    response.set("Content-Type", std::string(file.media_type));
    if (compressed) response.set("Content-Encoding", "gzip");
    response.body = FilePart{std::make_shared<BytesReader>(bytes), 0, std::ssize(bytes)};
    return response;
}

Response page_response(const Request& request,
                       const Services& services,
                       const std::string& frame_ancestors) {
    static constexpr PageFile kInstead{.media_type = "text/html; charset=utf-8", .bytes = kNoPage};
    const PageFile* index = find_file(services, "index.html");
    Response response = send_file(request, index != nullptr ? *index : kInstead, "no-cache");
    protect(response, frame_ancestors);
    return response;
}

Response plain_response(const char* media_type, std::string_view text) {
    Response response = empty_response(http::status::ok);
    response.set("Content-Type", media_type);
    response.body = std::string(text);
    protect(response, "'none'");
    return response;
}

}  // namespace

Awaitable<Response> show_page(Request request, Services services) {
    co_return page_response(request, services, "'none'");
}

Awaitable<Response> show_page_in_frame(Request request, Services services) {
    std::string ancestors;
    for (const std::string& origin : services.limits.frame_ancestors)
        ancestors += (ancestors.empty() ? "" : " ") + origin;
    co_return page_response(request, services, ancestors.empty() ? "'none'" : ancestors);
}

Awaitable<Response> show_share(Request request, Services services) {
    const bool has_page = find_file(services, "index.html") != nullptr;
    if (has_page && !has_prefix(services.limits))
        co_return page_response(request, services, "'none'");
    co_return plain_response("text/html; charset=utf-8", plain_share_html());
}

Awaitable<Response> get_plain_share_script(Request, Services) {
    co_return plain_response("text/javascript; charset=utf-8", plain_share_js());
}

Awaitable<Response> get_page_asset(Request request, Services services) {
    const std::string& name = request.parameter("asset_name");
    const PageFile* file = find_file(services, "assets/" + name);
    if (file == nullptr)
        throw Error(ErrorCode::NotFound,
                    "the page of this version has no file " + name + ": load the page again");
    Response response = send_file(request, *file, "public, max-age=31536000, immutable");
    protect(response, "'none'");
    co_return response;
}

}  // namespace divemesh::api
