#include "server/resolve.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "schemas/error.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

// The thread's result. It may outlive the caller and the server, so it refers to no other object.
struct Answer {
    std::mutex mutex;
    bool wanted = true;
    std::optional<Addresses> found;
    std::exception_ptr failure;
};

// The caller, while it waits: its executor is then alive, too.
class Asking {
public:
    explicit Asking(std::shared_ptr<Answer> answer) : answer_(std::move(answer)) {}
    ~Asking() {
        const std::lock_guard lock(answer_->mutex);
        answer_->wanted = false;
    }
    Asking(const Asking&) = delete;
    Asking& operator=(const Asking&) = delete;

private:
    std::shared_ptr<Answer> answer_;
};

}  // namespace

Addresses look_up(const std::string& host, const std::string& port) {
    asio::io_context context;
    tcp::resolver resolver(context);
    Addresses addresses;
    for (const auto& entry : resolver.resolve(host, port)) addresses.push_back(entry.endpoint());
    return addresses;
}

asio::awaitable<Addresses> resolve_within(std::string host,
                                          std::string port,
                                          std::chrono::milliseconds timeout,
                                          Lookup lookup) {
    asio::steady_timer timer(co_await asio::this_coro::executor, timeout);
    const auto answer = std::make_shared<Answer>();
    const Asking asking(answer);
    std::thread([answer, &timer, host, port, lookup = std::move(lookup)] {
        std::optional<Addresses> found;
        std::exception_ptr failure;
        try {
            found = lookup(host, port);
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard lock(answer->mutex);
        answer->found = std::move(found);
        answer->failure = failure;
        if (!answer->wanted) return;
        asio::post(timer.get_executor(), [answer, &timer] {
            if (answer->wanted) timer.cancel();
        });
    }).detach();
    boost::system::error_code cancelled;
    co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
    std::optional<Addresses> found;
    std::exception_ptr failure;
    {
        const std::lock_guard lock(answer->mutex);
        found = std::move(answer->found);
        failure = answer->failure;
    }
    if (failure) std::rethrow_exception(failure);
    if (!found)
        throw Error(ErrorCode::Unavailable, "the name " + host + " could not be resolved in time");
    co_return *found;
}

}  // namespace divemesh::server
