#include "api/upload_turns.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::api {

namespace asio = boost::asio;

struct UploadTurns::Holder {
    UploadTurns* turns;
    std::string upload_id;
    std::function<void()> stop;
    std::vector<std::shared_ptr<asio::steady_timer>> waiting;  // woken when the turn ends
};

UploadTurns::Turn::~Turn() {
    if (!holder_) return;
    auto& strand = holder_->turns->strand_;  // before the holder moves
    asio::post(strand, [holder = std::move(holder_)] {
        holder->turns->holders_.erase(holder->upload_id);
        for (const auto& timer : holder->waiting) timer->cancel();
    });
}

asio::awaitable<UploadTurns::Turn> UploadTurns::take(std::string upload_id,
                                                     std::function<void()> stop) {
    auto holder = co_await asio::co_spawn(
        strand_, wait(std::move(upload_id), std::move(stop)), asio::use_awaitable);
    co_return Turn(std::move(holder));
}

asio::awaitable<std::optional<UploadTurns::Turn>> UploadTurns::take_if_free(std::string upload_id) {
    auto holder =
        co_await asio::co_spawn(strand_, hold_if_free(std::move(upload_id)), asio::use_awaitable);
    if (!holder) co_return std::nullopt;
    co_return Turn(std::move(holder));
}

asio::awaitable<std::shared_ptr<UploadTurns::Holder>> UploadTurns::hold_if_free(
    std::string upload_id) {
    if (holders_.contains(upload_id)) co_return nullptr;
    auto holder = std::make_shared<Holder>(Holder{this, upload_id, [] {}, {}});
    holders_.emplace(std::move(upload_id), holder);
    co_return holder;
}

asio::awaitable<std::shared_ptr<UploadTurns::Holder>> UploadTurns::wait(
    std::string upload_id, std::function<void()> stop) {
    const auto end = std::chrono::steady_clock::now() + patience_;
    for (;;) {
        const auto found = holders_.find(upload_id);
        if (found == holders_.end()) break;
        const auto older = found->second;
        older->stop();
        const auto timer = std::make_shared<asio::steady_timer>(strand_, end);
        older->waiting.push_back(timer);
        co_await timer->async_wait(asio::as_tuple(asio::use_awaitable));
        if (std::chrono::steady_clock::now() >= end)
            throw Error(ErrorCode::Locked, "another request still works on this upload: try again");
    }
    auto holder = std::make_shared<Holder>(Holder{this, upload_id, std::move(stop), {}});
    holders_.emplace(std::move(upload_id), holder);
    co_return holder;
}

}  // namespace divemesh::api
