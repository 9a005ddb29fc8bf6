#include "worker/io/las_writer.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/io/record.hpp"

namespace divemesh::io {
namespace {

// The tables named below are those of the ASPRS LAS 1.4 specification, revision 15.
constexpr std::uint16_t kHeader_bytes = 375;
constexpr std::uint8_t kPointFormat = 7;
constexpr std::uint16_t kPoint_bytes = 36 + 8;  // with the extra bytes
constexpr std::uint16_t kWktEncoding = 1 << 4;  // of the global encoding
constexpr std::uint8_t kOneReturnOfOne = 1 | 1 << 4;
constexpr std::uint16_t kColorSteps = 256;
constexpr double kStep_m = 1e-4;

// The box of the points, in steps from `origin_m`, where the file's integers are 0.
struct Grid {
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d high_m = Eigen::Vector3d::Zero();

    double steps(const Eigen::Vector3d& point, int axis) const {
        return std::round((point[axis] - origin_m[axis]) / kStep_m);
    }
    // Returns a coordinate as readers of the file compute it.
    double stored(const Eigen::Vector3d& point, int axis) const {
        return steps(point, axis) * kStep_m + origin_m[axis];
    }
};

Eigen::Vector3d place_of(const Eigen::Vector3f& p_world, const std::optional<UtmFrame>& utm) {
    Eigen::Vector3d place = p_world.cast<double>();
    if (utm) place.head<2>() = utm->A * Eigen::Vector3d(place.x(), place.y(), 1.0);
    return place;
}

Grid grid_of(const types::Mesh& mesh, const std::optional<UtmFrame>& utm) {
    Grid grid;
    if (mesh.vertices.empty()) return grid;
    grid.low_m.setConstant(std::numeric_limits<double>::max());
    grid.high_m = -grid.low_m;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
        const Eigen::Vector3d place = place_of(vertex, utm);
        grid.low_m = grid.low_m.cwiseMin(place);
        grid.high_m = grid.high_m.cwiseMax(place);
    }
    if ((grid.high_m - grid.low_m).maxCoeff() > 4e5)
        throw Error(ErrorCode::BadData,
                    "the mesh is larger than 400 km, which LAS cannot hold in steps of 0.1 mm: "
                    "check its vertices");
    grid.origin_m = (0.5 * (grid.low_m + grid.high_m)).array().round();
    const Grid unrounded = grid;
    for (int axis = 0; axis < 3; ++axis) {
        grid.low_m[axis] = unrounded.stored(unrounded.low_m, axis);
        grid.high_m[axis] = unrounded.stored(unrounded.high_m, axis);
    }
    return grid;
}

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

constexpr std::uint32_t kNumVlrs = 3;

std::string vlrs(const LasDescription& description) {
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
    return std::string(record.bytes());
}

// Puts the number of points by return: each is the first of one.
void put_counts(Record& record, std::uint64_t num_points) {
    record.put(num_points);
    record.put(num_points);
    record.put_zeros(14 * sizeof num_points);
}

// Returns the public header block (table 3).
std::string header(const Grid& grid,
                   const LasDescription& description,
                   std::uint64_t num_points,
                   std::size_t vlr_bytes) {
    std::uint16_t day = 0;
    std::uint16_t year = 0;
    if (const auto& date = description.date) {
        const std::chrono::sys_days first = date->year() / std::chrono::January / 1;
        day = static_cast<std::uint16_t>((std::chrono::sys_days(*date) - first).count() + 1);
        year = static_cast<std::uint16_t>(static_cast<int>(date->year()));
    }
    Record record;
    record.put_field("LASF", 4);
    record.put(std::uint16_t{0});  // source
    record.put(kWktEncoding);
    record.put_zeros(16);  // project
    record.put(std::uint8_t{1});
    record.put(std::uint8_t{4});
    record.put_field("OTHER", 32);
    record.put_field("divemesh", 32);
    record.put(day);
    record.put(year);
    record.put(kHeader_bytes);
    record.put(static_cast<std::uint32_t>(kHeader_bytes + vlr_bytes));
    record.put(kNumVlrs);
    record.put(kPointFormat);
    record.put(kPoint_bytes);
    record.put_zeros(6 * sizeof(std::uint32_t));  // legacy counts
    record.put(Eigen::Vector3d::Constant(kStep_m).eval());
    record.put(grid.origin_m);
    for (int axis = 0; axis < 3; ++axis) {
        record.put(grid.high_m[axis]);
        record.put(grid.low_m[axis]);
    }
    record.put_zeros(8 + 8 + 4);  // no waveforms, no extended records
    put_counts(record, num_points);
    return std::string(record.bytes());
}

// Puts a point (table 16) with its extra bytes.
void put_point(Record& record,
               const types::Mesh& mesh,
               std::size_t i,
               const Grid& grid,
               const Eigen::Vector3d& place) {
    for (int axis = 0; axis < 3; ++axis)
        record.put(static_cast<std::int32_t>(grid.steps(place, axis)));
    record.put_zeros(2);  // intensity
    record.put(kOneReturnOfOne);
    record.put_zeros(1 + 1 + 1 + 2 + 2 + 8);  // flags, class, user, angle, source, GPS time
    for (std::size_t channel = 0; channel < 3; ++channel)
        record.put(static_cast<std::uint16_t>(
            mesh.colors.empty() ? 0 : mesh.colors[i][channel] * kColorSteps));
    record.put(mesh.sigma_m.empty() ? 0.0F : mesh.sigma_m[i]);
    record.put(mesh.num_observations.empty() ? 0U : mesh.num_observations[i]);
}

}  // namespace

void write_las(const std::filesystem::path& file,
               const types::Mesh& mesh,
               const LasDescription& description) {
    check_mesh(mesh);
    const Grid grid = grid_of(mesh, description.utm);
    const std::string records = vlrs(description);
    base::AtomicFile output(file);
    output.write(header(grid, description, mesh.vertices.size(), records.size()));
    output.write(records);
    Record record;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        put_point(record, mesh, i, grid, place_of(mesh.vertices[i], description.utm));
        record.flush_to(output);
    }
    output.commit();
}

}  // namespace divemesh::io
