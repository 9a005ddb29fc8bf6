#include "storage/preview_store.hpp"

#include <algorithm>
#include <soci/blob.h>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct PreviewRow {
    Preview preview;
    std::string about;

    void define(soci::statement& statement) {
        define_columns(statement,
                       preview.id,
                       preview.camera,
                       preview.time_ms,
                       preview.width,
                       preview.height,
                       preview.num_bytes,
                       preview.sha256,
                       about);
    }
    Preview value() const {
        Preview value = preview;
        value.about = nlohmann::json::parse(about);
        return value;
    }
};

// The columns of PreviewRow, of the sensor ":sensor".
const std::string kColumns =
    "sensor_previews.number, camera, time_ms, width, height, num_bytes, sha256, about";
const std::string kFromSensor =
    " FROM sensor_previews JOIN sensors ON sensors.number = sensor WHERE sensors.id = :sensor";

// Returns the bytes. They need a statement of their own, because SOCI's blob lives as long as its
// session.
std::string jpeg_of(soci::session& session, std::int64_t number) {
    fault_point();
    soci::blob blob(session);
    session << "SELECT jpeg FROM sensor_previews WHERE number = :number", soci::into(blob),
        soci::use(number, "number");
    std::string jpeg(blob.get_len(), '\0');
    blob.read(0, jpeg.data(), jpeg.size());
    return jpeg;
}

StoredPreview with_jpeg(soci::session& session,
                        const std::optional<Preview>& preview,
                        const std::string& sensor) {
    if (!preview) throw Error(ErrorCode::NotFound, "no such preview of sensor " + sensor);
    const std::int64_t age_ms = Catalog::now_ms(session) - preview->time_ms;
    return {*preview, jpeg_of(session, preview->id), std::max<std::int64_t>(0, age_ms)};
}

}  // namespace

Preview insert_preview(soci::session& session,
                       std::int64_t sensor,
                       const SensorMessage& message,
                       std::int64_t time_ms,
                       int max_kept) {
    Preview preview;
    preview.about = message.body;
    preview.camera = message.body.at("camera").get<std::string>();
    preview.width = message.body.at("width").get<int>();
    preview.height = message.body.at("height").get<int>();
    for (const char* known : {"camera", "width", "height"}) preview.about.erase(known);
    preview.time_ms = time_ms;
    preview.num_bytes = static_cast<std::int64_t>(message.jpeg.size());
    preview.sha256 = sha256_hex(message.jpeg);
    const std::string about = to_text(preview.about);
    soci::blob jpeg(session);
    jpeg.write(0, message.jpeg.data(), message.jpeg.size());
    execute(session,
            "INSERT INTO sensor_previews (sensor, time_ms, camera, width, height, num_bytes,"
            " sha256, about, jpeg) VALUES (:sensor, :time, :camera, :width, :height, :bytes,"
            " :sha256, :about, :jpeg)",
            soci::use(sensor, "sensor"),
            soci::use(preview.time_ms, "time"),
            soci::use(preview.camera, "camera"),
            soci::use(preview.width, "width"),
            soci::use(preview.height, "height"),
            soci::use(preview.num_bytes, "bytes"),
            soci::use(preview.sha256, "sha256"),
            soci::use(about, "about"),
            soci::use(jpeg, "jpeg"));
    session << "SELECT last_insert_rowid()", soci::into(preview.id);
    execute(session,
            "DELETE FROM sensor_previews WHERE number IN (SELECT number FROM sensor_previews"
            " WHERE sensor = :sensor ORDER BY time_ms DESC, number DESC LIMIT -1 OFFSET :kept)",
            soci::use(sensor, "sensor"),
            soci::use(max_kept, "kept"));
    return preview;
}

std::vector<Preview> PreviewStore::list(const std::string& sensor) {
    std::vector<Preview> previews;
    catalog_.read([&](soci::session& session) {
        previews = select_all<PreviewRow>(session,
                                          "SELECT " + kColumns + kFromSensor +
                                              " ORDER BY time_ms DESC, sensor_previews.number DESC",
                                          soci::use(sensor, "sensor"));
    });
    return previews;
}

StoredPreview PreviewStore::newest(const std::string& sensor, const std::string& camera) {
    StoredPreview stored;
    catalog_.read([&](soci::session& session) {
        const auto preview = select_one<PreviewRow>(
            session,
            "SELECT " + kColumns + kFromSensor +
                " AND (:camera = '' OR camera = :camera)"
                " ORDER BY time_ms DESC, sensor_previews.number DESC LIMIT 1",
            soci::use(sensor, "sensor"),
            soci::use(camera, "camera"));
        stored = with_jpeg(session, preview, sensor);
    });
    return stored;
}

StoredPreview PreviewStore::get(const std::string& sensor, std::int64_t id) {
    StoredPreview stored;
    catalog_.read([&](soci::session& session) {
        const auto preview = select_one<PreviewRow>(
            session,
            "SELECT " + kColumns + kFromSensor + " AND sensor_previews.number = :id",
            soci::use(sensor, "sensor"),
            soci::use(id, "id"));
        stored = with_jpeg(session, preview, sensor);
    });
    return stored;
}

}  // namespace divemesh::storage
