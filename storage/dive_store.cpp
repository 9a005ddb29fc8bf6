#include "storage/dive_store.hpp"

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/ids.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/page_cursor.hpp"
#include "storage/project_usage.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

// Returns "" if it is not yet a dive.
std::string dive_of_upload(soci::session& session, const std::string& upload_id) {
    const auto dive_id = select_one<TextRow>(
        session,
        "SELECT COALESCE(dive_id, '') FROM uploads WHERE id = :id AND ended = ''",
        soci::use(upload_id, "id"));
    if (!dive_id) throw Error(ErrorCode::NotFound, "no upload " + upload_id);
    return *dive_id;
}

// Returns the dive of an upload. Throws if it was deleted, because a new commit must not return it.
Dive read_bound_dive(soci::session& session,
                     const std::string& upload_id,
                     const std::string& dive_id) {
    Dive dive = read_dive(session, dive_id);
    if (dive.deleted_at_ms > 0)
        throw Error(ErrorCode::Gone,
                    "upload " + upload_id + " became dive " + dive_id +
                        ", which was deleted: restore it, or start a new upload");
    return dive;
}

void bind_upload(soci::session& session, const std::string& upload_id, const std::string& dive_id) {
    execute(session,
            "UPDATE uploads SET dive_id = :dive WHERE id = :id",
            soci::use(dive_id, "dive"),
            soci::use(upload_id, "id"));
}

Dive insert_dive(soci::session& session, const NewDive& request) {
    Dive dive{.id = new_id("dive"),
              .project = request.project,
              .name = request.name,
              .archive_sha256 = request.archive_sha256,
              .content_sha256 = request.content_sha256,
              .archive_bytes = request.archive_bytes,
              .blob = request.blob,
              .created_at_ms = Catalog::now_ms(session)};
    execute(session,
            "INSERT INTO dives (id, project, name, archive_sha256, content_sha256, archive_bytes,"
            " blob, created_at_ms)"
            " VALUES (:id, :project, :name, :archive, :content, :bytes, :blob, :now)",
            soci::use(dive.id, "id"),
            soci::use(dive.project, "project"),
            soci::use(dive.name, "name"),
            soci::use(dive.archive_sha256, "archive"),
            soci::use(dive.content_sha256, "content"),
            soci::use(dive.archive_bytes, "bytes"),
            soci::use(dive.blob, "blob"),
            soci::use(dive.created_at_ms, "now"));
    append_dive_event(session, dive, "dive.created");
    insert_job(session,
               {.project = dive.project,
                .dive_id = dive.id,
                .kind = JobKind::Intake,
                .priority = kIntakePriority});
    return dive;
}

// Returns the dive with the merge patch applied. A value that is the recording's own is no edit.
Dive edited(const Dive& dive, const nlohmann::json& patch) {
    nlohmann::json shown = dive;
    nlohmann::json& recorded = shown["recorded"];
    for (const auto& [name, value] : patch.items()) {
        const nlohmann::json own = recorded.value(name, shown[name]);
        const bool is_own = value.is_null() || value == own;
        recorded[name] = own;
        shown[name] = is_own ? own : value;
        if (is_own) recorded.erase(name);
    }
    Dive changed = shown.get<Dive>();
    changed.blob = dive.blob;
    return changed;
}

// Returns the reconstruction requested with the upload. An existing one will do, unless it did not
// succeed.
std::string ensure_reconstruction(soci::session& session,
                                  const Dive& dive,
                                  const std::string& preset) {
    const auto there = select_one<TextRow>(
        session,
        "SELECT id FROM jobs WHERE dive_id = :dive AND kind = 'reconstruct' AND preset = :preset"
        " AND options = '{}' AND state IN ('held', 'queued', 'running', 'succeeded')"
        " AND deleted_at_ms = 0"
        " ORDER BY created_at_ms, id LIMIT 1",
        soci::use(dive.id, "dive"),
        soci::use(preset, "preset"));
    if (there) return *there;
    return insert_job(session, {.project = dive.project, .dive_id = dive.id, .preset = preset}).id;
}

}  // namespace

CreatedDive DiveStore::create(const NewDive& request) {
    CreatedDive created;
    catalog_.transaction([&](soci::session& session) {
        const std::string bound = dive_of_upload(session, request.upload_id);
        auto known =
            bound.empty()
                ? find_recording(
                      session, request.project, request.archive_sha256, request.content_sha256)
                : std::optional<Dive>(read_bound_dive(session, request.upload_id, bound));
        if (!known)
            require_dive_of_quota(session,
                                  request.project,
                                  request.max_dives_of_project,
                                  "the upload is kept: delete a dive and commit it again");
        created.existed = known && known->blob != request.blob;
        created.dive = known ? std::move(*known) : insert_dive(session, request);
        if (bound.empty()) bind_upload(session, request.upload_id, created.dive.id);
        if (!request.preset.empty() && created.dive.state != DiveState::Refused)
            created.job_id = ensure_reconstruction(session, created.dive, request.preset);
    });
    return created;
}

Dive DiveStore::get(const std::string& id) {
    Dive dive;
    catalog_.read([&](soci::session& session) { dive = read_dive(session, id); });
    return dive;
}

Page<Dive> DiveStore::list(const DiveFilter& filter, const PageRequest& page) {
    const PageStart start = page_start(page);
    const std::string state = filter.state ? std::string(to_string(*filter.state)) : "";
    const int deleted = filter.deleted ? 1 : 0;
    std::vector<Dive> rows;
    catalog_.read([&](soci::session& session) {
        rows = select_all<DiveRow>(
            session,
            "SELECT " + std::string(kDiveColumns) + " FROM dives WHERE " + start.condition +
                " AND (:project = '' OR project = :project)"
                " AND (:content = '' OR content_sha256 = :content)"
                " AND (:archive = '' OR archive_sha256 = :archive)"
                " AND (:site = '' OR site = :site) AND (:state = '' OR state = :state)"
                " AND created_at_ms > :after AND created_at_ms < :before"
                " AND (:tag = '' OR id IN (SELECT dive_id FROM dive_tags WHERE tag = :tag))"
                " AND (deleted_at_ms > 0) = (:deleted = 1)"
                " ORDER BY " +
                start.order + " LIMIT :limit",
            soci::use(start.created_at_ms, "age"),
            soci::use(start.id, "id"),
            soci::use(filter.project, "project"),
            soci::use(filter.content_sha256, "content"),
            soci::use(filter.archive_sha256, "archive"),
            soci::use(filter.site, "site"),
            soci::use(state, "state"),
            soci::use(filter.created_after_ms, "after"),
            soci::use(filter.created_before_ms, "before"),
            soci::use(filter.tag, "tag"),
            soci::use(deleted, "deleted"),
            soci::use(start.limit_plus_one, "limit"));
    });
    return make_page(std::move(rows), page);
}

std::vector<Finding> DiveStore::findings(const std::string& id) {
    std::vector<Finding> findings;
    catalog_.read([&](soci::session& session) {
        const auto text = select_one<TextRow>(
            session, "SELECT findings FROM dives WHERE id = :id", soci::use(id, "id"));
        if (!text) throw Error(ErrorCode::NotFound, "no dive " + id);
        findings = nlohmann::json::parse(*text).get<std::vector<Finding>>();
    });
    return findings;
}

Dive DiveStore::edit(const std::string& id, const nlohmann::json& patch) {
    Dive dive;
    catalog_.transaction([&](soci::session& session) {
        dive = read_dive(session, id);
        if (dive.deleted_at_ms > 0)
            throw Error(ErrorCode::Conflict, "dive " + id + " is deleted: restore it first");
        if (dive.state == DiveState::Checking)
            throw Error(ErrorCode::Conflict,
                        "dive " + id + " is being checked: edit it once it is ready or refused");
        dive = edited(dive, patch);
        write_description(session, dive);
        append_dive_event(session, dive, "dive.edited");
    });
    return dive;
}

std::string DiveStore::thumbnail_blob(const std::string& id) {
    std::string blob;
    catalog_.read([&](soci::session& session) {
        const auto text = select_one<TextRow>(
            session, "SELECT thumbnail_blob FROM dives WHERE id = :id", soci::use(id, "id"));
        if (!text) throw Error(ErrorCode::NotFound, "no dive " + id);
        if (text->empty()) throw Error(ErrorCode::NotFound, "dive " + id + " has no thumbnail");
        blob = *text;
    });
    return blob;
}

}  // namespace divemesh::storage
