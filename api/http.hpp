#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/http/verb.hpp>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "api/body_source.hpp"
#include "api/body_stream.hpp"
#include "schemas/token.hpp"
#include "storage/blob_store.hpp"

// The few HTTP types that the handlers use. Everything about sockets stays in server/.
namespace divemesh::api {

namespace http = boost::beast::http;
using http::status;
using http::verb;
template <typename T>
using Awaitable = boost::asio::awaitable<T>;

struct Request {
    verb method = verb::get;
    std::string target;                                          // as received: path and query
    std::string path;                                            // still escaped, without query
    std::map<std::string, std::string, std::less<>> query;       // unescaped
    std::map<std::string, std::string, std::less<>> headers;     // names in lower case
    std::map<std::string, std::string, std::less<>> parameters;  // "{id}" of the path, unescaped
    std::shared_ptr<BodyStream> stream;  // never null; for a plain route it has been read into body
    std::string body;
    Token token;  // the caller's; without a scope on routes that need no scope
    std::string id;
    std::string trace_id;   // of a valid traceparent (W3C Trace Context); "" without one
    std::string peer;       // address of the client, as a trusted proxy states it
    bool is_https = false;  // as the client sees it

    std::string header(std::string_view lower_case_name) const;  // "" if it is missing
    bool has_header(std::string_view lower_case_name) const;
    const std::string& parameter(std::string_view name) const;
};

// Bytes of a blob that the server streams as the body.
struct FilePart {
    std::shared_ptr<storage::BlobReader> reader;
    std::int64_t offset = 0;
    std::int64_t length = 0;
};

// A body whose length is not known before its end. The server reads it once.
struct StreamedBody {
    std::shared_ptr<BodySource> source;
};

// Turns the connection into a WebSocket that carries events after `since` of `project` ("": all),
// as long as the token is valid ("": no authentication).
struct EventFeed {
    std::int64_t since = 0;
    std::string project;
    std::string token_id;
    std::vector<std::string> sensors;  // watched live as well
};

// Turns the connection into a WebSocket that carries a sensor's stream, as long as the token is
// valid.
struct SensorStream {
    std::string sensor;
    std::string project;
    std::string token_id;
};

struct Route;

struct Response {
    http::status status = http::status::ok;
    std::vector<std::pair<std::string, std::string>> headers;
    std::variant<std::string, FilePart, StreamedBody, EventFeed, SensorStream> body = {};

    // For log and metrics, set by dispatch; null and "" if there is no route or no token.
    const Route* route = nullptr;
    std::string token_id;
    std::optional<std::int64_t> uploaded_bytes;  // size of an upload that this request completed
    bool audited = false;                        // the audit event has been written

    void set(std::string name, std::string value);
    bool has(std::string_view name) const;   // as it was set
    void add_vary(const std::string& name);  // a header field of the request that decided
};

// Returns the text that json_response puts into the body.
std::string json_text(const nlohmann::json& value);
Response json_response(http::status status, const nlohmann::json& body);
Response empty_response(http::status status);

// Returns e.g. "Sun, 06 Nov 1994 08:49:37 GMT" (RFC 9110, section 5.6.7).
std::string http_date(std::int64_t unix_s);

}  // namespace divemesh::api
