#include "schemas/log.hpp"

#include <spdlog/spdlog.h>

namespace divemesh {
namespace {

void log(spdlog::level::level_enum level, const nlohmann::json& fields) {
    spdlog::log(level, "{}", fields.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

}  // namespace

void log_info(const nlohmann::json& fields) { log(spdlog::level::info, fields); }
void log_warning(const nlohmann::json& fields) { log(spdlog::level::warn, fields); }
void log_error(const nlohmann::json& fields) { log(spdlog::level::err, fields); }

}  // namespace divemesh
