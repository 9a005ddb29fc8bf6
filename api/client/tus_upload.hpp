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
    std::int64_t chunk_bytes = std::int64_t{16} << 20;  // of one PATCH: what one answer covers
    std::chrono::milliseconds stall{30'000};            // without a byte moving
    std::chrono::milliseconds give_up_after{0};         // without an upload moving; 0: never
    double max_bytes_per_s = 0.0;                       // 0: as fast as it goes
    int num_parts = 1;  // sent beside each other, over a connection each
};

struct TusObserver {
    std::function<void(std::int64_t bytes_done)> on_progress;
    std::function<void(std::int64_t offset)> on_resumed;  // > 0: what the server had already
    Backoff::OnWait on_wait;
};

// Sends `source` by tus 1.0 to /api/v1/uploads and returns the path of the finished upload; with
// more than one part as partial uploads that the server joins (concatenation), for links whose
// delay keeps one connection from filling them. An upload that `state` remembers goes on where the
// server's HEAD says, in as many parts as it began with. Network failures, 409, 423, 429 and 5xx
// are tried again; every other refusal is thrown as its Error. Observers are called by one thread
// at a time.
std::string upload_by_tus(const Account& account,
                          ByteSource& source,
                          const std::map<std::string, std::string>& metadata,
                          const UploadState& state,
                          const TusObserver& observer,
                          const TusSettings& settings = {});

// "filename bW92aWU=,job c3RhbmRhcmQ=": keys as they are, values in base64.
std::string tus_metadata(const std::map<std::string, std::string>& metadata);

}  // namespace divemesh::api::client
