#include "worker/io/las_header.hpp"

#include "worker/io/las_point.hpp"
#include "worker/io/laz_points.hpp"

namespace divemesh::io {
namespace {

// The tables named below are those of the ASPRS LAS 1.4 specification, revision 15.
constexpr std::uint16_t kHeader_bytes = 375;
constexpr std::uint16_t kWktEncoding = 1 << 4;  // of the global encoding

// Returns the coordinate system as OGC's well-known text 1 (OGC 01-009).
std::string well_known_text(const std::optional<UtmFrame>& utm) {
    if (!utm)
        return R"(LOCAL_CS["divemesh world, origin at the first pose",LOCAL_DATUM["first pose",)"
               R"(32767],UNIT["metre",1],AXIS["X",OTHER],AXIS["Y",OTHER]])";
    const int zone = utm->epsg % 100;
    const bool is_south = utm->epsg / 100 == 327;
    const std::string name = "WGS 84 / UTM zone " + std::to_string(zone) + (is_south ? "S" : "N");
    return "PROJCS[\"" + name +
           R"(",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
           R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
           R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
           R"(PARAMETER["central_meridian",)" +
           std::to_string(6 * zone - 183) +
           R"(],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],)"
           R"(PARAMETER["false_northing",)" +
           (is_south ? "10000000" : "0") +
           R"(],UNIT["metre",1],AXIS["Easting",EAST],AXIS["Northing",NORTH],AUTHORITY["EPSG",")" +
           std::to_string(utm->epsg) + "\"]]";
}

// Puts a variable length record (table 8).
void put_vlr(Record& record,
             std::string_view user,
             std::uint16_t id,
             std::string_view description,
             std::string_view content) {
    record.put(std::uint16_t{0});
    record.put_field(user, 16);
    record.put(id);
    record.put(static_cast<std::uint16_t>(content.size()));
    record.put_field(description, 32);
    record.put_field(content, content.size());
}

// Puts the description of an extra value of each point, whose 0 is no data (table 25).
void put_extra_bytes(Record& record,
                     std::uint8_t type,
                     std::string_view name,
                     std::string_view description) {
    constexpr std::uint8_t kNoDataIsStated = 1;
    record.put_zeros(2);
    record.put(type);
    record.put(kNoDataIsStated);
    record.put_field(name, 32);
    record.put_zeros(4 + 5 * 24);  // unused; no data, min, max, scale, offset
    record.put_field(description, 32);
}

struct Records {
    std::string bytes;
    std::uint32_t number;
};

Records records_of(const LasDescription& description, LasStorage storage) {
    constexpr std::uint8_t kUint32 = 5;  // of table 24
    constexpr std::uint8_t kFloat = 9;
    Record extra;
    put_extra_bytes(extra, kFloat, "sigma", "along the normal, m; 0: unknown");
    put_extra_bytes(extra, kUint32, "observations", "images that saw it; 0: unknown");
    Record record;
    put_vlr(record,
            "LASF_Projection",
            2112,
            "OGC well-known text",
            well_known_text(description.utm) + std::string(1, '\0'));
    put_vlr(record,
            "LASF_Spec",
            3,
            "certificate",
            description.text.substr(0, 4096) + std::string(1, '\0'));
    put_vlr(record, "LASF_Spec", 4, "extra bytes", extra.bytes());
    if (storage == LasStorage::Laszip)
        put_vlr(record, "laszip encoded", 22204, "compressor", laszip_record());
    return {std::string(record.bytes()), storage == LasStorage::Laszip ? 4U : 3U};
}

// Puts the date of creation: the day of the year, from 1, and the year.
void put_date(Record& record, const std::optional<std::chrono::year_month_day>& date) {
    std::uint16_t day = 0;
    std::uint16_t year = 0;
    if (date) {
        const std::chrono::sys_days first = date->year() / std::chrono::January / 1;
        day = static_cast<std::uint16_t>((std::chrono::sys_days(*date) - first).count() + 1);
        year = static_cast<std::uint16_t>(static_cast<int>(date->year()));
    }
    record.put(day);
    record.put(year);
}

// Puts the number of points by return: each is the first of one.
void put_counts(Record& record, std::uint64_t num_points) {
    record.put(num_points);
    record.put(num_points);
    record.put_zeros(14 * sizeof num_points);
}

// Puts the public header block (table 3).
void put_header(Record& record,
                const LasGrid& grid,
                const LasDescription& description,
                std::uint64_t num_points,
                const Records& records,
                LasStorage storage) {
    constexpr std::uint8_t kIsCompressed = 1 << 7;  // LASzip's bit of the point format
    record.put_field("LASF", 4);
    record.put(std::uint16_t{0});  // source
    record.put(kWktEncoding);
    record.put_zeros(16);  // project
    record.put(std::uint8_t{1});
    record.put(std::uint8_t{4});
    record.put_field("OTHER", 32);
    record.put_field("divemesh", 32);
    put_date(record, description.date);
    record.put(kHeader_bytes);
    record.put(static_cast<std::uint32_t>(kHeader_bytes + records.bytes.size()));
    record.put(records.number);
    record.put(static_cast<std::uint8_t>(LasPoint::kFormat |
                                         (storage == LasStorage::Laszip ? kIsCompressed : 0)));
    record.put(LasPoint::kSize_bytes);
    record.put_zeros(6 * sizeof(std::uint32_t));  // legacy counts
    record.put(Eigen::Vector3d::Constant(LasGrid::kStep_m).eval());
    record.put(grid.origin_m);
    for (int axis = 0; axis < 3; ++axis) {
        record.put(grid.high_m[axis]);
        record.put(grid.low_m[axis]);
    }
    record.put_zeros(8 + 8 + 4);  // no waveforms, no extended records
    put_counts(record, num_points);
}

}  // namespace

std::string las_header(const LasGrid& grid,
                       const LasDescription& description,
                       std::uint64_t num_points,
                       LasStorage storage) {
    const Records records = records_of(description, storage);
    Record record;
    put_header(record, grid, description, num_points, records, storage);
    return std::string(record.bytes()) + records.bytes;
}

}  // namespace divemesh::io
