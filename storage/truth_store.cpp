#include "storage/truth_store.hpp"

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/event_store.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxProblemBytes = 1000;

const std::string kSelect =
    "SELECT id, project, dive_id, kind, name, sha256, size_bytes, blob, created_at_ms, problem"
    " FROM truth_files WHERE ";

struct TruthRow {
    TruthFile file;
    std::string kind;

    void define(soci::statement& statement) {
        define_columns(statement,
                       file.id,
                       file.project,
                       file.dive_id,
                       kind,
                       file.name,
                       file.sha256,
                       file.size_bytes,
                       file.blob,
                       file.created_at_ms,
                       file.problem);
    }
    TruthFile value() const {
        TruthFile value = file;
        value.kind = truth_kind_from_string(kind);
        return value;
    }
};

TruthFile read_truth(soci::session& session, const std::string& dive_id, const std::string& id) {
    auto file = find_truth(session, id);
    if (!file || file->dive_id != dive_id)
        throw Error(ErrorCode::NotFound, "dive " + dive_id + " has no truth file " + id);
    return std::move(*file);
}

// Returns "" if it is not yet truth.
std::string truth_of_upload(soci::session& session, const std::string& upload_id) {
    const auto id =
        select_one<TextRow>(session,
                            "SELECT truth_id FROM uploads WHERE id = :id AND ended = ''",
                            soci::use(upload_id, "id"));
    if (!id) throw Error(ErrorCode::NotFound, "no upload " + upload_id);
    return *id;
}

std::optional<TruthFile> find_same(soci::session& session, const NewTruth& request) {
    const std::string kind(to_string(request.kind));
    return select_one<TruthRow>(
        session,
        kSelect + "dive_id = :dive AND kind = :kind AND sha256 = :sha256 AND deleted_at_ms = 0",
        soci::use(request.dive_id, "dive"),
        soci::use(kind, "kind"),
        soci::use(request.sha256, "sha256"));
}

void require_dive(soci::session& session, const NewTruth& request) {
    const Dive dive = read_dive(session, request.dive_id);
    if (dive.project != request.project)
        throw Error(ErrorCode::NotFound, "no dive " + request.dive_id);
    require_usable(dive);
    std::int64_t count = 0;
    session << "SELECT COUNT(*) FROM truth_files WHERE dive_id = :dive", soci::into(count),
        soci::use(request.dive_id, "dive");
    if (count >= kMaxTruthOfDive)
        throw Error(ErrorCode::TooMany,
                    "dive " + request.dive_id + " has " + std::to_string(kMaxTruthOfDive) +
                        " truth files: delete some");
}

void append_truth_event(soci::session& session, const TruthFile& file, const std::string& type) {
    EventStore::append(session,
                       {.project = file.project,
                        .topic = "dive",
                        .subject = file.dive_id,
                        .type = type,
                        .data = file});
}

TruthFile tried_anew(soci::session& session, TruthFile file) {
    if (file.problem.empty()) return file;
    execute(
        session, "UPDATE truth_files SET problem = '' WHERE id = :id", soci::use(file.id, "id"));
    file.problem.clear();
    return file;
}

TruthFile insert_truth(soci::session& session, const NewTruth& request) {
    TruthFile file{.id = new_id("truth"),
                   .project = request.project,
                   .dive_id = request.dive_id,
                   .kind = request.kind,
                   .name = request.name,
                   .sha256 = request.sha256,
                   .size_bytes = request.size_bytes,
                   .blob = request.blob,
                   .created_at_ms = Catalog::now_ms(session)};
    const std::string kind(to_string(file.kind));
    execute(session,
            "INSERT INTO truth_files (id, project, dive_id, kind, name, sha256, size_bytes, blob,"
            " created_at_ms)"
            " VALUES (:id, :project, :dive, :kind, :name, :sha256, :bytes, :blob, :now)",
            soci::use(file.id, "id"),
            soci::use(file.project, "project"),
            soci::use(file.dive_id, "dive"),
            soci::use(kind, "kind"),
            soci::use(file.name, "name"),
            soci::use(file.sha256, "sha256"),
            soci::use(file.size_bytes, "bytes"),
            soci::use(file.blob, "blob"),
            soci::use(file.created_at_ms, "now"));
    append_truth_event(session, file, "dive.truth_added");
    return file;
}

}  // namespace

std::vector<TruthFile> truth_of_dive(soci::session& session, const std::string& dive_id) {
    return select_all<TruthRow>(
        session,
        kSelect + "dive_id = :dive AND deleted_at_ms = 0 ORDER BY created_at_ms, id",
        soci::use(dive_id, "dive"));
}

std::optional<TruthFile> find_truth(soci::session& session, const std::string& id) {
    return select_one<TruthRow>(
        session, kSelect + "id = :id AND deleted_at_ms = 0", soci::use(id, "id"));
}

void mark_unreadable(soci::session& session, const std::string& id, const std::string& problem) {
    const std::string kept = problem.substr(0, kMaxProblemBytes);
    execute(session,
            "UPDATE truth_files SET problem = :problem WHERE id = :id AND deleted_at_ms = 0",
            soci::use(kept, "problem"),
            soci::use(id, "id"));
    if (const auto file = find_truth(session, id))
        append_truth_event(session, *file, "dive.truth_unreadable");
}

CreatedTruth TruthStore::create(const NewTruth& request) {
    CreatedTruth created;
    catalog_.transaction([&](soci::session& session) {
        const std::string bound = truth_of_upload(session, request.upload_id);
        if (!bound.empty()) {
            created.file = read_truth(session, request.dive_id, bound);
            created.existed = created.file.blob != request.blob;
            return;
        }
        require_dive(session, request);
        auto same = find_same(session, request);
        created.existed = same.has_value();
        created.file = same ? tried_anew(session, *same) : insert_truth(session, request);
        execute(session,
                "UPDATE uploads SET dive_id = :dive, truth_id = :truth WHERE id = :id",
                soci::use(request.dive_id, "dive"),
                soci::use(created.file.id, "truth"),
                soci::use(request.upload_id, "id"));
    });
    return created;
}

std::vector<TruthFile> TruthStore::list(const std::string& dive_id) {
    std::vector<TruthFile> files;
    catalog_.read([&](soci::session& session) { files = truth_of_dive(session, dive_id); });
    return files;
}

TruthFile TruthStore::get(const std::string& dive_id, const std::string& id) {
    TruthFile file;
    catalog_.read([&](soci::session& session) { file = read_truth(session, dive_id, id); });
    return file;
}

TruthFile TruthStore::remove(const std::string& dive_id, const std::string& id) {
    TruthFile file;
    catalog_.transaction([&](soci::session& session) {
        file = read_truth(session, dive_id, id);
        const std::int64_t now_ms = Catalog::now_ms(session);
        execute(session,
                "UPDATE truth_files SET deleted_at_ms = :now WHERE id = :id",
                soci::use(now_ms, "now"),
                soci::use(id, "id"));
        append_truth_event(session, file, "dive.truth_removed");
    });
    return file;
}

std::vector<TruthFile> TruthStore::removed(int limit) {
    std::vector<TruthFile> files;
    catalog_.read([&](soci::session& session) {
        files =
            select_all<TruthRow>(session,
                                 kSelect + "deleted_at_ms > 0 ORDER BY deleted_at_ms LIMIT :limit",
                                 soci::use(limit, "limit"));
    });
    return files;
}

void TruthStore::forget(const std::string& id) {
    catalog_.transaction([&](soci::session& session) {
        execute(session,
                "DELETE FROM truth_files WHERE id = :id AND deleted_at_ms > 0",
                soci::use(id, "id"));
    });
}

}  // namespace divemesh::storage
