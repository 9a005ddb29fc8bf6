#include "api/sensors/report_queue.hpp"

#include <algorithm>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <iterator>
#include <memory>
#include <utility>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

namespace asio = boost::asio;

constexpr std::size_t kMaxWaiting = 2000;
// Keep a transaction short, because others write to the catalog too.
constexpr std::size_t kMaxTogether = 200;
constexpr std::size_t kMaxMessagesTogether = 2000;
constexpr std::size_t kMaxWaitingBytes = std::size_t{48} << 20;
constexpr std::size_t kMaxBytesTogether = std::size_t{8} << 20;

std::size_t image_bytes(const SensorReport& report) {
    std::size_t num_bytes = 0;
    for (const SensorMessage& message : report.messages) num_bytes += message.jpeg.size();
    return num_bytes;
}

}  // namespace

asio::awaitable<SensorAnswer> ReportQueue::submit(storage::IncomingReport report) {
    const auto executor = co_await asio::this_coro::executor;
    auto initiate = [this, executor, &report](auto handler) {
        const auto shared = std::make_shared<decltype(handler)>(std::move(handler));
        enqueue(std::move(report),
                [executor, shared](std::exception_ptr failure, SensorAnswer answer) {
                    asio::post(executor, [shared, failure, answer = std::move(answer)]() mutable {
                        std::move (*shared)(failure, std::move(answer));
                    });
                });
    };
    co_return co_await asio::async_initiate<const asio::use_awaitable_t<>&,
                                            void(std::exception_ptr, SensorAnswer)>(
        std::move(initiate), asio::use_awaitable);
}

void ReportQueue::enqueue(storage::IncomingReport report, Done done) {
    const std::size_t num_bytes = image_bytes(report.report);
    const std::unique_lock lock(mutex_);
    if (waiting_.size() >= kMaxWaiting || waiting_bytes_ + num_bytes > kMaxWaitingBytes)
        return done(std::make_exception_ptr(
                        Error(ErrorCode::Unavailable,
                              "more sensor reports arrive than can be written: try again later")),
                    {});
    waiting_bytes_ += num_bytes;
    waiting_.push_back({std::move(report), std::move(done), num_bytes});
    if (std::exchange(committing_, true)) return;
    asio::post(pool_, [this] { commit_all(); });
}

std::vector<ReportQueue::Waiting> ReportQueue::take_some() {
    const std::lock_guard lock(mutex_);
    std::size_t num = 0;
    std::size_t num_messages = 0;
    std::size_t num_bytes = 0;
    for (; num < std::min(waiting_.size(), kMaxTogether); ++num) {
        const Waiting& next = waiting_[num];
        const bool fits =
            num_messages + next.report.report.messages.size() <= kMaxMessagesTogether &&
            num_bytes + next.num_bytes <= kMaxBytesTogether;
        if (num > 0 && !fits) break;
        num_messages += next.report.report.messages.size();
        num_bytes += next.num_bytes;
    }
    waiting_bytes_ -= num_bytes;
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(num);
    std::vector<Waiting> some(std::make_move_iterator(waiting_.begin()),
                              std::make_move_iterator(end));
    waiting_.erase(waiting_.begin(), end);
    committing_ = !some.empty();
    return some;
}

void ReportQueue::commit_all() {
    for (auto some = take_some(); !some.empty(); some = take_some()) commit(std::move(some));
}

void ReportQueue::commit(std::vector<Waiting> group) {
    std::vector<storage::IncomingReport> reports;
    reports.reserve(group.size());
    for (Waiting& waiting : group) reports.push_back(std::move(waiting.report));
    std::vector<storage::ReportOutcome> outcomes;
    std::exception_ptr failure;
    try {
        outcomes = storage::SensorStore(catalog_).receive(
            reports, has_room_() ? storage::kMaxPreviews : storage::kMaxPreviewsWhenFull);
    } catch (...) {
        failure = std::current_exception();
    }
    for (std::size_t i = 0; i < group.size(); ++i) {
        if (!failure && !outcomes[i].failure) sensor_hub_.publish(outcomes[i].sensor);
        if (failure)
            group[i].done(failure, {});
        else if (outcomes[i].failure)
            group[i].done(std::make_exception_ptr(*outcomes[i].failure), {});
        else
            group[i].done(nullptr, std::move(outcomes[i].answer));
    }
}

}  // namespace divemesh::api
