#include "api/client/job_follower.hpp"

#include <optional>
#include <thread>

#include "api/client/event_stream.hpp"
#include "schemas/json.hpp"

namespace divemesh::api::client {
namespace {

constexpr std::chrono::seconds kPollPause{1};
constexpr std::chrono::seconds kEventTimeout{5};  // then the job is polled anyway

// Waits until the job may have changed. Uses only the subject of an event, not its content.
class Watch {
public:
    explicit Watch(const Account& account) : account_(account) {}

    void wait_for(const std::string& subject) {
        try {
            if (!stream_) stream_.emplace(account_, sequence_);
            const auto end = std::chrono::steady_clock::now() + kEventTimeout;
            while (std::chrono::steady_clock::now() < end) {
                const auto event = stream_->next(kPollPause);
                if (!event) continue;
                sequence_ = event->sequence;
                if (event->subject == subject) return;
            }
        } catch (const Error&) {
            stream_.reset();
            std::this_thread::sleep_for(kPollPause);
        }
    }

private:
    const Account& account_;
    std::optional<std::int64_t> sequence_;  // of the last event seen
    std::optional<EventStream> stream_;
};

// Polls until `done`, waiting for events in between; waits for a server that is away.
template <typename Value, typename Done>
Value follow(RestClient& rest,
             const std::string& path,
             const std::string& subject,
             const Backoff::OnWait& on_wait,
             Done&& done) {
    Backoff backoff(rest.account().give_up_after, on_wait);
    Watch watch(rest.account());
    while (true) {
        try {
            auto value = rest.get(path).template get<Value>();
            backoff.moved();
            if (done(value)) return value;
            watch.wait_for(subject);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::Unavailable) throw;
            backoff.wait(error);
        }
    }
}

}  // namespace

Job follow_job(RestClient& rest,
               const std::string& job_id,
               const OnJob& on_job,
               const Backoff::OnWait& on_wait) {
    return follow<ShownJob>(rest, job_path(job_id), job_id, on_wait, [&](const ShownJob& job) {
        on_job(job);
        return is_finished(job.state);
    });
}

Dive follow_dive(RestClient& rest, const std::string& dive_id, const Backoff::OnWait& on_wait) {
    return follow<Dive>(rest, dive_path(dive_id), dive_id, on_wait, [](const Dive& dive) {
        return dive.state != DiveState::Checking;
    });
}

}  // namespace divemesh::api::client
