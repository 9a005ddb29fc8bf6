#include "worker/fusion/confirmed_points.hpp"

#include <algorithm>
#include <span>

#include "worker/base/parallel.hpp"

namespace divemesh::fusion {
namespace {

constexpr std::size_t kPointsAtOnce = std::size_t{1} << 18;
constexpr std::size_t kSlice = 4096;  // points per task of a thread

}  // namespace

ConfirmedPoints::ConfirmedPoints(const std::deque<PointOctree>& points,
                                 const Volume& volume,
                                 int num_threads)
    : points_(points) {
    std::vector<Eigen::Vector3d> places;
    places.reserve(kPointsAtOnce);
    const auto ask = [&] {
        std::vector<std::uint8_t> answers(places.size());
        base::for_each_index(
            num_threads, (places.size() + kSlice - 1) / kSlice, [&](std::size_t slice) {
                const std::size_t begin = slice * kSlice;
                const std::size_t num = std::min(kSlice, places.size() - begin);
                volume.confirm(std::span(places).subspan(begin, num), answers.data() + begin);
            });
        volume.trim();
        num_confirmed_ += std::count(answers.begin(), answers.end(), 1);
        confirmed_.insert(confirmed_.end(), answers.begin(), answers.end());
        places.clear();
    };
    for (const PointOctree& octree : points)
        octree.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
            places.push_back(octree.position(cell, leaf));
            if (places.size() == kPointsAtOnce) ask();
        });
    ask();
}

void ConfirmedPoints::for_each(
    const std::function<void(const Eigen::Vector3f& p_world, const types::Color&)>& visit) const {
    std::size_t i = 0;
    for (const PointOctree& octree : points_)
        octree.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
            if (confirmed_[i++]) visit(octree.position(cell, leaf).cast<float>(), leaf_color(leaf));
        });
}

}  // namespace divemesh::fusion
