#include "api/uploads/upload_locks.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <map>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::api {

namespace asio = boost::asio;

struct UploadLocks::State {
    asio::strand<asio::any_io_executor> strand;
    std::map<std::string, std::shared_ptr<Holder>> holders;  // used on the strand only
};

struct UploadLocks::Holder {
    std::weak_ptr<State> state;
    std::string upload_id;
    std::function<void()> stop;
    std::vector<std::shared_ptr<asio::steady_timer>> waiting;  // woken when the lock is released
};

// Posting throws only without an executor. NOLINTNEXTLINE(bugprone-exception-escape)
UploadLocks::Lock::~Lock() {
    if (!holder_) return;
    const auto state = holder_->state.lock();
    if (!state) return;
    asio::post(state->strand, [state, holder = std::move(holder_)] {
        state->holders.erase(holder->upload_id);
        for (const auto& timer : holder->waiting) timer->cancel();
    });
}

UploadLocks::UploadLocks(const asio::any_io_executor& executor, std::chrono::milliseconds timeout)
    : state_(std::make_shared<State>(State{asio::make_strand(executor), {}})), timeout_(timeout) {}

asio::awaitable<UploadLocks::Lock> UploadLocks::take(std::string upload_id,
                                                     std::function<void()> stop) {
    auto holder = co_await asio::co_spawn(
        state_->strand, wait(std::move(upload_id), std::move(stop)), asio::use_awaitable);
    co_return Lock(std::move(holder));
}

asio::awaitable<std::optional<UploadLocks::Lock>> UploadLocks::take_if_free(std::string upload_id) {
    auto holder = co_await asio::co_spawn(
        state_->strand, hold_if_free(std::move(upload_id)), asio::use_awaitable);
    if (!holder) co_return std::nullopt;
    co_return Lock(std::move(holder));
}

asio::awaitable<std::shared_ptr<UploadLocks::Holder>> UploadLocks::hold_if_free(
    std::string upload_id) {
    if (state_->holders.contains(upload_id)) co_return nullptr;
    auto holder = std::make_shared<Holder>(Holder{state_, upload_id, [] {}, {}});
    state_->holders.emplace(std::move(upload_id), holder);
    co_return holder;
}

asio::awaitable<std::shared_ptr<UploadLocks::Holder>> UploadLocks::wait(
    std::string upload_id, std::function<void()> stop) {
    const auto end = std::chrono::steady_clock::now() + timeout_;
    for (;;) {
        const auto found = state_->holders.find(upload_id);
        if (found == state_->holders.end()) break;
        const auto older = found->second;
        older->stop();
        const auto timer = std::make_shared<asio::steady_timer>(state_->strand, end);
        older->waiting.push_back(timer);
        co_await timer->async_wait(asio::as_tuple(asio::use_awaitable));
        if (std::chrono::steady_clock::now() >= end)
            throw Error(ErrorCode::Locked,
                        "another request is still writing to this upload: try again");
    }
    auto holder = std::make_shared<Holder>(Holder{state_, upload_id, std::move(stop), {}});
    state_->holders.emplace(std::move(upload_id), holder);
    co_return holder;
}

}  // namespace divemesh::api
