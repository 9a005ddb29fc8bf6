#include "storage/upload_store.hpp"

#include <algorithm>
#include <set>

#include "schemas/enum_text.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/event_store.hpp"
#include "storage/ids.hpp"
#include "storage/project_usage.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr EnumText<UploadEnd> kEndTexts[] = {
    {UploadEnd::Terminated, "terminated"},
    {UploadEnd::Expired, "expired"},
    {UploadEnd::Concatenated, "concatenated"},
};

const std::string kSelect =
    "SELECT id, project, token_id, COALESCE(length_bytes, -1), offset_bytes, metadata, concat, "
    "blob,"
    " COALESCE(dive_id, ''), truth_id, created_at_ms, lifetime_ms,"
    " CASE WHEN dive_id IS NULL THEN touched_at_ms + lifetime_ms ELSE 0 END, ended FROM uploads";

struct UploadRow {
    Upload upload;
    std::string ended;
    std::int64_t length_bytes = 0;  // -1: unknown

    void define(soci::statement& statement) {
        define_columns(statement,
                       upload.id,
                       upload.project,
                       upload.token_id,
                       length_bytes,
                       upload.offset_bytes,
                       upload.metadata,
                       upload.concat,
                       upload.blob,
                       upload.dive_id,
                       upload.truth_id,
                       upload.created_at_ms,
                       upload.lifetime_ms,
                       upload.expires_at_ms,
                       ended);
    }
    Upload value() const {
        Upload result = upload;
        if (length_bytes >= 0) result.length_bytes = length_bytes;
        if (!ended.empty())
            result.end = enum_from_text<UploadEnd>(kEndTexts, ended, "end of an upload");
        return result;
    }
};

template <typename... Uses>
std::vector<Upload> select_uploads(soci::session& session,
                                   const std::string& where,
                                   const Uses&... uses) {
    return select_all<UploadRow>(session, kSelect + " WHERE " + where, uses...);
}

Upload read_upload(soci::session& session, const std::string& id) {
    auto upload = select_one<UploadRow>(session, kSelect + " WHERE id = :id", soci::use(id, "id"));
    if (!upload) throw Error(ErrorCode::NotFound, "no upload " + id);
    return std::move(*upload);
}

Upload read_open_upload(soci::session& session, const std::string& id) {
    Upload upload = read_upload(session, id);
    require_open(upload);
    return upload;
}

void append_event(soci::session& session, const Upload& upload, const std::string& type) {
    EventStore::append(session,
                       {.project = upload.project,
                        .topic = "upload",
                        .subject = upload.id,
                        .type = type,
                        .data = upload});
}

void write_end(soci::session& session, const Upload& upload, UploadEnd end) {
    const std::string text(enum_to_text(kEndTexts, end));
    const std::int64_t now_ms = Catalog::now_ms(session);
    execute(session,
            "UPDATE uploads SET ended = :ended, touched_at_ms = :now WHERE id = :id",
            soci::use(text, "ended"),
            soci::use(now_ms, "now"),
            soci::use(upload.id, "id"));
    append_event(session, upload, end == UploadEnd::Expired ? "upload.expired" : "upload.removed");
}

constexpr const char* kOpen = " AND dive_id IS NULL AND ended = ''";

void require_few_open(soci::session& session, const Upload& upload, const UploadLimits& limits) {
    const struct {
        const char* column;
        const std::string& value;
        std::int64_t max_num_open;
        std::string whose;
    } cases[] = {
        {"project", upload.project, limits.max_open_of_project, "project " + upload.project},
        {"token_id", upload.token_id, limits.max_open_of_token, "this token"}};
    for (const auto& c : cases) {
        if (c.max_num_open == 0 || c.value.empty()) continue;
        std::int64_t count = 0;
        session << "SELECT COUNT(*) FROM uploads WHERE " << c.column << " = :value" << kOpen,
            soci::into(count), soci::use(c.value, "value");
        if (count >= c.max_num_open)
            throw Error(ErrorCode::TooMany,
                        c.whose + " has " + std::to_string(c.max_num_open) +
                            " unfinished uploads: finish or delete some");
    }
}

std::optional<Upload> select_final(soci::session& session, const Upload& wanted) {
    auto found = select_uploads(session,
                                "project = :project AND concat = :concat AND metadata = :metadata"
                                " AND ended = '' ORDER BY created_at_ms LIMIT 1",
                                soci::use(wanted.project, "project"),
                                soci::use(wanted.concat, "concat"),
                                soci::use(wanted.metadata, "metadata"));
    return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

// Returns whether a final upload that still lacks its bytes has claimed the part.
bool is_claimed(soci::session& session, const std::string& part_id) {
    std::int64_t num_claims = 0;
    session << "SELECT COUNT(*) FROM upload_parts JOIN uploads ON id = final_id"
               " WHERE part_id = :part AND offset_bytes < length_bytes"
            << kOpen,
        soci::into(num_claims), soci::use(part_id, "part");
    return num_claims > 0;
}

// Returns the bytes of a final upload that its parts do not account for.
std::int64_t repeated_bytes(soci::session& session, const std::vector<std::string>& part_ids) {
    std::int64_t bytes = 0;
    std::set<std::string> seen;
    for (const std::string& id : part_ids) {
        const Upload part = read_open_upload(session, id);
        if (!seen.insert(id).second || is_claimed(session, id))
            bytes += part.length_bytes.value_or(0);
    }
    return bytes;
}

void claim_parts(soci::session& session,
                 const std::string& final_id,
                 const std::vector<std::string>& part_ids) {
    for (const std::string& id : std::set<std::string>(part_ids.begin(), part_ids.end()))
        execute(session,
                "INSERT INTO upload_parts (final_id, part_id) VALUES (:final, :part)",
                soci::use(final_id, "final"),
                soci::use(id, "part"));
}

Upload insert(soci::session& session,
              Upload upload,
              std::int64_t repeated_bytes,
              const UploadLimits& limits) {
    const std::int64_t length_bytes = upload.length_bytes.value_or(0);
    soci::indicator has_length = upload.length_bytes ? soci::i_ok : soci::i_null;
    const std::int64_t more_bytes = upload.is_final() ? repeated_bytes : length_bytes;
    require_few_open(session, upload, limits);
    require_bytes_of_quota(session, upload.project, more_bytes, limits.max_bytes_of_project);
    upload.id = new_id("upload");
    upload.blob = "uploads/" + upload.id;
    upload.offset_bytes = 0;
    upload.dive_id.clear();
    upload.created_at_ms = Catalog::now_ms(session);
    upload.expires_at_ms = upload.created_at_ms + upload.lifetime_ms;
    execute(session,
            "INSERT INTO uploads (id, project, token_id, length_bytes, metadata, concat, blob,"
            " repeated_bytes, created_at_ms, touched_at_ms, lifetime_ms)"
            " VALUES (:id, :project, :token, :length, :metadata, :concat, :blob,"
            " :repeated, :now, :now, :lifetime)",
            soci::use(upload.id, "id"),
            soci::use(upload.project, "project"),
            soci::use(upload.token_id, "token"),
            soci::use(length_bytes, has_length, "length"),
            soci::use(upload.metadata, "metadata"),
            soci::use(upload.concat, "concat"),
            soci::use(upload.blob, "blob"),
            soci::use(repeated_bytes, "repeated"),
            soci::use(upload.created_at_ms, "now"),
            soci::use(upload.lifetime_ms, "lifetime"));
    append_event(session, upload, "upload.created");
    if (upload.complete()) append_event(session, upload, "upload.completed");
    return upload;
}

}  // namespace

Upload UploadStore::create(Upload upload, const UploadLimits& limits) {
    if (upload.length_bytes.value_or(0) < 0)
        throw Error(ErrorCode::InvalidArgument, "the length of an upload must be at least 0");
    catalog_.transaction(
        [&](soci::session& session) { upload = insert(session, upload, 0, limits); });
    return upload;
}

Upload UploadStore::create_final(Upload upload,
                                 const std::vector<std::string>& part_ids,
                                 const UploadLimits& limits) {
    catalog_.transaction([&](soci::session& session) {
        if (auto known = select_final(session, upload)) {
            upload = std::move(*known);
            return;
        }
        upload = insert(session, upload, repeated_bytes(session, part_ids), limits);
        claim_parts(session, upload.id, part_ids);
    });
    return upload;
}

Upload UploadStore::get(const std::string& id) {
    Upload upload;
    catalog_.read([&](soci::session& session) { upload = read_upload(session, id); });
    return upload;
}

std::optional<Upload> UploadStore::find(const std::string& id) {
    std::optional<Upload> upload;
    catalog_.read([&](soci::session& session) {
        upload = select_one<UploadRow>(session, kSelect + " WHERE id = :id", soci::use(id, "id"));
    });
    return upload;
}

Upload UploadStore::set_length(const std::string& id,
                               std::int64_t length_bytes,
                               std::int64_t max_bytes_of_project) {
    Upload upload;
    catalog_.transaction([&](soci::session& session) {
        upload = read_open_upload(session, id);
        if (upload.length_bytes == length_bytes) return;
        if (upload.length_bytes)
            throw Error(ErrorCode::InvalidArgument,
                        "Upload-Length cannot change: it is " +
                            std::to_string(*upload.length_bytes) + " already");
        if (length_bytes < upload.offset_bytes)
            throw Error(ErrorCode::InvalidArgument,
                        "Upload-Length is below the " + std::to_string(upload.offset_bytes) +
                            " bytes that were already received");
        require_bytes_of_quota(
            session, upload.project, length_bytes - upload.offset_bytes, max_bytes_of_project);
        upload.length_bytes = length_bytes;
        execute(session,
                "UPDATE uploads SET length_bytes = :length WHERE id = :id",
                soci::use(length_bytes, "length"),
                soci::use(id, "id"));
        if (upload.complete()) append_event(session, upload, "upload.completed");
    });
    return upload;
}

Upload UploadStore::advance(const std::string& id, std::int64_t offset_bytes) {
    Upload upload;
    catalog_.transaction([&](soci::session& session) {
        upload = read_open_upload(session, id);
        if (upload.length_bytes && offset_bytes > *upload.length_bytes)
            throw Error(ErrorCode::TooLarge,
                        "there are more bytes than upload " + id + " announced");
        if (offset_bytes <= upload.offset_bytes) return;
        upload.offset_bytes = offset_bytes;
        const std::int64_t now_ms = Catalog::now_ms(session);
        if (upload.dive_id.empty()) upload.expires_at_ms = now_ms + upload.lifetime_ms;
        execute(session,
                "UPDATE uploads SET offset_bytes = :offset, touched_at_ms = :now WHERE id = :id",
                soci::use(offset_bytes, "offset"),
                soci::use(now_ms, "now"),
                soci::use(id, "id"));
        if (upload.complete()) append_event(session, upload, "upload.completed");
    });
    return upload;
}

std::optional<Upload> UploadStore::find_final(const Upload& wanted) {
    std::optional<Upload> found;
    catalog_.read([&](soci::session& session) { found = select_final(session, wanted); });
    return found;
}

void UploadStore::end(const std::string& id, UploadEnd end) {
    catalog_.transaction([&](soci::session& session) {
        const Upload upload = read_open_upload(session, id);
        if (is_claimed(session, id))
            throw Error(
                ErrorCode::Locked,
                "upload " + id +
                    " is being joined with others: finish or delete the final upload first");
        write_end(session, upload, end);
    });
}

bool UploadStore::expire(const std::string& id) {
    bool expired = false;
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const auto due = select_uploads(session,
                                        "id = :id AND ended = '' AND dive_id IS NULL"
                                        " AND touched_at_ms + lifetime_ms <= :now",
                                        soci::use(id, "id"),
                                        soci::use(now_ms, "now"));
        expired = !due.empty() && !is_claimed(session, id);
        if (expired) write_end(session, due.front(), UploadEnd::Expired);
    });
    return expired;
}

std::vector<std::string> UploadStore::list_expired() {
    std::vector<std::string> ids;
    catalog_.read([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        ids = select_all<TextRow>(session,
                                  "SELECT id FROM uploads WHERE ended = '' AND dive_id IS NULL"
                                  " AND touched_at_ms + lifetime_ms <= :now ORDER BY touched_at_ms",
                                  soci::use(now_ms, "now"));
    });
    return ids;
}

std::vector<Upload> UploadStore::list_unfreed() {
    std::vector<Upload> uploads;
    catalog_.read([&](soci::session& session) {
        uploads = select_uploads(session, "ended <> '' AND bytes_freed = 0 ORDER BY touched_at_ms");
    });
    return uploads;
}

void UploadStore::set_freed(const std::string& id) {
    catalog_.transaction([&](soci::session& session) {
        execute(session,
                "UPDATE uploads SET bytes_freed = 1 WHERE id = :id AND ended <> ''",
                soci::use(id, "id"));
    });
}

void UploadStore::forget_ended(std::int64_t older_than_ms) {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t before_ms = Catalog::now_ms(session) - older_than_ms;
        execute(session,
                "DELETE FROM uploads WHERE ended <> '' AND bytes_freed = 1"
                " AND touched_at_ms < :before",
                soci::use(before_ms, "before"));
    });
}

std::vector<Upload> UploadStore::list_open() {
    std::vector<Upload> uploads;
    catalog_.read([&](soci::session& session) {
        uploads = select_uploads(session, "dive_id IS NULL AND ended = '' ORDER BY touched_at_ms");
    });
    return uploads;
}

void require_open(const Upload& upload) {
    if (!upload.end) return;
    switch (*upload.end) {
        case UploadEnd::Terminated:
            throw Error(ErrorCode::Gone, "upload " + upload.id + " was deleted: start a new one");
        case UploadEnd::Expired:
            throw Error(ErrorCode::Gone, "upload " + upload.id + " has expired: start a new one");
        case UploadEnd::Concatenated:
            throw Error(ErrorCode::Gone,
                        "upload " + upload.id + " was already joined into its final upload");
    }
}

}  // namespace divemesh::storage
