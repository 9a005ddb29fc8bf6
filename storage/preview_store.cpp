#include "storage/preview_store.hpp"

#include <algorithm>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/sql.hpp"
#include "storage/stored_bytes.hpp"

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

StoredPreview with_jpeg(soci::session& session,
                        const std::optional<Preview>& preview,
                        const std::string& sensor) {
    if (!preview) throw Error(ErrorCode::NotFound, "no such preview of sensor " + sensor);
    const std::int64_t age_ms = Catalog::now_ms(session) - preview->time_ms;
    return {*preview,
            read_bytes(session, "sensor_previews", "jpeg", preview->id),
            std::max<std::int64_t>(0, age_ms)};
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
    const auto insert = [&](const std::string& place, const auto& jpeg) {
        return select_one<NumberRow>(
            session,
            "INSERT INTO sensor_previews (sensor, time_ms, camera, width, height, num_bytes,"
            " sha256, about, jpeg) VALUES (:sensor, :time, :camera, :width, :height, :bytes,"
            " :sha256, :about, " +
                place + ") RETURNING number",
            soci::use(sensor, "sensor"),
            soci::use(preview.time_ms, "time"),
            soci::use(preview.camera, "camera"),
            soci::use(preview.width, "width"),
            soci::use(preview.height, "height"),
            soci::use(preview.num_bytes, "bytes"),
            soci::use(preview.sha256, "sha256"),
            soci::use(about, "about"),
            jpeg);
    };
    preview.id = with_bytes(session, "jpeg", message.jpeg, insert).value();
    execute(session,
            "DELETE FROM sensor_previews WHERE sensor = :sensor AND (time_ms, number) <="
            " (SELECT time_ms, number FROM sensor_previews WHERE sensor = :sensor"
            "  ORDER BY time_ms DESC, number DESC LIMIT 1 OFFSET :kept)",
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
