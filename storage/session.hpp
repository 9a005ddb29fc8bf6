#pragma once

#include <map>
#include <memory>
#include <soci/soci.h>
#include <string>

namespace divemesh::storage {

// A connection with its prepared statements. Every session that a store sees is one.
class Session : public soci::session {
public:
    using soci::session::session;

    // Returns the same object for the same text, as long as the connection lives. `Prepared` is
    // made from (session, sql).
    template <typename Prepared>
    Prepared& prepared(const std::string& sql) {
        std::shared_ptr<void>& kept = statements_[sql];
        if (!kept) kept = std::make_shared<Prepared>(*this, sql);
        return *static_cast<Prepared*>(kept.get());
    }

private:
    std::map<std::string, std::shared_ptr<void>> statements_;  // destroyed before the connection
};

}  // namespace divemesh::storage
