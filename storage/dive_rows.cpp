#include "storage/dive_rows.hpp"

#include <algorithm>
#include <set>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "schemas/verdict.hpp"
#include "storage/event_store.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

std::string select_dive(const std::string& where) {
    return "SELECT " + std::string(kDiveColumns) + " FROM dives WHERE " + where;
}

// Returns what is wrong with the recording's identity and cannot be known to intake; otherwise
// nullopt.
std::optional<Finding> check_identity(soci::session& session,
                                      const Dive& dive,
                                      const ContentHash& content) {
    if (content.sha256.empty()) return std::nullopt;
    if (!dive.content_sha256.empty() && !content.matches(dive.content_sha256))
        return Finding{.severity = Severity::Error,
                       .code = "content_hash_mismatch",
                       .message = "the SHA-256 of the recording is " + content.sha256 +
                                  ", but its client announced " + dive.content_sha256,
                       .remedy = "check the recording on the laptop and upload it again"};
    const auto other = find_recording(session, dive.project, "", content.sha256);
    if (other && other->id != dive.id)
        return Finding{.severity = Severity::Error,
                       .code = "duplicate_dive",
                       .message = "the same recording is already here as dive " + other->id,
                       .remedy = "use dive " + other->id};
    return std::nullopt;
}

std::optional<Failure> refusal_by(const std::vector<Finding>& findings) {
    const auto error = first_error(findings);
    if (!error) return std::nullopt;
    std::string message = "the dive was refused: ";
    if (!error->where.empty()) message += error->where + ": ";
    message += error->message;
    if (!error->remedy.empty()) message += " (" + error->remedy + ")";
    return Failure{.code = ErrorCode::BadData, .message = message};
}

std::string position_text(const Dive& dive) {
    return dive.position ? to_text(*dive.position) : "null";
}

void write_intake(soci::session& session, const Dive& dive, const IntakeResult& result) {
    const std::string state(to_string(dive.state));
    const std::string tags = to_text(dive.tags);
    const std::string findings = to_text(result.findings);
    const std::string position = position_text(dive);
    execute(session,
            "UPDATE dives SET state = :state, name = :name, site = :site, rig = :rig, tags = :tags,"
            " content_sha256 = :content, num_frames = :frames, duration_s = :duration,"
            " findings = :findings, thumbnail_blob = :thumbnail, notes = :notes,"
            " position = :position WHERE id = :id",
            soci::use(state, "state"),
            soci::use(dive.name, "name"),
            soci::use(dive.site, "site"),
            soci::use(dive.rig, "rig"),
            soci::use(tags, "tags"),
            soci::use(dive.content_sha256, "content"),
            soci::use(dive.num_frames, "frames"),
            soci::use(dive.duration_s, "duration"),
            soci::use(findings, "findings"),
            soci::use(result.thumbnail_blob, "thumbnail"),
            soci::use(dive.notes, "notes"),
            soci::use(position, "position"),
            soci::use(dive.id, "id"));
}

void write_tags(soci::session& session, const Dive& dive) {
    execute(session, "DELETE FROM dive_tags WHERE dive_id = :id", soci::use(dive.id, "id"));
    const std::set<std::string> tags(dive.tags.begin(), dive.tags.end());
    for (const std::string& tag : tags)
        execute(session,
                "INSERT INTO dive_tags (dive_id, tag) VALUES (:id, :tag)",
                soci::use(dive.id, "id"),
                soci::use(tag, "tag"));
}

}  // namespace

void DiveRow::define(soci::statement& statement) {
    define_columns(statement,
                   dive.id,
                   dive.project,
                   state,
                   dive.name,
                   dive.site,
                   dive.rig,
                   tags,
                   dive.notes,
                   position,
                   recorded,
                   dive.archive_sha256,
                   dive.content_sha256,
                   dive.archive_bytes,
                   dive.blob,
                   dive.num_frames,
                   dive.duration_s,
                   has_thumbnail,
                   dive.created_at_ms,
                   dive.deleted_at_ms,
                   dive.expires_at_ms);
}

Dive DiveRow::value() const {
    Dive value = dive;
    value.state = dive_state_from_string(state);
    value.tags = nlohmann::json::parse(tags).get<std::vector<std::string>>();
    const auto place = nlohmann::json::parse(position);
    if (!place.is_null()) value.position = place.get<DivePosition>();
    value.recorded = nlohmann::json::parse(recorded);
    value.has_thumbnail = has_thumbnail != 0;
    return value;
}

Dive read_dive(soci::session& session, const std::string& id) {
    auto dive = select_one<DiveRow>(session, select_dive("id = :id"), soci::use(id, "id"));
    if (!dive) throw Error(ErrorCode::NotFound, "no dive " + id);
    return std::move(*dive);
}

void require_usable(const Dive& dive) {
    if (dive.state == DiveState::Refused)
        throw Error(
            ErrorCode::Conflict,
            "dive " + dive.id +
                " was refused: see its findings, correct the recording and upload it again");
    if (dive.deleted_at_ms > 0)
        throw Error(ErrorCode::Conflict, "dive " + dive.id + " is deleted: restore it first");
}

std::optional<Dive> find_recording(soci::session& session,
                                   const std::string& project,
                                   const std::string& archive_sha256,
                                   const std::string& content_sha256) {
    return select_one<DiveRow>(
        session,
        select_dive("project = :project AND state <> 'refused' AND deleted_at_ms = 0 AND"
                    " ((content_sha256 <> '' AND content_sha256 = :content)"
                    " OR (archive_sha256 <> '' AND archive_sha256 = :archive))"
                    " ORDER BY created_at_ms, id LIMIT 1"),
        soci::use(project, "project"),
        soci::use(content_sha256, "content"),
        soci::use(archive_sha256, "archive"));
}

void append_dive_event(soci::session& session, const Dive& dive, const std::string& type) {
    EventStore::append(
        session,
        {.project = dive.project, .topic = "dive", .subject = dive.id, .type = type, .data = dive});
}

void write_description(soci::session& session, const Dive& dive) {
    const std::string tags = to_text(dive.tags);
    const std::string position = position_text(dive);
    const std::string recorded = to_text(dive.recorded);
    execute(session,
            "UPDATE dives SET name = :name, site = :site, rig = :rig, tags = :tags,"
            " notes = :notes, position = :position, recorded = :recorded WHERE id = :id",
            soci::use(dive.name, "name"),
            soci::use(dive.site, "site"),
            soci::use(dive.rig, "rig"),
            soci::use(tags, "tags"),
            soci::use(dive.notes, "notes"),
            soci::use(position, "position"),
            soci::use(recorded, "recorded"),
            soci::use(dive.id, "id"));
    write_tags(session, dive);
}

IntakeVerdict apply_intake(soci::session& session,
                           const std::string& dive_id,
                           const IntakeResult& result) {
    IntakeVerdict verdict{.dive = read_dive(session, dive_id)};
    Dive& dive = verdict.dive;
    IntakeResult judged = result;
    if (auto finding = check_identity(session, dive, result.content_sha256))
        judged.findings.push_back(std::move(*finding));
    verdict.refusal = refusal_by(judged.findings);

    dive.state = verdict.refusal ? DiveState::Refused : DiveState::Ready;
    if (!result.name.empty()) dive.name = result.name;
    dive.site = result.site;
    dive.rig = result.rig;
    dive.tags = result.tags;
    dive.notes = result.notes;
    dive.position = result.position;
    if (!result.content_sha256.sha256.empty()) dive.content_sha256 = result.content_sha256.sha256;
    dive.num_frames = result.num_frames;
    dive.duration_s = result.duration_s;
    dive.has_thumbnail = !result.thumbnail_blob.empty();
    write_intake(session, dive, judged);
    write_tags(session, dive);
    append_dive_event(session, dive, verdict.refusal ? "dive.refused" : "dive.ready");
    return verdict;
}

}  // namespace divemesh::storage
