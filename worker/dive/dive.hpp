#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/base/observer.hpp"
#include "worker/dive/marker_plan.hpp"
#include "worker/types/geographic_position.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// What a hostile archive or picture may not exceed. Checked before anything is allocated.
struct DiveLimits {
    std::int64_t max_entries = 2'000'000;
    std::int64_t max_unpacked_bytes = std::int64_t{512} << 30;
    double max_compression_ratio = 100.0;  // of the archive as a whole, once it exceeds 64 MiB
    std::int64_t max_file_bytes = std::int64_t{2} << 30;  // pictures: 64 MiB
    std::int64_t max_image_pixels = 64'000'000;
};

// dive.json
struct DiveInfo {
    std::string name;
    std::string site;
    std::string rig;
    std::string notes;
    std::vector<std::string> tags;
    std::optional<double> water_temperature_c;
    std::optional<double> water_salinity_psu;
    std::optional<types::GeographicPosition> position;  // of the first pose of the body
};

// A point as it is marked in one stereo pair; pixels of the recorded (distorted) pictures.
struct Mark {
    std::int64_t timestamp_ns = 0;  // of the frame
    Eigen::Vector2d pixel_left = Eigen::Vector2d::Zero();
    std::optional<Eigen::Vector2d> pixel_right;  // nothing: not marked there
};

// measurements.json: a length that is known from elsewhere. Its ends are points of the ground
// truth's world, or marked in pictures by hand.
struct KnownDistance {
    std::string name;
    Eigen::Vector3d a_world = Eigen::Vector3d::Zero();
    Eigen::Vector3d b_world = Eigen::Vector3d::Zero();
    double distance_m = 0.0;
    std::vector<Mark> marks_a;  // where both are given, a_world and b_world are not looked at
    std::vector<Mark> marks_b;

    bool is_marked() const { return !marks_a.empty() && !marks_b.empty(); }
};

// A dive on disk: a folder, or a zip, tar, tar.gz or tar.zst of it, in EuRoC/ASL layout with
// `mav0/` or its parent as the root. An archive is read once and its accepted entries are kept in
// one file of ours in `scratch`; entry names never become paths. Everything that was noticed is in
// findings(); a dive that cannot be reconstructed has at least one error there.
class Dive : public types::Recording {
public:
    // Throws Error{NotFound} when there is nothing at `path`, Error{BadData} with the reason when
    // it is not a dive at all; whatever can be told as findings is told as findings. `progress` is
    // called while an archive is unpacked and may throw Error{Cancelled}.
    static std::unique_ptr<Dive> open(
        const std::filesystem::path& path,
        const std::filesystem::path& scratch,
        const DiveLimits& limits = {},
        const base::ProgressCallback& progress = base::ignore_progress);

    virtual const DiveInfo& info() const = 0;
    virtual const std::vector<Finding>& findings() const = 0;  // grows as frames are read
    virtual const std::string& content_sha256() const = 0;     // of the sorted (path, sha256) list
    virtual double duration_s() const = 0;

    virtual const types::Trajectory& ground_truth()
        const = 0;  // empty: none; T_world_imu of its own world
    virtual const std::vector<KnownDistance>& known_distances() const = 0;
    // markers.json; nothing: none.
    virtual const std::optional<MarkerPlan>& markers() const = 0;
    virtual std::optional<types::Mesh> read_reference_mesh()
        const = 0;  // world of the ground truth
};

}  // namespace divemesh::dive
