#include "worker/simulator/lay_markers.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "schemas/error.hpp"
#include "worker/simulator/hashed_random.hpp"
#include "worker/simulator/ray_caster.hpp"

namespace divemesh::worker {
namespace {

constexpr float kThickness_m = 0.004F;
constexpr float kGap_m = 0.01F;       // between the board and the highest ground under it
constexpr float kFarthest_m = 2.2F;   // from the camera
constexpr float kLeastCosine = 0.5F;  // between the board's normal and the way to the camera
constexpr float kSteepest_cosine = 0.7F;

struct Board {
    Eigen::Isometry3f T_world_board = Eigen::Isometry3f::Identity();
    Eigen::Vector3d middle_world() const {
        return (T_world_board * Eigen::Vector3f(0, 0, 0.5F * kThickness_m)).cast<double>();
    }
};

class BoardLayer {
public:
    BoardLayer(const RayCaster& caster, float edge_m, std::uint64_t seed)
        : caster_(caster), edge_m_(edge_m), seed_(seed) {}

    const std::vector<Board>& boards() const { return boards_; }

    // Where this ray of the camera meets the ground, if there is room and it is seen well.
    void try_at(const Eigen::Isometry3d& T_world_cam, const Eigen::Vector3d& ray_cam) {
        const Eigen::Vector3f eye = T_world_cam.translation().cast<float>();
        const Eigen::Vector3f ray = (T_world_cam.linear() * ray_cam).normalized().cast<float>();
        const RayHit hit = caster_.cast(eye, ray);
        if (!hit.valid() || hit.t > kFarthest_m) return;
        const Eigen::Vector3f p = eye + hit.t * ray;
        for (const Board& board : boards_)
            if ((board.T_world_board.translation() - p).norm() < 2.0F * edge_m_) return;
        const auto board = board_on(p);
        if (!board) return;
        const Eigen::Vector3f to_eye = (eye - board->T_world_board.translation()).normalized();
        if (board->T_world_board.linear().col(2).dot(to_eye) < kLeastCosine ||
            !is_in_sight(*board, eye))
            return;
        boards_.push_back(*board);
    }

private:
    bool is_in_sight(const Board& board, const Eigen::Vector3f& eye) const {
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

    // On the plane through the ground at 5 x 5 points below it, above the highest of them.
    std::optional<Board> board_on(const Eigen::Vector3f& p) const {
        const auto yaw = static_cast<float>(
            6.283 * to_unit(hash64(seed_, static_cast<std::int64_t>(boards_.size()))));
        const Eigen::AngleAxisf turn(yaw, Eigen::Vector3f::UnitZ());
        Eigen::Matrix<float, 25, 3> A;
        Eigen::Matrix<float, 25, 1> z;
        for (int i = 0; i < 25; ++i) {
            const Eigen::Vector3f offset(0.25F * edge_m_ * static_cast<float>(i % 5 - 2),
                                         0.25F * edge_m_ * static_cast<float>(i / 5 - 2),
                                         0);
            const auto ground = ground_below(p + turn * offset);
            if (!ground) return std::nullopt;
            A.row(i) << ground->x() - p.x(), ground->y() - p.y(), 1.0F;
            z[i] = ground->z() - p.z();
        }
        const Eigen::Vector3f plane = A.colPivHouseholderQr().solve(z);
        const Eigen::Vector3f normal = Eigen::Vector3f(-plane.x(), -plane.y(), 1).normalized();
        if (normal.z() < kSteepest_cosine) return std::nullopt;
        const float lift = (z - A * plane).maxCoeff() + kGap_m;
        Board board;
        board.T_world_board.linear() =
            (Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), normal) * turn)
                .toRotationMatrix();
        board.T_world_board.translation() = p + Eigen::Vector3f(0, 0, plane.z() + lift);
        return board;
    }

    const RayCaster& caster_;
    float edge_m_;
    std::uint64_t seed_;
    std::vector<Board> boards_;
};

void put_into(
    Scene& scene, const Board& board, int id, const SimulateOptions& options, float edge_m) {
    const TagLayout layout = tag_layout(options.marker_family);
    SceneObject object{.name = "tag " + std::to_string(id),
                       .material = Material::Marker,
                       .T_object_world = board.T_world_board.inverse(),
                       .length_m = edge_m};
    object.tag = tag_picture(options.marker_family, id);
    object.cell_m = static_cast<float>(options.marker_size_m / layout.size_cells);
    constexpr float kPiece_m = 0.04F;
    add_object(scene, std::move(object), make_box({edge_m, edge_m, kThickness_m}, kPiece_m));
}

}  // namespace

MarkerPlan lay_markers(const SimulateOptions& options,
                       const Rig& rig,
                       const DiverMotion& motion,
                       Scene& scene) {
    const TagLayout layout = tag_layout(options.marker_family);
    // One cell of white around the picture of the tag.
    const auto edge_m =
        static_cast<float>(options.marker_size_m * (layout.total_cells + 2) / layout.size_cells);
    const RayCaster caster(scene.vertices, scene.triangles);
    BoardLayer layer(caster, edge_m, options.seed);
    const auto wanted = static_cast<std::size_t>(options.num_markers);
    constexpr double kSides[] = {0.35, 0.65, 0.5, 0.25, 0.75};  // of the picture's width
    const int num_steps = 2 * options.num_markers;
    for (std::size_t round = 0; round < std::size(kSides); ++round) {
        for (int step = 0; step < num_steps && layer.boards().size() < wanted; ++step) {
            if (round == 0 && step % 2 == 1) continue;  // evenly along the way first
            const double t_s = motion.duration_s() * (step + 1.0) / (num_steps + 1.0);
            const double side =
                kSides[(round + static_cast<std::size_t>(step / 2)) % std::size(kSides)];
            layer.try_at(motion.at(t_s).T_world_imu * rig.T_imu_cam0,
                         rig.cam0.unproject({side * rig.cam0.width_px, 0.5 * rig.cam0.height_px}));
        }
    }
    if (layer.boards().size() < wanted)
        throw Error(ErrorCode::InvalidArgument,
                    "there is room for " + std::to_string(layer.boards().size()) + " of " +
                        std::to_string(wanted) +
                        " markers on what is seen: choose fewer, smaller ones or a longer path");
    MarkerPlan plan{.family = options.marker_family, .size_m = options.marker_size_m};
    const auto& boards = layer.boards();
    for (std::size_t i = 0; i < boards.size(); ++i) {
        put_into(scene, boards[i], static_cast<int>(i), options, edge_m);
        for (std::size_t j = i + 1; j < std::min(boards.size(), i + 3); ++j)
            plan.scale_bars.push_back(
                {.name = std::to_string(i) + " - " + std::to_string(j),
                 .from = {static_cast<int>(i), std::nullopt},
                 .to = {static_cast<int>(j), std::nullopt},
                 .distance_m = (boards[i].middle_world() - boards[j].middle_world()).norm()});
    }
    return plan;
}

}  // namespace divemesh::worker
