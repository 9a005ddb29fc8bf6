#include "storage/queue_signal.hpp"

#include <libpq-fe.h>
#include <poll.h>
#include <soci/postgresql/soci-postgresql.h>
#include <thread>

#include "schemas/error.hpp"
#include "storage/catalog_url.hpp"
#include "storage/engine.hpp"

namespace divemesh::storage {
namespace {

// A connection of its own that listens; the schema's trigger jobs_wake_workers notifies.
class PostgresqlSignal : public QueueSignal {
public:
    explicit PostgresqlSignal(const std::string& url) : engine_(make_postgresql_engine(url)) {}

    // What was queued while no connection listened is found by the poll that follows.
    void wait(std::chrono::milliseconds at_most) override {
        try {
            if (!session_) return listen();
            if (take_notices() || !is_readable(at_most)) return;
            take_notices();
        } catch (const std::exception&) {  // PostgreSQL is away: the poll says so
            session_.reset();
            std::this_thread::sleep_for(at_most);
        }
    }

private:
    PGconn* connection() const {
        return static_cast<soci::postgresql_session_backend*>(session_->get_backend())->conn_;
    }

    void listen() {
        session_ = engine_->connect();
        *session_ << "LISTEN divemesh_queue";
    }
    bool is_readable(std::chrono::milliseconds at_most) const {
        pollfd socket{.fd = PQsocket(connection()), .events = POLLIN, .revents = 0};
        return ::poll(&socket, 1, static_cast<int>(at_most.count())) > 0;
    }
    // Returns whether there were any.
    bool take_notices() {
        if (PQconsumeInput(connection()) == 0)
            throw Error(ErrorCode::Unavailable, "the connection to PostgreSQL was lost");
        bool was_any = false;
        while (PGnotify* notice = PQnotifies(connection())) {
            PQfreemem(notice);
            was_any = true;
        }
        return was_any;
    }

    std::unique_ptr<Engine> engine_;
    std::unique_ptr<Session> session_;
};

}  // namespace

std::unique_ptr<QueueSignal> listen_to_queue(const std::string& catalog_url) {
    if (!is_postgresql_url(catalog_url)) return nullptr;
    return std::make_unique<PostgresqlSignal>(catalog_url);
}

}  // namespace divemesh::storage
