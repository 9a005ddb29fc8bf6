#pragma once

#include <boost/asio/awaitable.hpp>
#include <memory>

#include "api/http.hpp"
#include "server/connection.hpp"
#include "server/request_body.hpp"
#include "server/session_context.hpp"

namespace divemesh::server {

// Answers the request with a WebSocket for a sensor's stream (docs/sensors.md). A report is
// answered when it is durable; commands are sent to the sensor. Reports that arrive during a write
// are written together; if more arrive than fit, reading pauses until then. Ends with code 1001
// when the connection is stopped, 1008 when the token is no longer valid, 1013 when reports cannot
// be written now, 4409 when the sensor has opened another stream.
boost::asio::awaitable<void> hear_sensor(std::shared_ptr<Connection> connection,
                                         std::shared_ptr<RequestBody> request_body,
                                         api::Request request,
                                         api::SensorStream stream,
                                         SessionContext context);

}  // namespace divemesh::server
