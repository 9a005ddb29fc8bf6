#include "storage/upload_store.hpp"

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/event_store.hpp"
#include "storage/ids.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

#define UPLOAD_COLUMNS                                                                 \
    "id, project, length_bytes, offset_bytes, metadata, blob, COALESCE(dive_id, ''), " \
    "created_at_ms"

struct UploadRow {
    Upload upload;

    void define(soci::statement& statement) {
        statement.exchange(soci::into(upload.id));
        statement.exchange(soci::into(upload.project));
        statement.exchange(soci::into(upload.length_bytes));
        statement.exchange(soci::into(upload.offset_bytes));
        statement.exchange(soci::into(upload.metadata));
        statement.exchange(soci::into(upload.blob));
        statement.exchange(soci::into(upload.dive_id));
        statement.exchange(soci::into(upload.created_at_ms));
    }
    Upload value() const { return upload; }
};

Upload read_upload(soci::session& session, const std::string& id) {
    auto upload = select_one<UploadRow>(
        session, "SELECT " UPLOAD_COLUMNS " FROM uploads WHERE id = :id", soci::use(id, "id"));
    if (!upload) throw Error(ErrorCode::NotFound, "no upload " + id);
    return std::move(*upload);
}

void append_event(soci::session& session, const Upload& upload, const std::string& type) {
    EventStore::append(session,
                       {.project = upload.project,
                        .topic = "upload",
                        .subject = upload.id,
                        .type = type,
                        .data = upload});
}

}  // namespace

Upload UploadStore::create(Upload upload) {
    if (upload.length_bytes < 0)
        throw Error(ErrorCode::InvalidArgument, "an upload cannot be shorter than nothing");
    upload.id = new_id("upload");
    upload.blob = "uploads/" + upload.id;
    upload.offset_bytes = 0;
    upload.dive_id.clear();
    catalog_.transaction([&](soci::session& session) {
        upload.created_at_ms = Catalog::now_ms(session);
        execute(session,
                "INSERT INTO uploads"
                " (id, project, length_bytes, metadata, blob, created_at_ms, touched_at_ms)"
                " VALUES (:id, :project, :length, :metadata, :blob, :now, :now)",
                soci::use(upload.id, "id"),
                soci::use(upload.project, "project"),
                soci::use(upload.length_bytes, "length"),
                soci::use(upload.metadata, "metadata"),
                soci::use(upload.blob, "blob"),
                soci::use(upload.created_at_ms, "now"));
        append_event(session, upload, "upload.created");
        if (upload.complete()) append_event(session, upload, "upload.completed");
    });
    return upload;
}

Upload UploadStore::get(const std::string& id) {
    Upload upload;
    catalog_.read([&](soci::session& session) { upload = read_upload(session, id); });
    return upload;
}

Upload UploadStore::advance(const std::string& id, std::int64_t offset_bytes) {
    Upload upload;
    catalog_.transaction([&](soci::session& session) {
        upload = read_upload(session, id);
        if (offset_bytes > upload.length_bytes)
            throw Error(ErrorCode::TooLarge, "more bytes than upload " + id + " announced");
        if (offset_bytes <= upload.offset_bytes) return;
        upload.offset_bytes = offset_bytes;
        const std::int64_t now_ms = Catalog::now_ms(session);
        execute(session,
                "UPDATE uploads SET offset_bytes = :offset, touched_at_ms = :now WHERE id = :id",
                soci::use(offset_bytes, "offset"),
                soci::use(now_ms, "now"),
                soci::use(id, "id"));
        if (upload.complete()) append_event(session, upload, "upload.completed");
    });
    return upload;
}

void UploadStore::remove(const std::string& id) {
    catalog_.transaction([&](soci::session& session) {
        const Upload upload = read_upload(session, id);
        execute(session, "DELETE FROM uploads WHERE id = :id", soci::use(id, "id"));
        append_event(session, upload, "upload.removed");
    });
}

std::vector<Upload> UploadStore::list_older_than(std::int64_t touched_before_ms) {
    std::vector<Upload> uploads;
    catalog_.read([&](soci::session& session) {
        uploads = select_all<UploadRow>(session,
                                        "SELECT " UPLOAD_COLUMNS
                                        " FROM uploads"
                                        " WHERE dive_id IS NULL AND touched_at_ms < :before"
                                        " ORDER BY touched_at_ms",
                                        soci::use(touched_before_ms, "before"));
    });
    return uploads;
}

}  // namespace divemesh::storage
