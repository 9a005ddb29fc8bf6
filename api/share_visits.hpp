#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace divemesh::api {

// Remembers who uses which sharing link, so that a visit is audited once and not with each file
// that a page reads. Bounded. Thread-safe.
class ShareVisits {
public:
    // Returns whether a visit begins: the address did not begin one within the last ten minutes.
    bool is_new(const std::string& token_id, const std::string& peer);

private:
    std::mutex mutex_;
    std::map<std::pair<std::string, std::string>, std::chrono::steady_clock::time_point> began_;
};

}  // namespace divemesh::api
