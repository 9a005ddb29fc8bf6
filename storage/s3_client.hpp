#pragma once

#include <chrono>
#include <cstdint>
#include <ctime>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "storage/http_exchange.hpp"
#include "storage/s3_answer.hpp"
#include "storage/s3_location.hpp"
#include "storage/sigv4.hpp"

namespace divemesh::storage {

struct S3Settings {
    HttpTimeouts timeouts;
    // For how long a request is tried again while the store answers that it is overloaded, or not
    // at all.
    std::chrono::milliseconds patience = std::chrono::seconds(60);
    std::int64_t part_bytes = std::int64_t{16} << 20;  // of what is written or fetched in parts
    std::function<std::time_t()> clock = [] { return std::time(nullptr); };
};

HttpBody body_of(std::string text);

struct S3Object {
    std::int64_t size_bytes = 0;
    std::string etag;  // as the store gave it, with its quotation marks
};

// Objects and folders below a prefix, without the prefix.
struct S3Listing {
    std::vector<std::string> names;
    std::vector<std::string> folders;  // without the slash
};

struct S3OpenUpload {
    std::string key;
    std::string id;
    std::string initiated;  // 2026-01-31T12:00:00.000Z
};

struct S3Part {
    std::string upload_id;
    int number = 0;  // from 1
};

// The requests to one bucket. Each is signed, with the hash of its body, and tried again with
// growing pauses. They throw Error: NotFound, OutOfSpace, TooLarge, Unavailable. Thread-safe.
class S3Client {
public:
    S3Client(S3Location location, S3Credentials credentials, S3Settings settings = {});

    const S3Location& location() const { return location_; }
    void stop() { http_.stop(); }  // every request, also those to come, ends without an answer
    std::int64_t part_bytes() const { return settings_.part_bytes; }

    std::optional<S3Object> find(const std::string& key);
    // Returns the bytes from `offset` on, as many as asked for. Throws Error{Unavailable} if the
    // object is not the one of this `etag`, or ends earlier.
    std::string get(const std::string& key,
                    const std::string& etag,
                    std::int64_t offset,
                    std::size_t size);
    // Returns a small object, nullopt if there is none. Asks once: for what is asked again anyway.
    std::optional<std::string> get_small(const std::string& key, std::size_t max_bytes);
    void put(const std::string& key, const HttpBody& body);
    void remove(const std::string& key);
    void remove(const std::vector<std::string>& keys);  // at most kMaxKeysAtATime
    // With `by_folder`, what lies deeper is named by its folder.
    S3Listing list(const std::string& prefix, bool by_folder);

    std::string begin_upload(const std::string& key);  // returns its id
    std::string put_part(const std::string& key, const S3Part& part, const HttpBody& body);
    void complete_upload(const std::string& key,
                         const std::string& id,
                         const std::vector<std::string>& etags,
                         std::int64_t size_bytes);
    void abort_upload(const std::string& key, const std::string& id);  // also one that is gone
    std::vector<S3OpenUpload> open_uploads(const std::string& prefix);

    static constexpr std::size_t kMaxKeysAtATime = 1000;

private:
    struct Request {
        std::string method;
        std::string key;
        std::map<std::string, std::string> query = {};
        std::map<std::string, std::string> headers = {};
        HttpBody body = {};
        std::size_t max_answer_bytes = kMaxAnswerBytes;
    };
    static constexpr std::size_t kMaxAnswerBytes = std::size_t{8} << 20;

    HttpAnswer try_once(const Request& request, const std::string& sha256);
    HttpAnswer send(const Request& request);
    HttpAnswer require(const std::string& doing, const Request& request);

    S3Location location_;
    S3Credentials credentials_;
    S3Settings settings_;
    HttpExchange http_;
};

}  // namespace divemesh::storage
