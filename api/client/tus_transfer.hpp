#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "api/client/rate_limiter.hpp"
#include "api/client/tus_upload.hpp"

namespace divemesh::api::client {

using TusHeaders = std::vector<std::pair<std::string, std::string>>;

// What all transfers of one upload share.
struct TusContext {
    const Account& account;
    const TusSettings& settings;
    RateLimiter& rate;
    std::stop_token stop;
};

struct TransferObserver {
    std::function<void(const std::string& path)>
        on_path;  // where it is now; "": it no longer exists
    std::function<void(std::int64_t bytes_done)> on_progress;
    std::function<void(std::int64_t offset)> on_resumed;
    Backoff::OnWait on_wait;
};

// Sends `source` as one tus resource, with the headers `creation` besides its length, and returns
// its path. Resumes the resource at `path` unless that is "".
std::string send_by_tus(const TusContext& context,
                        ByteSource& source,
                        const TusHeaders& creation,
                        const std::string& path,
                        const TransferObserver& observer);

// Concatenates complete parts into one resource and returns its path. Throws Error{NotFound} if the
// server no longer has one of them.
std::string join_by_tus(const TusContext& context,
                        const std::vector<std::string>& parts,
                        std::int64_t size_bytes,
                        const TusHeaders& creation,
                        const Backoff::OnWait& on_wait);

}  // namespace divemesh::api::client
