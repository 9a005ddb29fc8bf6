#include "api/handlers/events.hpp"

#include <boost/beast/core/string.hpp>

#include "api/authorization.hpp"
#include "api/error_response.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/target.hpp"
#include "storage/event_store.hpp"

namespace divemesh::api {
namespace {

// After a restored backup a client may have seen more than there is, after a long time less: it
// would be told nothing, or not all, without a word. Since 0 is from the oldest that there is.
void require_known(storage::EventStore events, std::int64_t since) {
    if (since > events.newest_sequence())
        throw Error(ErrorCode::Gone,
                    "there is no such event yet, the catalog was put back since: read the lists "
                    "and connect without since");
    if (since > 0 && since + 1 < events.oldest_sequence())
        throw Error(ErrorCode::Gone,
                    "events after that one were removed with age: read the lists and connect "
                    "without since");
}

}  // namespace

Awaitable<Response> watch_events(Request request, Services services) {
    if (!boost::beast::iequals(request.header("upgrade"), "websocket")) {
        Response response = problem_response(
            request, http::status::upgrade_required, "events come over a WebSocket: ask for one");
        response.set("Upgrade", "websocket");
        co_return response;
    }
    EventFeed feed{0, visible_project(request.token), request.token.id};
    if (request.query.contains("since")) {
        const auto since = parse_count(query_value(request, "since"));
        if (!since)
            throw Error(ErrorCode::InvalidArgument, "since has to be the sequence of an event");
        feed.since = *since;
        auto check = [&catalog = services.catalog, since = *since] {
            require_known(storage::EventStore(catalog), since);
        };
        co_await in_pool(services.pool, std::move(check));
    } else {
        auto newest = [&catalog = services.catalog] {
            return storage::EventStore(catalog).newest_sequence();
        };
        feed.since = co_await in_pool(services.pool, std::move(newest));
    }
    Response response = empty_response(http::status::switching_protocols);
    response.body = feed;
    co_return response;
}

}  // namespace divemesh::api
