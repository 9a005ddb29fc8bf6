#include "api/token_cache.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::seconds kFresh{1};
constexpr std::size_t kMaxEntries = 1000;

}  // namespace

std::optional<Token> TokenCache::find(const std::string& secret_sha256) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(secret_sha256);
    if (found == entries_.end()) return std::nullopt;
    if (std::chrono::steady_clock::now() < found->second.until) return found->second.token;
    entries_.erase(found);
    return std::nullopt;
}

void TokenCache::put(const Token& token) {
    const std::lock_guard lock(mutex_);
    if (entries_.size() >= kMaxEntries) entries_.clear();
    entries_.insert_or_assign(token.secret_sha256,
                              Entry{token, std::chrono::steady_clock::now() + kFresh});
}

void TokenCache::clear() {
    const std::lock_guard lock(mutex_);
    entries_.clear();
}

}  // namespace divemesh::api
