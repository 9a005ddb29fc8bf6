#include "worker/worker_log.hpp"

#include <spdlog/spdlog.h>

namespace divemesh::worker {
namespace {

std::string text_of(const nlohmann::json& fields) {
    return fields.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void log_info(const nlohmann::json& fields) { spdlog::info("{}", text_of(fields)); }
void log_warning(const nlohmann::json& fields) { spdlog::warn("{}", text_of(fields)); }

}  // namespace divemesh::worker
