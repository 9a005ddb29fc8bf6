#include "api/share_visits.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::minutes kVisit{10};
constexpr std::size_t kMaxVisits = 10'000;

}  // namespace

bool ShareVisits::is_new(const std::string& token_id, const std::string& peer) {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    if (began_.size() >= kMaxVisits)
        std::erase_if(began_, [now](const auto& visit) { return now - visit.second >= kVisit; });
    if (began_.size() >= kMaxVisits) began_.clear();
    const auto [visit, is_first] = began_.try_emplace({token_id, peer}, now);
    if (!is_first && now - visit->second < kVisit) return false;
    visit->second = now;
    return true;
}

}  // namespace divemesh::api
