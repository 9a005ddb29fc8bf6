#include "worker/compare/co_register.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "schemas/error.hpp"
#include "worker/compare/height_spread.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::compare {
namespace {

constexpr double kMinAgreement = 0.6;
constexpr double kMinOverlap = 0.1;  // of the smaller surface
constexpr double kMinGround_m2 = 0.5;
constexpr double kMinAmbiguousShare = 0.85;  // of the agreement of the best one
constexpr double kApart_m = 0.3;
constexpr double kMinHeightSpread =
    0.003;  // mean square of the normals' tilt in the flattest direction
constexpr double kMaxShareOfHeightSpread =
    0.15;  // max difference of surfaces that are aligned by shape alone
constexpr double kGroundCell_m = 0.05;
constexpr std::size_t kFitPoints = 20000;
constexpr double kAfterFeatures_m = 0.12;
constexpr double kAfterHeights_m = 0.35;

using Column = std::pair<int, int>;

// Returns one point per cube, the first of each, with cubes large enough for few points.
types::Mesh thinned(const types::Mesh& mesh, double spacing_m) {
    for (double cube_m = 2.0 * spacing_m;; cube_m *= 1.25) {
        std::set<std::array<int, 3>> cubes;
        types::Mesh few;
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            std::array<int, 3> cube{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                cube[axis] = static_cast<int>(std::floor(
                    static_cast<double>(mesh.vertices[i][static_cast<Eigen::Index>(axis)]) /
                    cube_m));
            if (!cubes.insert(cube).second) continue;
            if (few.vertices.size() == kFitPoints) break;
            few.vertices.push_back(mesh.vertices[i]);
            few.normals.push_back(mesh.normals[i]);
            if (!mesh.sigma_m.empty()) few.sigma_m.push_back(mesh.sigma_m[i]);
        }
        if (few.vertices.size() < kFitPoints) return few;
    }
}

std::set<Column> ground_of(const types::Mesh& mesh) {
    std::set<Column> ground;
    for (const Eigen::Vector3f& p : mesh.vertices)
        ground.emplace(static_cast<int>(std::floor(static_cast<double>(p.x()) / kGroundCell_m)),
                       static_cast<int>(std::floor(static_cast<double>(p.y()) / kGroundCell_m)));
    return ground;
}

Column column_of(const Eigen::Vector3d& p) {
    return {static_cast<int>(std::floor(p.x() / kGroundCell_m)),
            static_cast<int>(std::floor(p.y() / kGroundCell_m))};
}

double typical_sigma_m(const types::Mesh& mesh) {
    return static_cast<double>(stats::upper_median(mesh.sigma_m));
}

class Registrar {
public:
    Registrar(const types::Mesh& a, const types::Mesh& b, const CoRegisterOptions& options)
        : options_(options),
          a_(a),
          few_b_(thinned(b, options.spacing_m)),
          grid_a_(a.vertices, static_cast<float>(3.0 * options.spacing_m)),
          grid_b_(few_b_.vertices, static_cast<float>(3.0 * options.spacing_m)),
          ground_a_(ground_of(a)),
          ground_b_m2_(area_m2(ground_of(b))),
          tolerance_m_(std::max({0.015,
                                 1.5 * options.spacing_m,
                                 3.0 * std::hypot(typical_sigma_m(a), typical_sigma_m(b))})) {}

    std::optional<CoRegistration> fit(const CoarseAlignment& guess) const {
        const bool coarse = guess.method == "geometry";
        auto result = point_to_plane_icp(points_of(a_, grid_a_),
                                         points_of(few_b_, grid_b_),
                                         guess.T_a_b,
                                         {.tolerance_m = tolerance_m_,
                                          .max_step_m = coarse ? kAfterHeights_m : kAfterFeatures_m,
                                          .max_rounds = options_.max_icp_rounds,
                                          .num_threads = options_.num_threads});
        if (!result) return std::nullopt;
        result->method = guess.method;
        check_fit(*result);
        return result;
    }

    bool holds(const CoRegistration& fit) const { return reason_against(fit).empty(); }

    std::string reason_against(const CoRegistration& fit) const {
        char text[280] = "";
        const double ground_m2 = fit.overlap * ground_b_m2_;
        const double smaller_m2 = std::min(ground_b_m2_, area_m2(ground_a_));
        if (ground_m2 < std::max(kMinGround_m2, kMinOverlap * smaller_m2))
            std::snprintf(text,
                          sizeof text,
                          "they share only %.2f m2 of ground, %.0f %% of the smaller one",
                          ground_m2,
                          100.0 * ground_m2 / std::max(1e-9, smaller_m2));
        else if (fit.agreement < kMinAgreement)
            std::snprintf(text,
                          sizeof text,
                          "only %.0f %% of the shared ground agrees within %.0f mm",
                          100.0 * fit.agreement,
                          1e3 * fit.tolerance_m);
        else if (fit.method == "geometry" &&
                 fit.difference_m > kMaxShareOfHeightSpread * fit.height_spread_m)
            std::snprintf(text,
                          sizeof text,
                          "the shape alone does not fit: the surfaces differ by %.0f mm on ground "
                          "with a height range of %.0f mm",
                          1e3 * fit.difference_m,
                          1e3 * fit.height_spread_m);
        else if (fit.outcome.failed() || fit.outcome.still_moving())
            std::snprintf(text,
                          sizeof text,
                          "%s after %d rounds of ICP (%.1f standard deviations)",
                          fit.outcome.message.c_str(),
                          fit.outcome.num_iterations,
                          fit.outcome.last_step_sigmas);
        return text;
    }

    // Returns whether the shape of the ground alone determines the position of b.
    bool has_height_spread() const {
        Eigen::Matrix3d leans = Eigen::Matrix3d::Zero();
        for (const Eigen::Vector3f& n : few_b_.normals) {
            const Eigen::Vector3d normal = n.cast<double>();
            leans += normal * normal.transpose();
        }
        leans /= static_cast<double>(std::max<std::size_t>(1, few_b_.normals.size()));
        return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(leans).eigenvalues()(0) >
               kMinHeightSpread;
    }

private:
    static SurfacePoints points_of(const types::Mesh& mesh, const PointGrid& grid) {
        return {mesh.vertices, mesh.normals, mesh.sigma_m, grid};
    }
    static double area_m2(const std::set<Column>& ground) {
        return static_cast<double>(ground.size()) * kGroundCell_m * kGroundCell_m;
    }

    void check_fit(CoRegistration& fit) const {
        std::size_t num_over = 0;
        std::vector<Eigen::Vector3d> on;
        std::vector<double> off_m;
        for (const Eigen::Vector3f& vertex : few_b_.vertices) {
            const Eigen::Vector3d p = fit.T_a_b * vertex.cast<double>();
            if (!ground_a_.contains(column_of(p))) continue;
            ++num_over;
            const auto nearest = grid_a_.nearest(
                p.cast<float>(), static_cast<float>(tolerance_m_ + options_.spacing_m));
            if (!nearest) continue;
            const double off =
                a_.normals[*nearest].cast<double>().dot(p - a_.vertices[*nearest].cast<double>());
            if (std::abs(off) >= tolerance_m_) continue;
            on.push_back(p);
            off_m.push_back(off);
        }
        fit.tolerance_m = tolerance_m_;
        fit.overlap = static_cast<double>(num_over) /
                      static_cast<double>(std::max<std::size_t>(1, few_b_.vertices.size()));
        fit.agreement = static_cast<double>(on.size()) /
                        static_cast<double>(std::max<std::size_t>(1, num_over));
        fit.difference_m = percentile_80(std::move(off_m));
        fit.height_spread_m = height_spread_m(on);
    }

    const CoRegisterOptions& options_;
    const types::Mesh& a_;
    types::Mesh few_b_;
    PointGrid grid_a_;
    PointGrid grid_b_;
    std::set<Column> ground_a_;
    double ground_b_m2_;
    double tolerance_m_;
};

[[noreturn]] void refuse(const std::string& reason, const std::string& without_vertical) {
    const std::string failed = "the two reconstructions cannot be aligned: " + reason;
    if (!without_vertical.empty())
        throw Error(ErrorCode::Conflict,
                    failed + ". The likely cause is that no sensor tells which way is up in " +
                        without_vertical +
                        ", so the models may lie tilted to each other. Place three markers that "
                        "both dives see, or record an IMU, an AHRS or a depth sensor");
    throw Error(ErrorCode::Conflict,
                failed +
                    ". Compare dives that show the same ground, or place markers there that both "
                    "dives see");
}

bool elsewhere(const CoRegistration& p, const CoRegistration& q) {
    return (p.T_a_b * (q.T_a_b.inverse() * q.pivot) - q.pivot).norm() > kApart_m;
}

// Aligns by shape alone. `of_features` says what became of the image features.
CoRegistration fit_heights(const Registrar& registrar,
                           const std::vector<CoarseAlignment>& coarse_alignments,
                           const std::string& of_features,
                           const std::string& without_vertical) {
    const auto refuse_after_features = [&](const std::string& reason) {
        refuse(of_features + ", and " + reason, without_vertical);
    };
    if (!registrar.has_height_spread())
        refuse_after_features("the ground is too flat to be aligned by its shape");
    std::vector<CoRegistration> fits;
    for (const CoarseAlignment& guess : coarse_alignments)
        if (const auto fit = registrar.fit(guess)) fits.push_back(*fit);
    std::ranges::stable_sort(fits, [&](const CoRegistration& p, const CoRegistration& q) {
        const bool first = registrar.holds(p);
        return first != registrar.holds(q) ? first : p.agreement > q.agreement;
    });
    if (fits.empty()) refuse_after_features("the shape of the ground does not match");
    const CoRegistration& best = fits.front();
    if (!registrar.holds(best)) refuse_after_features(registrar.reason_against(best));
    for (const CoRegistration& other : fits)
        if (registrar.holds(other) && elsewhere(best, other) &&
            other.agreement > kMinAmbiguousShare * best.agreement)
            refuse_after_features("the shape of the ground fits in two places");
    return best;
}

}  // namespace

CoRegistration co_register(const types::Mesh& a,
                           const types::Mesh& b,
                           const CoRegisterOptions& options,
                           const base::ProgressShare& progress) {
    const Registrar registrar(a, b, options);
    progress.at(0.1);
    for (const CoarseAlignment& guess : options.known)
        if (const auto fit = registrar.fit(guess); fit && registrar.holds(*fit)) return *fit;
    std::string of_features = "no image features match";
    for (const CoarseAlignment& guess : align_by_features(a, b, options.seed)) {
        progress.at(0.4);
        const auto fit = registrar.fit(guess);
        if (fit && registrar.holds(*fit)) return *fit;
        of_features =
            "image features match, but there " +
            (fit ? registrar.reason_against(*fit) : "too few points of the surfaces meet");
    }
    progress.at(0.5);
    const auto coarse_alignments = align_by_heights(a, b, options.num_threads);
    progress.at(0.8);
    return fit_heights(registrar, coarse_alignments, of_features, options.without_vertical);
}

}  // namespace divemesh::compare
