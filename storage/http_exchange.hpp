#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace divemesh::storage {

// The body of a request, which may be sent more than once. read() fills the buffer from an offset
// on and returns how much; it may throw.
struct HttpBody {
    std::int64_t size_bytes = 0;
    std::function<std::size_t(std::int64_t offset, std::span<char> buffer)> read = {};
};

struct HttpRequest {
    std::string method;
    std::string url;
    std::map<std::string, std::string> headers;
    HttpBody body;
    std::size_t max_answer_bytes = 0;  // what is longer is cut off there
};

// An answer, or why there is none: then status is 0.
struct HttpAnswer {
    long status = 0;
    std::map<std::string, std::string> headers;  // names in lower case
    std::string body;
    bool is_cut_off = false;  // the body is longer than max_answer_bytes
    std::string failure;
    bool failure_may_pass = false;  // a later try may succeed
};

struct HttpTimeouts {
    std::chrono::milliseconds connect = std::chrono::seconds(10);
    std::chrono::seconds silence{60};  // without a byte in either direction
};

// Speaks HTTP/1.1 over connections that it keeps open, with certificates verified and no redirects
// followed. Thread-safe: each exchange has a connection to itself.
class HttpExchange {
public:
    explicit HttpExchange(const HttpTimeouts& timeouts);
    ~HttpExchange();
    HttpExchange(const HttpExchange&) = delete;
    HttpExchange& operator=(const HttpExchange&) = delete;

    // Throws only what the body's read() throws.
    HttpAnswer send(const HttpRequest& request);

    void stop() { is_stopped_ = true; }  // every exchange, also those to come, ends

private:
    using Handle = std::unique_ptr<void, void (*)(void*)>;
    Handle take();
    void give_back(Handle handle);

    HttpTimeouts timeouts_;
    std::atomic<bool> is_stopped_ = false;
    std::string certificates_;  // file of accepted authorities; "": those of the system
    std::mutex mutex_;
    std::vector<Handle> idle_;
};

}  // namespace divemesh::storage
