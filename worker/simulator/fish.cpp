#include "worker/simulator/fish.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kSecondsPerFish = 4.0;

Fish::Shape::Part make_part(const Eigen::Isometry3d& T_world_part, const Eigen::Vector3d& radii_m) {
    const Eigen::Matrix3d R_part_world = T_world_part.linear().transpose();
    return {(radii_m.cwiseInverse().asDiagonal() * R_part_world).cast<float>(),
            T_world_part.translation().cast<float>()};
}

// Returns the colour of a fish: bands across the body, a dark eye, a pale belly. `q` runs from -1
// to 1 along each axis.
Rgb fish_color(const Eigen::Vector3f& q, bool is_tail, std::uint64_t seed) {
    const auto hue = static_cast<float>(base::to_unit(seed));
    const Rgb bright = Rgb(0.75F, 0.65F, 0.15F) * (1.0F - hue) + Rgb(0.35F, 0.55F, 0.8F) * hue;
    if (is_tail) return 0.9F * bright;
    const Eigen::Vector2f eye(q.x() - 0.72F, q.z() - 0.2F);
    if (eye.norm() < 0.1F) return {0.02F, 0.02F, 0.02F};
    const float bands = 2.0F + 3.0F * static_cast<float>(base::to_unit(base::hash64(seed, 1)));
    const float wave = std::sin(bands * std::numbers::pi_v<float> * q.x() + 0.6F * q.z());
    const float dark = std::clamp(2.5F * wave + 0.2F, 0.0F, 1.0F);
    const Rgb belly = q.z() < -0.5F ? Rgb(0.25F, 0.25F, 0.25F) : Rgb(0.0F, 0.0F, 0.0F);
    return (bright * (1.0F - 0.85F * dark) + belly).min(0.95F);
}

}  // namespace

std::vector<Fish> Fish::make_school(const DiverMotion& motion,
                                    double duration_s,
                                    const Eigen::Vector3d& look_imu,
                                    double density,
                                    std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x66697368ULL));
    std::vector<Fish> school;
    const double seconds_per_fish = kSecondsPerFish / density;
    const int num_fish = 1 + static_cast<int>(duration_s / seconds_per_fish);
    for (int i = 0; i < num_fish; ++i) {
        const double t_s = (i + random.uniform(0.1, 0.9)) * seconds_per_fish;
        const Eigen::Isometry3d T_world_imu = motion.at(t_s).T_world_imu;
        Fish fish;
        fish.center_world_ = T_world_imu * (random.uniform(0.9, 1.4) * look_imu);
        fish.center_world_.z() += random.uniform(0.0, 0.25);
        fish.radius_x_m_ = random.uniform(0.2, 0.6);
        fish.radius_y_m_ = random.uniform(0.2, 0.6);
        fish.rise_m_ = random.uniform(0.0, 0.06);
        fish.rate_ = (random.next() % 2 ? 1.0 : -1.0) * random.uniform(0.35, 0.8);
        fish.phase_ = random.uniform(0.0, 2.0 * std::numbers::pi);
        fish.length_m_ = random.uniform(0.12, 0.26);
        fish.seed_ = random.next();
        school.push_back(fish);
    }
    return school;
}

Fish::Shape Fish::at(double t_s) const {
    const double angle = rate_ * t_s + phase_;
    const Eigen::Vector3d position =
        center_world_ + Eigen::Vector3d(radius_x_m_ * std::cos(angle),
                                        radius_y_m_ * std::sin(angle),
                                        rise_m_ * std::sin(1.7 * angle));
    const Eigen::Vector3d velocity =
        rate_ * Eigen::Vector3d(-radius_x_m_ * std::sin(angle), radius_y_m_ * std::cos(angle), 0.0);
    const double beat = 2.0 * std::numbers::pi * 1.8 * t_s + phase_;
    const double heading = std::atan2(velocity.y(), velocity.x()) + 0.08 * std::sin(beat);
    Eigen::Isometry3d T_world_fish = Eigen::Isometry3d::Identity();
    T_world_fish.translation() = position;
    T_world_fish.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Isometry3d T_fish_tail = Eigen::Isometry3d::Identity();
    T_fish_tail.rotate(Eigen::AngleAxisd(0.45 * std::sin(beat - 1.0), Eigen::Vector3d::UnitZ()));
    T_fish_tail.pretranslate(Eigen::Vector3d(-0.42 * length_m_, 0.0, 0.0));
    T_fish_tail.translate(Eigen::Vector3d(-0.12 * length_m_, 0.0, 0.0));

    Shape shape;
    shape.parts = {
        make_part(T_world_fish, length_m_ * Eigen::Vector3d(0.45, 0.09, 0.2)),
        make_part(T_world_fish * T_fish_tail, length_m_ * Eigen::Vector3d(0.13, 0.015, 0.15))};
    shape.center_world = position.cast<float>();
    shape.radius_m = static_cast<float>(0.75 * length_m_);
    shape.seed = seed_;
    return shape;
}

std::optional<Fish::Hit> Fish::intersect(const Shape& shape,
                                         const Eigen::Vector3f& origin,
                                         const Eigen::Vector3f& direction) {
    std::optional<Hit> nearest;
    for (std::size_t i = 0; i < shape.parts.size(); ++i) {
        const Shape::Part& part = shape.parts[i];
        const Eigen::Vector3f o = part.unit_world * (origin - part.center_world);
        const Eigen::Vector3f d = part.unit_world * direction;
        const float a = d.squaredNorm();
        const float b = o.dot(d);
        const float root2 = b * b - a * (o.squaredNorm() - 1.0F);
        if (root2 < 0.0F) continue;
        const float t = (-b - std::sqrt(root2)) / a;
        if (t <= 0.0F || (nearest && nearest->t <= t)) continue;
        const Eigen::Vector3f q = o + t * d;
        nearest = Hit{
            t, (part.unit_world.transpose() * q).normalized(), fish_color(q, i > 0, shape.seed)};
    }
    return nearest;
}

}  // namespace divemesh::simulator
