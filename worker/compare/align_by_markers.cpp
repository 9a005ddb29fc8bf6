#include "worker/base/horn.hpp"
#include "worker/compare/coarse_alignment.hpp"

namespace divemesh::compare {
namespace {

constexpr double kMoved_m = 0.1;

struct Shared {
    std::vector<Eigen::Vector3d> a;
    std::vector<Eigen::Vector3d> b;
};

Shared shared_markers(const std::vector<MarkerPosition>& a, const std::vector<MarkerPosition>& b) {
    Shared shared;
    for (const MarkerPosition& of_a : a)
        for (const MarkerPosition& of_b : b)
            if (of_a.id == of_b.id && of_a.family == of_b.family) {
                shared.a.push_back(of_a.p_world);
                shared.b.push_back(of_b.p_world);
            }
    return shared;
}

Shared unmoved(const Shared& all, const Eigen::Isometry3d& T_a_b) {
    Shared some;
    for (std::size_t i = 0; i < all.a.size(); ++i)
        if ((T_a_b * all.b[i] - all.a[i]).norm() < kMoved_m) {
            some.a.push_back(all.a[i]);
            some.b.push_back(all.b[i]);
        }
    return some;
}

}  // namespace

std::vector<CoarseAlignment> align_by_markers(const std::vector<MarkerPosition>& a,
                                              const std::vector<MarkerPosition>& b) {
    const Shared all = shared_markers(a, b);
    const auto first = base::absolute_orientation(all.b, all.a);
    if (!first) return {};
    const Shared some = unmoved(all, first->T_b_a);
    const auto second = base::absolute_orientation(some.b, some.a);
    if (!second) return {};
    return {{second->T_b_a, "markers", static_cast<double>(some.a.size())}};
}

}  // namespace divemesh::compare
