#include "api/token_watch.hpp"

#include "api/in_pool.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::seconds kTrusted{1};

}  // namespace

bool TokenWatch::is_trusted() const {
    return token_id_.empty() || std::chrono::steady_clock::now() - asked_at_ < kTrusted;
}

bool TokenWatch::is_valid(storage::Catalog& catalog) {
    if (is_trusted()) return true;
    asked_at_ = std::chrono::steady_clock::now();
    return storage::TokenStore(catalog).is_valid(token_id_);
}

Awaitable<bool> TokenWatch::is_valid_now(Services services) {
    if (is_trusted()) co_return true;
    auto ask = [this, &catalog = services.catalog] { return is_valid(catalog); };
    co_return co_await in_pool(services.pool, std::move(ask));
}

}  // namespace divemesh::api
