#pragma once

#include <map>
#include <memory>
#include <soci/soci.h>
#include <string>
#include <typeindex>
#include <utility>

#include "storage/dialect.hpp"

namespace divemesh::storage {

// A connection with its prepared statements. Every session that a store sees is one.
class Session : public soci::session {
public:
    Session(const Dialect& dialect,
            const soci::backend_factory& factory,
            const std::string& connection)
        : soci::session(factory, connection), dialect_(dialect) {}

    const Dialect& dialect() const { return dialect_; }

    // Returns the same object for the same type and text, as long as the connection lives.
    // `Prepared` is made from (session, sql).
    template <typename Prepared>
    Prepared& prepared(const std::string& sql) {
        std::shared_ptr<void>& kept = statements_[{typeid(Prepared), sql}];
        if (!kept) kept = std::make_shared<Prepared>(*this, sql);
        return *static_cast<Prepared*>(kept.get());
    }

private:
    const Dialect& dialect_;
    // Destroyed before the connection.
    std::map<std::pair<std::type_index, std::string>, std::shared_ptr<void>> statements_;
};

inline const Dialect& dialect_of(const soci::session& session) {
    return static_cast<const Session&>(session).dialect();
}

}  // namespace divemesh::storage
