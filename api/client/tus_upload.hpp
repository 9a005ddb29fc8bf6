#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "api/client/backoff.hpp"
#include "api/client/byte_source.hpp"
#include "api/client/rest_client.hpp"
#include "api/client/upload_state.hpp"

namespace divemesh::api::client {

struct TusSettings {
    std::int64_t chunk_bytes = std::int64_t{16} << 20;  // of one PATCH, which gets one response
    std::chrono::milliseconds stall{30'000};            // without a byte moving
    std::chrono::milliseconds give_up_after{0};         // without progress of an upload; 0: never
    double max_bytes_per_s = 0.0;                       // 0: no limit
    int num_parts = 1;  // sent in parallel, each over its own connection
};

struct TusObserver {
    std::function<void(std::int64_t bytes_done)> on_progress;
    std::function<void(std::int64_t offset)> on_resumed;  // > 0: bytes that the server had already
    Backoff::OnWait on_wait;
};

// Sends `source` by tus 1.0 to /api/v1/uploads and returns the path of the finished upload. With
// more than one part it sends partial uploads that the server concatenates, for links whose delay
// keeps one connection from filling them. Resumes an upload that `state` remembers at the offset of
// the server's HEAD, with the same number of parts. Retries network failures, 409, 423, 429 and
// 5xx; throws every other refusal as its Error. Observers are called by one thread at a time.
std::string upload_by_tus(const Account& account,
                          ByteSource& source,
                          const std::map<std::string, std::string>& metadata,
                          const UploadState& state,
                          const TusObserver& observer,
                          const TusSettings& settings = {});

// Returns e.g. "filename bW92aWU=,job c3RhbmRhcmQ=": keys as they are, values in base64.
std::string tus_metadata(const std::map<std::string, std::string>& metadata);

}  // namespace divemesh::api::client
