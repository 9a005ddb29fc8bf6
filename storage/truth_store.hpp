#pragma once

#include <optional>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/truth_file.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// What truth is created with from a finished upload.
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
    bool existed = false;  // true: the dive already had these bytes; `file` is that file
};

inline constexpr std::int64_t kMaxTruthOfDive = 1000;

// The truth_files table. A file is removed in two steps, as a dive is: a removed file is no longer
// found, and its row is forgotten once its blob is gone. Its bytes count until then.
class TruthStore {
public:
    explicit TruthStore(Catalog& catalog) : catalog_(catalog) {}

    // Creates in one transaction the file, its upload's link to it, and the event dive.truth_added.
    // For the same upload again it returns the first file. An unreadable file that is sent again is
    // tried again. Throws Error{NotFound} for a dive of another project, Error{Conflict} for one
    // that is deleted or refused, Error{TooMany}.
    CreatedTruth create(const NewTruth& request);
    std::vector<TruthFile> list(const std::string& dive_id);              // oldest first
    TruthFile get(const std::string& dive_id, const std::string& id);     // throws Error{NotFound}
    TruthFile remove(const std::string& dive_id, const std::string& id);  // throws Error{NotFound}
    std::vector<TruthFile> removed(int limit);
    void forget(const std::string& id);  // call it after removing its blob

private:
    Catalog& catalog_;
};

// Read inside a transaction, without removed files.
std::vector<TruthFile> truth_of_dive(soci::session& session, const std::string& dive_id);
std::optional<TruthFile> find_truth(soci::session& session, const std::string& id);
// Stores why a file cannot be read, with the event dive.truth_unreadable.
void mark_unreadable(soci::session& session, const std::string& id, const std::string& problem);

}  // namespace divemesh::storage
