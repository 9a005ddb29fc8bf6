#include "server/log.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace divemesh::server {
namespace {

std::string text_of(const nlohmann::json& fields) {
    return fields.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void start_log() {
    auto logger = std::make_shared<spdlog::logger>(
        "server", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    logger->set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l","data":%v})",
                        spdlog::pattern_time_type::utc);
    logger->flush_on(spdlog::level::info);
    spdlog::set_default_logger(std::move(logger));
}

void log_info(const nlohmann::json& fields) { spdlog::info("{}", text_of(fields)); }
void log_warning(const nlohmann::json& fields) { spdlog::warn("{}", text_of(fields)); }

}  // namespace divemesh::server
