#include "api/uploads/hash_cache.hpp"

#include <algorithm>

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxEntries = 1024;

}  // namespace

std::optional<Sha256> HashCache::take(const std::string& upload_id, std::int64_t offset_bytes) {
    if (offset_bytes == 0) return Sha256();
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
        return entry.upload_id == upload_id && entry.offset_bytes == offset_bytes;
    });
    if (found == entries_.end()) return std::nullopt;
    std::optional<Sha256> hash = std::move(found->hash);
    entries_.erase(found);
    return hash;
}

void HashCache::put(const std::string& upload_id, std::int64_t offset_bytes, Sha256 hash) {
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [&](const Entry& entry) { return entry.upload_id == upload_id; });
    entries_.push_front({upload_id, offset_bytes, std::move(hash)});
    if (entries_.size() > kMaxEntries) entries_.pop_back();
}

void HashCache::forget(const std::string& upload_id) {
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [&](const Entry& entry) { return entry.upload_id == upload_id; });
}

}  // namespace divemesh::api
