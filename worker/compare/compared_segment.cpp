#include "worker/compare/compared_segment.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "schemas/error.hpp"
#include "worker/evaluation/mesh_without_contradiction.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/mesh/mesh_components.hpp"

namespace divemesh::compare {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A range along x, m.
struct Extent {
    double low_m = kInfinity;
    double high_m = -kInfinity;

    bool is_known() const { return low_m <= high_m; }
    bool contains(double x_m) const { return low_m < x_m && x_m < high_m; }
};

[[noreturn]] void refuse(const io::ReconstructionFolder& folder,
                         const std::string& reason,
                         const std::string& remedy) {
    throw Error(ErrorCode::BadData,
                folder.path().string() +
                    " is in several tracking segments, of which only the largest can be compared, "
                    "and " +
                    reason + ": " + remedy);
}

std::vector<io::KeyframePose> keyframes_in(const types::TrackingSegment& segment,
                                           std::vector<io::KeyframePose> keyframes) {
    std::erase_if(keyframes, [&](const io::KeyframePose& keyframe) {
        return !segment.contains(keyframe.timestamp_ns);
    });
    return keyframes;
}

Extent extent_of(const std::vector<io::KeyframePose>& keyframes) {
    Extent extent;
    for (const io::KeyframePose& keyframe : keyframes) {
        const double x_m = keyframe.T_world_cam.translation().x();
        extent.low_m = std::min(extent.low_m, x_m);
        extent.high_m = std::max(extent.high_m, x_m);
    }
    return extent;
}

// Returns the range of the largest segment's surface. It ends halfway between its cameras and those
// of the segments beside it: loops::separate_segments() leaves room for either surface up to there.
Extent extent_of_largest(const io::ReconstructionFolder& folder,
                         const std::vector<types::TrackingSegment>& segments) {
    const std::vector<io::KeyframePose> keyframes = folder.keyframes();
    const std::size_t largest = evaluation::number_of_largest(segments);
    const Extent cameras = extent_of(keyframes_in(segments[largest], keyframes));
    Extent surface{-kInfinity, kInfinity};
    for (std::size_t i = 0; i < segments.size(); ++i) {
        if (i == largest) continue;
        const Extent other = extent_of(keyframes_in(segments[i], keyframes));
        if (!cameras.is_known() || !other.is_known() ||
            (other.low_m <= cameras.high_m && cameras.low_m <= other.high_m))
            refuse(folder,
                   "its keyframes do not tell where each of them lies",
                   "reconstruct it again with this version");
        if (other.low_m > cameras.high_m)
            surface.high_m = std::min(surface.high_m, 0.5 * (cameras.high_m + other.low_m));
        else
            surface.low_m = std::max(surface.low_m, 0.5 * (other.high_m + cameras.low_m));
    }
    return surface;
}

}  // namespace

std::vector<io::KeyframePose> compared_keyframes(const io::ReconstructionFolder& folder) {
    const std::vector<types::TrackingSegment> segments = folder.segments();
    if (segments.size() < 2) return folder.keyframes();
    return keyframes_in(segments[evaluation::number_of_largest(segments)], folder.keyframes());
}

types::Mesh compared_surface(const io::ReconstructionFolder& folder) {
    types::Mesh mesh = evaluation::mesh_without_contradiction(folder);
    const std::vector<types::TrackingSegment> segments = folder.segments();
    if (segments.size() < 2) return mesh;
    const Extent extent = extent_of_largest(folder, segments);
    std::erase_if(mesh.triangles, [&](const std::array<std::uint32_t, 3>& triangle) {
        const auto num_inside = std::ranges::count_if(triangle, [&](std::uint32_t vertex) {
            return extent.contains(static_cast<double>(mesh.vertices[vertex].x()));
        });
        if (num_inside == 1 || num_inside == 2)
            refuse(folder,
                   "its surface touches that of another in mesh.ply",
                   "reconstruct it again with a smaller max_depth_m, so that they end earlier");
        return num_inside == 0;
    });
    mesh::remove_unreferenced_vertices(mesh);
    return mesh;
}

}  // namespace divemesh::compare
