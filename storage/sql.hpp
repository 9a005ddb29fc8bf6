#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <soci/soci.h>
#include <string>
#include <utility>
#include <vector>

#include "storage/fault_point.hpp"

// What the stores say to SOCI. A Row is a struct with define(statement), which binds its members to
// the columns, and value(), which makes the domain type of them.
namespace divemesh::storage {

// Every row of the query. `uses` are soci::use(variable, "name").
template <typename Row, typename... Uses>
auto select_all(soci::session& session, const std::string& sql, const Uses&... uses) {
    fault_point();
    Row row;
    soci::statement statement(session);
    row.define(statement);
    (statement.exchange(uses), ...);
    statement.alloc();
    statement.prepare(sql);
    statement.define_and_bind();
    statement.execute(false);
    std::vector<decltype(row.value())> values;
    while (statement.fetch()) values.push_back(row.value());
    return values;
}

// The first row, or nothing.
template <typename Row, typename... Uses>
auto select_one(soci::session& session, const std::string& sql, const Uses&... uses) {
    auto values = select_all<Row>(session, sql, uses...);
    using Value = typename decltype(values)::value_type;
    return values.empty() ? std::optional<Value>()
                          : std::optional<Value>(std::move(values.front()));
}

// Runs a statement without rows; how many rows it changed.
template <typename... Uses>
long long execute(soci::session& session, const std::string& sql, const Uses&... uses) {
    fault_point();
    soci::statement statement(session);
    (statement.exchange(uses), ...);
    statement.alloc();
    statement.prepare(sql);
    statement.define_and_bind();
    statement.execute(true);
    return statement.get_affected_rows();
}

// A row of one text column.
struct TextRow {
    std::string text;
    void define(soci::statement& statement) { statement.exchange(soci::into(text)); }
    std::string value() const { return text; }
};

// JSON as stored: text of a recording may be any bytes, what is not UTF-8 is replaced.
inline std::string to_text(const nlohmann::json& json) {
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace divemesh::storage
