#include "worker/simulator/lay_markers.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "schemas/error.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/camera/projection.hpp"
#include "worker/markers/tag_layout.hpp"
#include "worker/simulator/ray_caster.hpp"

namespace divemesh::simulator {
namespace {

constexpr float kThickness_m = 0.004F;
constexpr float kGap_m = 0.01F;      // between the board and the highest ground under it
constexpr float kMaxRange_m = 2.2F;  // from the camera
constexpr float kMinCosine = 0.5F;   // between the board's normal and the direction to the camera
constexpr float kMinSlopeCosine = 0.7F;

// Returns the edge of a board, which has one white cell around the tag's image.
float edge_of_board_m(const SimulateOptions& options) {
    const markers::TagLayout layout = markers::tag_layout(options.marker_family);
    return static_cast<float>(options.marker_size_m * (layout.total_cells + 2) / layout.size_cells);
}

constexpr int kPointsPerSide = 5;
constexpr int kBoardPoints = kPointsPerSide * kPointsPerSide;

// Returns point `i` of kBoardPoints on a square grid over the board, in the board's frame.
Eigen::Vector3f board_point(int i, float edge_m) {
    const int row = i / kPointsPerSide - kPointsPerSide / 2;
    const int column = i % kPointsPerSide - kPointsPerSide / 2;
    return 0.25F * edge_m *
           Eigen::Vector3f(static_cast<float>(column), static_cast<float>(row), 0.0F);
}

class BoardLayer {
public:
    BoardLayer(const RayCaster& caster, float edge_m, std::uint64_t seed)
        : caster_(caster), edge_m_(edge_m), seed_(seed) {}

    const std::vector<LaidMarker>& boards() const { return boards_; }

    // Lays a board where this ray of the camera meets the ground, if there is room and it is seen
    // well.
    void try_at(const Eigen::Isometry3d& T_world_cam, const Eigen::Vector3d& ray_cam) {
        const Eigen::Vector3f eye = T_world_cam.translation().cast<float>();
        const Eigen::Vector3f ray = (T_world_cam.linear() * ray_cam).normalized().cast<float>();
        const RayHit hit = caster_.cast(eye, ray);
        if (!hit.valid() || hit.t > kMaxRange_m) return;
        const Eigen::Vector3f p = eye + hit.t * ray;
        for (const LaidMarker& board : boards_)
            if ((board.T_world_board.translation() - p).norm() < 2.0F * edge_m_) return;
        const auto board = board_on(p);
        if (!board) return;
        const Eigen::Vector3f to_eye = (eye - board->T_world_board.translation()).normalized();
        if (board->T_world_board.linear().col(2).dot(to_eye) < kMinCosine ||
            !is_in_sight(*board, eye))
            return;
        boards_.push_back(*board);
    }

private:
    bool is_in_sight(const LaidMarker& board, const Eigen::Vector3f& eye) const {
        for (const Eigen::Vector2f& side : {Eigen::Vector2f(-1, -1),
                                            Eigen::Vector2f(1, -1),
                                            Eigen::Vector2f(1, 1),
                                            Eigen::Vector2f(-1, 1),
                                            Eigen::Vector2f(0, 0)}) {
            const Eigen::Vector3f p_board(
                0.5F * edge_m_ * side.x(), 0.5F * edge_m_ * side.y(), kThickness_m);
            const Eigen::Vector3f way = board.T_world_board * p_board - eye;
            if (caster_.is_blocked(eye, way.normalized(), way.norm())) return false;
        }
        return true;
    }

    std::optional<Eigen::Vector3f> ground_below(const Eigen::Vector3f& p) const {
        constexpr float kAbove_m = 0.25F;
        const Eigen::Vector3f from = p + kAbove_m * Eigen::Vector3f::UnitZ();
        const RayHit hit = caster_.cast(from, -Eigen::Vector3f::UnitZ());
        if (!hit.valid() || hit.t > 2.0F * kAbove_m) return std::nullopt;
        return from - hit.t * Eigen::Vector3f::UnitZ();
    }

    // Returns a board on the plane fitted to 5 x 5 ground points below it, above the highest of
    // them.
    std::optional<LaidMarker> board_on(const Eigen::Vector3f& p) const {
        const auto yaw = static_cast<float>(
            6.283 * base::to_unit(base::hash64(seed_, static_cast<std::int64_t>(boards_.size()))));
        const Eigen::AngleAxisf rotation(yaw, Eigen::Vector3f::UnitZ());
        Eigen::Matrix<float, kBoardPoints, 3> A;
        Eigen::Matrix<float, kBoardPoints, 1> z;
        for (int i = 0; i < kBoardPoints; ++i) {
            const Eigen::Vector3f offset = board_point(i, edge_m_);
            const auto ground = ground_below(p + rotation * offset);
            if (!ground) return std::nullopt;
            A.row(i) << ground->x() - p.x(), ground->y() - p.y(), 1.0F;
            z[i] = ground->z() - p.z();
        }
        const Eigen::Vector3f plane = A.colPivHouseholderQr().solve(z);
        const Eigen::Vector3f normal = Eigen::Vector3f(-plane.x(), -plane.y(), 1).normalized();
        if (normal.z() < kMinSlopeCosine) return std::nullopt;
        const float lift = (z - A * plane).maxCoeff() + kGap_m;
        LaidMarker board;
        board.id = static_cast<int>(boards_.size());
        board.T_world_board.linear() =
            (Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), normal) * rotation)
                .toRotationMatrix();
        board.T_world_board.translation() = p + Eigen::Vector3f(0, 0, plane.z() + lift);
        return board;
    }

    const RayCaster& caster_;
    float edge_m_;
    std::uint64_t seed_;
    std::vector<LaidMarker> boards_;
};

void put_into(Scene& scene, const LaidMarker& marker, const SimulateOptions& options) {
    const markers::TagLayout layout = markers::tag_layout(options.marker_family);
    const float edge_m = edge_of_board_m(options);
    SceneObject object{.name = "tag " + std::to_string(marker.id),
                       .material = Material::Marker,
                       .T_object_world = marker.T_world_board.inverse(),
                       .length_m = edge_m};
    object.tag = markers::tag_image(options.marker_family, marker.id);
    object.cell_m = static_cast<float>(options.marker_size_m / layout.size_cells);
    constexpr float kMeshStep_m = 0.04F;
    add_object(scene, std::move(object), make_box({edge_m, edge_m, kThickness_m}, kMeshStep_m));
}

// Lays boards at this height of the image: first evenly along the path, then in between.
void lay_along(const SimulateOptions& options,
               const types::Rig& rig,
               const DiverMotion& motion,
               double height,
               BoardLayer& layer) {
    constexpr double kSides[] = {0.35, 0.65, 0.5, 0.25, 0.75};  // in shares of the image's width
    const auto wanted = static_cast<std::size_t>(options.num_markers);
    const int num_steps = 2 * options.num_markers;
    for (std::size_t round = 0; round < std::size(kSides); ++round) {
        for (int step = 0; step < num_steps && layer.boards().size() < wanted; ++step) {
            if (round == 0 && step % 2 == 1) continue;
            const double t_s = motion.duration_s() * (step + 1.0) / (num_steps + 1.0);
            const double side =
                kSides[(round + static_cast<std::size_t>(step / 2)) % std::size(kSides)];
            layer.try_at(motion.at(t_s).T_world_imu * rig.T_imu_cam0,
                         camera::unproject(
                             rig.cam0, {side * rig.cam0.width_px, height * rig.cam0.height_px}));
        }
    }
}

}  // namespace

std::vector<LaidMarker> lay_markers(const SimulateOptions& options,
                                    const types::Rig& rig,
                                    const DiverMotion& motion,
                                    const Scene& ground) {
    const RayCaster caster(ground.vertices, ground.triangles);
    BoardLayer layer(caster, edge_of_board_m(options), options.seed);
    for (const double height : {0.5, 0.7, 0.9}) lay_along(options, rig, motion, height, layer);
    const auto wanted = static_cast<std::size_t>(options.num_markers);
    if (layer.boards().size() < wanted)
        throw Error(
            ErrorCode::InvalidArgument,
            "there is room for only " + std::to_string(layer.boards().size()) + " of " +
                std::to_string(wanted) +
                " markers on the visible ground: choose fewer or smaller ones, or a longer path");
    return layer.boards();
}

std::vector<LaidMarker> unmoved_markers(const std::vector<LaidMarker>& markers,
                                        const SimulateOptions& options,
                                        const Scene& before,
                                        const Scene& after) {
    constexpr float kAbove_m = 0.5F;
    constexpr float kSame_m = 0.002F;
    const RayCaster caster_before(before.vertices, before.triangles);
    const RayCaster caster_after(after.vertices, after.triangles);
    const float edge_m = edge_of_board_m(options);
    std::vector<LaidMarker> unmoved;
    for (const LaidMarker& marker : markers) {
        bool same = true;
        for (int i = 0; i < kBoardPoints; ++i) {
            const Eigen::Vector3f from =
                marker.T_world_board * board_point(i, edge_m) + kAbove_m * Eigen::Vector3f::UnitZ();
            const RayHit first = caster_before.cast(from, -Eigen::Vector3f::UnitZ());
            const RayHit second = caster_after.cast(from, -Eigen::Vector3f::UnitZ());
            same =
                same && first.valid() && second.valid() && std::abs(first.t - second.t) < kSame_m;
        }
        if (same) unmoved.push_back(marker);
    }
    return unmoved;
}

void put_markers(const std::vector<LaidMarker>& markers,
                 const SimulateOptions& options,
                 Scene& scene) {
    for (const LaidMarker& marker : markers) put_into(scene, marker, options);
}

Eigen::Vector3d middle_world(const LaidMarker& marker) {
    return (marker.T_world_board * Eigen::Vector3f(0, 0, 0.5F * kThickness_m)).cast<double>();
}

dive::MarkerPlan plan_of(const std::vector<LaidMarker>& markers, const SimulateOptions& options) {
    dive::MarkerPlan plan{.family = options.marker_family, .size_m = options.marker_size_m};
    for (std::size_t i = 0; i < markers.size(); ++i)
        for (std::size_t j = i + 1; j < std::min(markers.size(), i + 3); ++j)
            plan.scale_bars.push_back(
                {.name = std::to_string(markers[i].id) + " - " + std::to_string(markers[j].id),
                 .from = {markers[i].id, std::nullopt},
                 .to = {markers[j].id, std::nullopt},
                 .distance_m = (middle_world(markers[i]) - middle_world(markers[j])).norm()});
    return plan;
}

}  // namespace divemesh::simulator
