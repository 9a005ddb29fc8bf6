#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "schemas/content_hash.hpp"
#include "schemas/finding.hpp"
#include "schemas/links.hpp"
#include "worker/base/observer.hpp"
#include "worker/dive/marker_plan.hpp"
#include "worker/types/geographic_position.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/outside_positions.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Limits against hostile archives and images. Checked before memory is allocated.
struct DiveLimits {
    std::int64_t max_entries = 2'000'000;
    std::int64_t max_unpacked_bytes = std::int64_t{512} << 30;
    double max_compression_ratio = 100.0;  // of the archive as a whole, once it exceeds 64 MiB
    std::int64_t max_file_bytes = std::int64_t{2} << 30;  // images: 64 MiB
    std::int64_t max_image_pixels = 64'000'000;
};

// The contents of dive.json.
struct DiveInfo {
    std::string name;
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string notes;  // may have several lines
    std::optional<double> water_temperature_c;
    std::optional<double> water_salinity_psu;
    std::optional<types::GeographicPosition> position;  // of the body's first pose
};

// A point as marked in one stereo pair, in pixels of the recorded (distorted) images.
struct Mark {
    std::int64_t timestamp_ns = 0;  // of the frame
    Eigen::Vector2d pixel_left = Eigen::Vector2d::Zero();
    std::optional<Eigen::Vector2d> pixel_right;  // nullopt: not marked in the right image
};

// A length from measurements.json, known from another source. Its ends are points in the world of
// the ground truth, or marked by hand in images.
struct KnownDistance {
    std::string name;
    Eigen::Vector3d a_world = Eigen::Vector3d::Zero();
    Eigen::Vector3d b_world = Eigen::Vector3d::Zero();
    double distance_m = 0.0;
    std::vector<Mark> marks_a;  // if both are given, a_world and b_world are ignored
    std::vector<Mark> marks_b;

    bool is_marked() const { return !marks_a.empty() && !marks_b.empty(); }
};

// A dive on disk in EuRoC/ASL layout, with `mav0/` or its parent as the root: a folder, or a zip,
// tar, tar.gz or tar.zst of it. An archive is read once and its accepted entries are kept in one
// file in `scratch`; entry names never become paths. All problems are in findings(); a dive that
// cannot be reconstructed has at least one error there.
class Dive : public types::Recording {
public:
    // Throws Error{NotFound} if `path` does not exist, Error{BadData} with the reason if it is not
    // a dive at all; all other problems are findings. `progress` is called while an archive is
    // unpacked and may throw Error{Cancelled}. `links` are those of a folder; what the links of an
    // archive lead to is never read.
    static std::unique_ptr<Dive> open(
        const std::filesystem::path& path,
        const std::filesystem::path& scratch,
        const DiveLimits& limits = {},
        const base::ProgressCallback& progress = base::ignore_progress,
        Links links = Links::LeaveOut);

    virtual const DiveInfo& info() const = 0;
    virtual const std::vector<Finding>& findings() const = 0;  // grows as frames are read
    virtual const std::string& content_sha256() const = 0;     // of the sorted (path, sha256) list
    virtual const ContentHash& content_hash() const = 0;       // with those of earlier versions
    virtual double duration_s() const = 0;

    // Returns T_world_imu of the ground truth's own world; empty without ground truth.
    virtual const types::Trajectory& ground_truth() const = 0;
    // Returns positions and velocities that other instruments measured.
    virtual const types::OutsidePositions& outside() const = 0;
    virtual const std::vector<KnownDistance>& known_distances() const = 0;
    // Returns the contents of markers.json; nullopt if the file is missing.
    virtual const std::optional<MarkerPlan>& markers() const = 0;
    // Returns the reference mesh in the ground truth's world.
    virtual std::optional<types::Mesh> read_reference_mesh() const = 0;
    // Returns all true surface that a camera saw, however far away, in the ground truth's world.
    virtual std::optional<types::Mesh> read_scene_mesh() const = 0;
};

}  // namespace divemesh::dive
