#include "tests/bench/compared_place.hpp"

#include <algorithm>
#include <numbers>

#include "worker/base/hashed_random.hpp"
#include "worker/base/parallel.hpp"

namespace divemesh::bench {
namespace {

using base::hash64;
using base::to_unit;

constexpr double kStep_m = 0.005;
constexpr double kNoise_m = 0.0015;
constexpr double kSquare_m = 0.7;  // that each colony stands in
constexpr double kAltitude_m = 1.5;
constexpr double kBetweenEyes_m = 0.4;

double random_at(std::uint64_t seed, double x, double y) {
    return to_unit(hash64(
        seed, static_cast<std::int64_t>(std::floor(x)), static_cast<std::int64_t>(std::floor(y))));
}

// Value noise: random at whole places, blended between them.
double blended(std::uint64_t seed, double x, double y) {
    const double u = x - std::floor(x);
    const double v = y - std::floor(y);
    const auto at = [&](double dx, double dy) { return random_at(seed, x + dx, y + dy); };
    return (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(1, 0)) +
           v * ((1.0 - u) * at(0, 1) + u * at(1, 1));
}

}  // namespace

ComparedPlace::ComparedPlace(unsigned seed, std::size_t num_vertices)
    : seed_(seed),
      half_x_m_(std::sqrt(static_cast<double>(num_vertices)) * kStep_m),
      half_y_m_(0.25 * half_x_m_),
      num_along_(std::max(1, static_cast<int>(2.0 * half_x_m_ / kSquare_m))),
      num_across_(std::max(1, static_cast<int>(2.0 * half_y_m_ / kSquare_m))),
      ground_(synthetic::rough_ground(seed)) {
    base::RandomRow random(hash64(seed, 1U));
    for (int row = 0; row < num_across_; ++row)
        for (int column = 0; column < num_along_; ++column) {
            const double radius_m = random.uniform(0.06, 0.18);
            const double middle_m = 0.5 * kSquare_m;
            const double off_m = middle_m - 0.2;
            Colony colony{
                -half_x_m_ + kSquare_m * column + middle_m + random.uniform(-off_m, off_m),
                -half_y_m_ + kSquare_m * row + middle_m + random.uniform(-off_m, off_m),
                radius_m,
                {random.uniform(0.5, 1.0) * radius_m, 0.0}};
            colony.height_m[1] = colony.height_m[0];
            const double fate = random.uniform(0.0, 1.0);
            if (fate < 0.1) colony.height_m[0] = 0.0;
            if (fate > 0.9) colony.height_m[1] = 0.0;
            if (fate > 0.7 && fate <= 0.9) colony.height_m[1] *= 1.4;
            colonies_.push_back(colony);
        }
}

const ComparedPlace::Colony& ComparedPlace::colony_near(double x, double y) const {
    const int column = std::clamp(static_cast<int>((x + half_x_m_) / kSquare_m), 0, num_along_ - 1);
    const int row = std::clamp(static_cast<int>((y + half_y_m_) / kSquare_m), 0, num_across_ - 1);
    return colonies_[static_cast<std::size_t>(row * num_along_ + column)];
}

double ComparedPlace::height_m(double x, double y, int year) const {
    const Colony& colony = colony_near(x, y);
    const double share = std::hypot(x - colony.x_m, y - colony.y_m) / colony.radius_m;
    return ground_(x, y) + colony.height_m[year - 1] * std::max(0.0, 1.0 - share * share);
}

double ComparedPlace::brightness(double x, double y) const {
    return 40.0 + 90.0 * blended(hash64(seed_, 2U), x / 0.03, y / 0.03) +
           90.0 * blended(hash64(seed_, 3U), x / 0.11, y / 0.11);
}

double ComparedPlace::change_m3(double sign) const {
    double sum = 0.0;
    for (const Colony& colony : colonies_)  // paraboloids
        sum += 0.5 * std::numbers::pi * colony.radius_m * colony.radius_m *
               std::max(0.0, sign * (colony.height_m[1] - colony.height_m[0]));
    return sum;
}

Eigen::Isometry3d ComparedPlace::T_model_place(int year) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(heading_rad(year), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    if (year != 1) T.translation() = Eigen::Vector3d(2.0, -1.0, 0.4);
    return T;
}

types::Mesh ComparedPlace::model(int year) const {
    const auto columns = static_cast<std::uint32_t>(2.0 * half_x_m_ / kStep_m);
    const auto rows = static_cast<std::uint32_t>(2.0 * half_y_m_ / kStep_m);
    const std::size_t num = std::size_t{rows} * columns;
    const Eigen::Isometry3d T = T_model_place(year);
    types::Mesh mesh;
    mesh.vertices.resize(num);
    mesh.normals.resize(num);
    mesh.colors.resize(num);
    mesh.sigma_m.assign(num, static_cast<float>(kNoise_m));
    base::for_each_index(0, rows, [&](std::size_t row) {
        for (std::uint32_t column = 0; column < columns; ++column) {
            const std::size_t i = row * columns + column;
            base::RandomRow random(hash64(seed_, year, i));
            const double x = -half_x_m_ + kStep_m * (column + random.uniform(0.1, 0.9));
            const double y = -half_y_m_ + kStep_m * (static_cast<double>(row) + 0.5);
            const double z = height_m(x, y, year);
            constexpr double kSmall_m = 1e-4;
            const Eigen::Vector3d normal = Eigen::Vector3d(z - height_m(x + kSmall_m, y, year),
                                                           z - height_m(x, y + kSmall_m, year),
                                                           kSmall_m)
                                               .normalized();
            const Eigen::Vector3d p =
                Eigen::Vector3d(x, y, z) + kNoise_m * random.gaussian() * normal;
            mesh.vertices[i] = (T * p).cast<float>();
            mesh.normals[i] = (T.linear() * normal).cast<float>();
            mesh.colors[i].fill(static_cast<std::uint8_t>(
                std::clamp(brightness(x, y) + 4.0 * random.gaussian(), 0.0, 255.0)));
        }
    });
    for (std::uint32_t row = 0; row + 1 < rows; ++row)
        for (std::uint32_t column = 0; column + 1 < columns; ++column) {
            const std::uint32_t i = row * columns + column;
            mesh.triangles.push_back({i, i + 1, i + columns});
            mesh.triangles.push_back({i + 1, i + columns + 1, i + columns});
        }
    return mesh;
}

std::vector<Eigen::Vector3d> ComparedPlace::eyes(int year) const {
    std::vector<Eigen::Vector3d> places;
    for (double y = -half_y_m_; y <= half_y_m_; y += kBetweenEyes_m)
        for (double x = -half_x_m_; x <= half_x_m_; x += kBetweenEyes_m)
            places.push_back(T_model_place(year) * Eigen::Vector3d(x, y, kAltitude_m));
    return places;
}

}  // namespace divemesh::bench
