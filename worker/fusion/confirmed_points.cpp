#include "worker/fusion/confirmed_points.hpp"

#include <algorithm>
#include <utility>

#include "worker/base/parallel.hpp"

namespace divemesh::fusion {
namespace {

constexpr std::size_t kPointsAtOnce = std::size_t{1} << 18;
constexpr std::size_t kSlice = 4096;  // points per task of a thread

}  // namespace

ConfirmedPoints::ConfirmedPoints(const PointOctree& points, const Volume& volume, int num_threads)
    : points_(points) {
    confirmed_.reserve(static_cast<std::size_t>(points.num_points()));
    std::vector<std::pair<Eigen::Vector3i, PointLeaf>> batch;
    batch.reserve(kPointsAtOnce);
    const auto ask = [&] {
        std::vector<std::uint8_t> answers(batch.size());
        base::for_each_index(
            num_threads, (batch.size() + kSlice - 1) / kSlice, [&](std::size_t slice) {
                const std::size_t begin = slice * kSlice;
                std::vector<Eigen::Vector3d> places;
                for (std::size_t i = begin; i < std::min(begin + kSlice, batch.size()); ++i)
                    places.push_back(points.position(batch[i].first, batch[i].second));
                volume.confirm(places, answers.data() + begin);
            });
        volume.trim();
        num_confirmed_ += std::count(answers.begin(), answers.end(), 1);
        confirmed_.insert(confirmed_.end(), answers.begin(), answers.end());
        batch.clear();
    };
    points.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        batch.emplace_back(cell, leaf);
        if (batch.size() == kPointsAtOnce) ask();
    });
    ask();
}

void ConfirmedPoints::for_each(
    const std::function<void(const Eigen::Vector3f& p_world, const types::Color&)>& visit) const {
    std::size_t i = 0;
    points_.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        if (confirmed_[i++]) visit(points_.position(cell, leaf).cast<float>(), leaf_color(leaf));
    });
}

}  // namespace divemesh::fusion
