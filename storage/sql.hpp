#pragma once

#include <cstdint>
#include <list>
#include <nlohmann/json.hpp>
#include <optional>
#include <soci/soci.h>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "storage/fault_point.hpp"
#include "storage/session.hpp"
#include "storage/storable_text.hpp"

// Helpers by which the stores use SOCI. A Row is a struct with define(statement), which binds its
// members to the columns, and value(), which makes the domain type of them.
namespace divemesh::storage {

// Binds the columns of a row, in their order.
template <typename... Fields>
void define_columns(soci::statement& statement, Fields&... fields) {
    (statement.exchange(soci::into(fields)), ...);
}

// Binds values to a statement, and keeps the ones that the database does not take as they are.
class Binder {
public:
    Binder(soci::session& session, soci::statement& statement)
        : takes_any_text_(dialect_of(session).text_holds_any_bytes), statement_(statement) {}

    template <typename Use>
    void bind(const Use& use) {
        if constexpr (std::is_convertible_v<decltype(use.t), const std::string&>) {
            if (auto text = takes_any_text_ ? std::nullopt : storable_text(use.t)) {
                replaced_.push_back(std::move(*text));
                return statement_.exchange(soci::use(replaced_.back(), use.name));
            }
        }
        statement_.exchange(use);
    }

private:
    bool takes_any_text_;
    soci::statement& statement_;
    std::list<std::string> replaced_;  // a list, so that they stay where they are
};

// A statement that stays prepared on its connection. Its values are bound anew each time.
struct KeptStatement {
    KeptStatement(soci::session& session, const std::string& sql) : statement(session) {
        statement.alloc();
        statement.prepare(sql);
    }

    soci::statement statement;
};

// One execution of a statement: of one that is kept, if the database gains by that.
class Execution {
public:
    Execution(soci::session& session, const std::string& sql)
        : sql_(sql),
          is_kept_(dialect_of(session).keeps_statements),
          own_(session),
          statement_(is_kept_
                         ? static_cast<Session&>(session).prepared<KeptStatement>(sql).statement
                         : own_),
          binder_(session, statement_) {}
    ~Execution() {
        if (is_kept_) statement_.bind_clean_up();
    }
    Execution(const Execution&) = delete;
    Execution& operator=(const Execution&) = delete;

    soci::statement& statement() { return statement_; }
    template <typename... Uses>
    void run(bool with_data, const Uses&... uses) {
        (binder_.bind(uses), ...);
        if (!is_kept_) {
            statement_.alloc();
            statement_.prepare(sql_, soci::details::st_one_time_query);
        }
        statement_.define_and_bind();
        statement_.execute(with_data);
    }

private:
    const std::string& sql_;
    bool is_kept_;
    soci::statement own_;
    soci::statement& statement_;
    Binder binder_;
};

// Returns every row of the query. `uses` are soci::use(variable, "name").
template <typename Row, typename... Uses>
auto select_all(soci::session& session, const std::string& sql, const Uses&... uses) {
    fault_point();
    Row row;
    Execution execution(session, sql);
    row.define(execution.statement());
    execution.run(false, uses...);
    std::vector<decltype(row.value())> values;
    while (execution.statement().fetch()) values.push_back(row.value());
    return values;
}

// Returns the first row; nullopt if there is none.
template <typename Row, typename... Uses>
auto select_one(soci::session& session, const std::string& sql, const Uses&... uses) {
    auto values = select_all<Row>(session, sql, uses...);
    using Value = typename decltype(values)::value_type;
    return values.empty() ? std::optional<Value>()
                          : std::optional<Value>(std::move(values.front()));
}

// Reads the row with this `:id` by a statement that stays prepared on its connection, for reads
// that run thousands of times a second. Each result is read to the end, so that no commit finds the
// statement under way.
template <typename Row>
class PreparedSelect {
public:
    PreparedSelect(soci::session& session, const std::string& sql)
        : takes_any_text_(dialect_of(session).text_holds_any_bytes), statement_(session) {
        row_.define(statement_);
        statement_.exchange(soci::use(id_, "id"));
        statement_.alloc();
        statement_.prepare(sql);
        statement_.define_and_bind();
    }

    auto one(const std::string& id) {
        fault_point();
        id_ = takes_any_text_ ? id : storable_text(id).value_or(id);
        std::optional<decltype(row_.value())> found;
        statement_.execute(false);
        while (statement_.fetch()) found = row_.value();
        return found;
    }

private:
    Row row_;
    bool takes_any_text_;
    std::string id_;
    soci::statement statement_;
};

// Returns the row with this id by a PreparedSelect of the session's connection; nullopt if there is
// none.
template <typename Row>
auto select_prepared(soci::session& session, const std::string& sql, const std::string& id) {
    return static_cast<Session&>(session).prepared<PreparedSelect<Row>>(sql).one(id);
}

// Runs a statement without result rows; returns how many rows it changed.
template <typename... Uses>
long long execute(soci::session& session, const std::string& sql, const Uses&... uses) {
    fault_point();
    Execution execution(session, sql);
    execution.run(true, uses...);
    return execution.statement().get_affected_rows();
}

// A row of one text column.
struct TextRow {
    std::string text;
    void define(soci::statement& statement) { statement.exchange(soci::into(text)); }
    std::string value() const { return text; }
};

// A row of one integer column.
struct NumberRow {
    std::int64_t number = 0;
    void define(soci::statement& statement) { statement.exchange(soci::into(number)); }
    std::int64_t value() const { return number; }
};

// A row of a state and a count.
struct CountRow {
    std::string state;
    std::int64_t count = 0;
    void define(soci::statement& statement) { define_columns(statement, state, count); }
    std::pair<std::string, std::int64_t> value() const { return {state, count}; }
};

// Returns JSON as stored. Text of a recording may hold any bytes, so invalid UTF-8 is replaced.
inline std::string to_text(const nlohmann::json& json) {
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace divemesh::storage
