#include "tests/portless_service.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <spdlog/spdlog.h>

#include "api/router.hpp"
#include "server/http_session.hpp"
#include "storage/job_store.hpp"
#include "tests/ready_dive.hpp"

namespace divemesh {
namespace {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;
constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);
constexpr std::chrono::seconds kTimeout{8};

class MemoryBody : public api::BodyStream {
public:
    explicit MemoryBody(std::string_view bytes) : rest_(bytes) {}

    std::optional<std::int64_t> length_bytes() const override { return std::ssize(rest_); }
    asio::awaitable<api::BodyRead> read(std::span<char> buffer) override {
        const std::size_t n = rest_.copy(buffer.data(), buffer.size());
        rest_.remove_prefix(n);
        using State = api::BodyRead::State;
        co_return api::BodyRead{n, rest_.empty() ? State::End : State::More};
    }
    bool has_trailer(std::string_view) const override { return false; }
    void must_end_within(std::chrono::seconds) override {}
    void stop() override {}
    void note_valid_token() override {}

private:
    std::string_view rest_;
};

// Sends everything and then nothing more.
asio::awaitable<void> say(std::shared_ptr<Local::socket> client, std::string_view sent) {
    co_await asio::async_write(*client, asio::buffer(sent), kAwaitErrors);
    boost::system::error_code ignored;
    client->shutdown(Local::socket::shutdown_send, ignored);
}

asio::awaitable<void> listen(std::shared_ptr<Local::socket> client, std::string& heard) {
    std::string piece(4096, '\0');
    for (bool open = true; open;) {
        const auto [error, n] = co_await client->async_read_some(asio::buffer(piece), kAwaitErrors);
        heard.append(piece, 0, n);
        open = !error;
    }
}

std::string make_job(storage::Catalog& catalog, const std::string& dive_id) {
    storage::NewJob wanted;
    wanted.project = "default";
    wanted.dive_id = dive_id;
    wanted.preset = "standard";
    return storage::JobStore(catalog).enqueue(wanted).job.id;
}

}  // namespace

PortlessService::PortlessService()
    : catalog_("sqlite://" + (folder_ / "catalog.db").string()),
      blobs_(storage::open_blob_store((folder_ / "blobs").string())) {
    spdlog::set_level(spdlog::level::off);
    limits_.min_free_bytes = 0;
    dive_id_ = make_ready_dive(catalog_, "default", std::string(64, '0'));
    job_id_ = make_job(catalog_, dive_id_);
}

PortlessService::~PortlessService() { pool_.join(); }

api::Services PortlessService::services() {
    return {catalog_, *blobs_,  pool_,         pool_,      locks_,    hashes_,  forecast_,
            keys_,    tokens_,  share_visits_, rates_,     rates_,    metrics_, readiness_,
            reserve_, reports_, sensor_hub_,   make_room_, stopping_, limits_,  true};
}

api::Response PortlessService::ask(api::Request request, std::string_view body) {
    request.stream = std::make_shared<MemoryBody>(body);
    request.id = "fuzz";
    api::Response answer;
    asio::co_spawn(io_,
                   api::dispatch(std::move(request), services()),
                   [&](const std::exception_ptr& failure, api::Response response) {
                       if (failure) std::rethrow_exception(failure);
                       answer = std::move(response);
                   });
    io_.restart();
    io_.run();
    return answer;
}

std::string PortlessService::converse(std::string_view sent) {
    const auto client = std::make_shared<Local::socket>(io_);
    Local::socket far_end(io_);
    asio::local::connect_pair(*client, far_end);
    asio::ip::tcp::socket socket(io_);
    socket.assign(asio::ip::tcp::v4(), far_end.release());
    const auto connection =
        std::make_shared<server::Connection>(std::move(socket), asio::ip::address(), nullptr);
    const server::SessionContext context{services(), events_, {}};
    std::string heard;
    asio::co_spawn(io_, server::run_session(connection, context), asio::detached);
    asio::co_spawn(io_, say(client, sent), asio::detached);
    asio::co_spawn(io_, listen(client, heard), asio::detached);
    io_.restart();
    io_.run_for(kTimeout);
    if (!io_.stopped()) std::abort();
    return heard;
}

}  // namespace divemesh
