#pragma once

#include <map>
#include <memory>
#include <soci/soci.h>
#include <string>

namespace divemesh::storage {

// A connection and the statements that are kept prepared on it. Every session that a store gets to
// see is one.
class Session : public soci::session {
public:
    using soci::session::session;

    // The same object for the same text, as long as the connection lives. `Prepared` is made from
    // (session, sql).
    template <typename Prepared>
    Prepared& prepared(const std::string& sql) {
        std::shared_ptr<void>& kept = statements_[sql];
        if (!kept) kept = std::make_shared<Prepared>(*this, sql);
        return *static_cast<Prepared*>(kept.get());
    }

private:
    std::map<std::string, std::shared_ptr<void>> statements_;  // gone before the connection is
};

}  // namespace divemesh::storage
