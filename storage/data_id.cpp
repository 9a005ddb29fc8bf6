#include "storage/data_id.hpp"

#include <soci/soci.h>
#include <string>

#include "schemas/error.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr int kIdBytes = 16;

// What the catalog knows. An id that is not confirmed may not be in the blob store yet.
struct DataId {
    std::string id;
    bool confirmed = false;
};

struct DataIdRow {
    std::string id;
    int confirmed = 0;

    void define(soci::statement& statement) { define_columns(statement, id, confirmed); }
    DataId value() const { return {id, confirmed != 0}; }
};

DataId id_in(soci::session& session) {
    return select_one<DataIdRow>(session, "SELECT id, confirmed FROM data_id").value_or(DataId{});
}

DataId id_in(Catalog& catalog) {
    DataId id;
    catalog.read([&](soci::session& session) { id = id_in(session); });
    return id;
}

void write_id(soci::session& session, const std::string& id, bool is_confirmed) {
    const int confirmed = is_confirmed ? 1 : 0;
    execute(session, "DELETE FROM data_id");
    execute(session,
            "INSERT INTO data_id (id, confirmed) VALUES (:id, :confirmed)",
            soci::use(id, "id"),
            soci::use(confirmed, "confirmed"));
}

// Returns what is wrong with a blob store that has `found` in place of the catalog's id.
std::string difference(const BlobStore& blobs, const std::string& known, const std::string& found) {
    const std::string what = found.empty()
                                 ? " has no id of a data folder: its disk may not be mounted"
                                 : " belongs to another catalog (its id is " + found + ")";
    const std::string otherwise =
        known.empty() ? ""
                      : "; if these are its blobs, moved without the file data-id, write " + known +
                            " into that file beside them";
    return "the blob store " + blobs.location() + what +
           "; mount its disk, or give the --blobs that belong to this catalog" + otherwise;
}

std::string newest_blob(Catalog& catalog) {
    std::string blob;
    catalog.read([&](soci::session& session) {
        blob = select_one<TextRow>(session,
                                   "SELECT blob FROM dives WHERE deleted_at_ms = 0"
                                   " ORDER BY created_at_ms DESC, id DESC LIMIT 1")
                   .value_or("");
    });
    return blob;
}

// Returns whether a catalog of an earlier version, restored as a file, is beside its own blobs,
// which have got their id since.
bool is_older_catalog_of(Catalog& catalog, BlobStore& blobs) {
    const std::string blob = newest_blob(catalog);
    return !blob.empty() && blobs.exists(blob);
}

// Checks that data without an id have their blobs, before the two are declared to belong together.
void require_a_blob(Catalog& catalog, BlobStore& blobs) {
    const std::string blob = newest_blob(catalog);
    if (!blob.empty() && !blobs.exists(blob))
        throw Error(ErrorCode::Conflict,
                    "the blob store " + blobs.location() + " lacks " + blob +
                        ", the newest dive of this catalog: mount its disk, or give the --blobs "
                        "that belong to this catalog");
}

}  // namespace

bool has_data_id(Catalog& catalog) { return id_in(catalog).confirmed; }

std::string data_id(Catalog& catalog) { return id_in(catalog).id; }

void claim_data(Catalog& catalog, BlobStore& blobs) {
    const DataId known = id_in(catalog);
    const std::string found = blobs.data_id();
    const bool is_older = known.id.empty() && !found.empty() && is_older_catalog_of(catalog, blobs);
    const bool differs = known.confirmed ? found != known.id : !found.empty() && found != known.id;
    if (differs && !is_older) throw Error(ErrorCode::Conflict, difference(blobs, known.id, found));
    if (known.confirmed) return;
    if (found.empty()) require_a_blob(catalog, blobs);
    // In this order, so that a server that is killed in between can go on.
    std::string id;
    catalog.transaction([&](soci::session& session) {
        id = id_in(session).id;
        if (id.empty()) id = found.empty() ? random_hex(kIdBytes) : found;
        write_id(session, id, false);
    });
    blobs.set_data_id(id);
    catalog.transaction([&](soci::session& session) { write_id(session, id, true); });
}

std::string data_mismatch(Catalog& catalog, BlobStore& blobs) {
    const DataId known = id_in(catalog);
    std::string found;
    try {
        found = blobs.data_id();
    } catch (const Error& error) {
        return "the blob store " + blobs.location() + " cannot be read: " + error.what();
    }
    const bool same = found == known.id || (!known.confirmed && found.empty());
    return same ? "" : difference(blobs, known.id, found);
}

void require_same_data(Catalog& catalog, BlobStore& blobs) {
    const std::string mismatch = data_mismatch(catalog, blobs);
    if (!mismatch.empty()) throw Error(ErrorCode::Unavailable, mismatch);
}

void adopt_blobs(Catalog& catalog, BlobStore& blobs) {
    std::string id = blobs.data_id();
    if (id.empty()) {
        id = random_hex(kIdBytes);
        blobs.set_data_id(id);
    }
    catalog.transaction([&](soci::session& session) { write_id(session, id, true); });
}

}  // namespace divemesh::storage
