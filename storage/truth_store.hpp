#pragma once

#include <optional>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/truth_file.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// What a finished upload becomes truth with.
struct NewTruth {
    std::string upload_id;
    std::string project;
    std::string dive_id;
    TruthKind kind = TruthKind::GroundTruth;
    std::string name;
    std::string sha256;
    std::int64_t size_bytes = 0;
    std::string blob;
};

struct CreatedTruth {
    TruthFile file;
    bool existed = false;  // the dive had these bytes already: that file is the answer
};

inline constexpr std::int64_t kMaxTruthOfDive = 1000;

// The truth_files table. A file goes in two steps, as a dive does: removed, nobody finds it any
// more; once its blob is gone its row is forgotten. Till then its bytes count.
class TruthStore {
public:
    explicit TruthStore(Catalog& catalog) : catalog_(catalog) {}

    // One transaction: the file, its upload bound to it, the event dive.truth_added. Asked twice
    // for one upload it answers the first file. One that was unreadable is tried anew when it is
    // sent again. Throws Error{NotFound} for a dive of another
    // project, Error{Conflict} for one that is deleted or refused, Error{TooMany}.
    CreatedTruth create(const NewTruth& request);
    std::vector<TruthFile> list(const std::string& dive_id);              // oldest first
    TruthFile get(const std::string& dive_id, const std::string& id);     // throws Error{NotFound}
    TruthFile remove(const std::string& dive_id, const std::string& id);  // the same
    std::vector<TruthFile> removed(int limit);
    void forget(const std::string& id);  // after its blob

private:
    Catalog& catalog_;
};

// Inside a transaction; without those that were removed.
std::vector<TruthFile> truth_of_dive(soci::session& session, const std::string& dive_id);
std::optional<TruthFile> find_truth(soci::session& session, const std::string& id);
// Why a file cannot be read, with the event dive.truth_unreadable.
void mark_unreadable(soci::session& session, const std::string& id, const std::string& problem);

}  // namespace divemesh::storage
