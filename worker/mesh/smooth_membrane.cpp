#include "worker/mesh/smooth_membrane.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/base/hashed_random.hpp"
#include "worker/base/parallel.hpp"

namespace divemesh::mesh {
namespace {

constexpr float kMinSigma_voxels = 0.5F;
// Deviation of the surface from the mean of a vertex's neighbours. With twice as much 1.3 points of
// F1 at 10 mm are lost on the tank and half a point on the barge.
constexpr float kRoughness_voxels = 0.1F;
constexpr float kMaxReach = 12.0F;  // voxels over which noise is smoothed
constexpr int kNumIterations = 45;  // 1 % of the way remains at that reach
constexpr float kMaxMove_sigmas = 3.0F;
constexpr std::size_t kSlice = 2048;  // vertices per task of a thread

// Points have a zero as fourth component, so that one is loaded at once.
using Points = std::vector<Eigen::Vector4f>;

class Membrane {
public:
    Membrane(const types::Mesh& mesh, int num_threads) : mesh_(mesh), num_threads_(num_threads) {
        choose();
        link();
    }

    // Vertices of the mesh: first those that move, then their neighbours that do not.
    const std::vector<std::uint32_t>& vertices() const { return vertices_; }
    std::size_t num_moving() const { return pulls_.size(); }
    bool on_border(std::size_t i) const { return on_border_[i]; }  // of those that move

    // Returns smoothed values of vertices(); those that do not move keep theirs.
    Points smoothed(const Points& values) const;

private:
    void choose();
    void link();
    void keep_single(std::size_t i);
    template <typename Work>
    void for_each_moving(const Work& work) const;  // work(index in vertices())

    const types::Mesh& mesh_;
    int num_threads_;
    std::vector<std::uint32_t> vertices_;
    std::vector<bool> on_border_;
    std::vector<float> pulls_;                    // towards the neighbours, 0 to 1
    std::vector<std::uint32_t> neighbours_;       // in vertices()
    std::vector<std::uint32_t> first_neighbour_;  // of each that moves
    std::vector<std::uint32_t> end_neighbour_;
};

// Chooses the vertices with a large enough sigma. For an inner vertex the surrounding triangles
// enter each neighbour as often as they leave it, so the balance is 0. Hashed numbers are used
// because at borders plain vertex numbers may cancel, which happens where two parts of the surface
// meet in a vertex.
void Membrane::choose() {
    std::vector<std::uint64_t> balance(mesh_.vertices.size(), 0);
    for (const auto& triangle : mesh_.triangles)
        for (int k = 0; k < 3; ++k)
            balance[triangle[k]] +=
                base::hash64(triangle[(k + 1) % 3]) - base::hash64(triangle[(k + 2) % 3]);
    for (std::uint32_t i = 0; i < mesh_.vertices.size(); ++i) {
        const float sigma_voxels = mesh_.sigma_m[i] / mesh_.voxel_m[i];
        if (sigma_voxels <= kMinSigma_voxels) continue;
        on_border_.push_back(balance[i] != 0);
        const float reach = std::min(kMaxReach, sigma_voxels / kRoughness_voxels);
        vertices_.push_back(i);
        pulls_.push_back(1.0F / (1.0F + 1.0F / (reach * reach)));
    }
}

// Links each neighbour once, as the next vertex in a triangle. A border vertex is linked only to
// border vertices, or the surface would shrink: these are next or last in a triangle, not both.
void Membrane::link() {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> index(mesh_.vertices.size(), kNone);
    for (std::uint32_t i = 0; i < vertices_.size(); ++i) index[vertices_[i]] = i;
    const auto for_each_link = [&](const auto& visit) {
        for (const auto& triangle : mesh_.triangles)
            for (int k = 0; k < 3; ++k)
                if (const std::uint32_t i = index[triangle[k]]; i < num_moving()) {
                    visit(i, triangle[(k + 1) % 3]);
                    if (on_border_[i]) visit(i, triangle[(k + 2) % 3]);
                }
    };
    first_neighbour_.assign(num_moving() + 2, 0);
    for_each_link([&](std::uint32_t i, std::uint32_t) { ++first_neighbour_[i + 2]; });
    for (std::size_t i = 2; i < first_neighbour_.size(); ++i)
        first_neighbour_[i] += first_neighbour_[i - 1];
    neighbours_.resize(first_neighbour_.back());
    // first_neighbour_[i + 1] advances from the start to the end of i's neighbours.
    for_each_link([&](std::uint32_t i, std::uint32_t vertex) {
        if (index[vertex] == kNone) {
            index[vertex] = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(vertex);
        }
        neighbours_[first_neighbour_[i + 1]++] = index[vertex];
    });
    end_neighbour_.assign(first_neighbour_.begin() + 1, first_neighbour_.end());
    for (std::size_t i = 0; i < num_moving(); ++i)
        if (on_border_[i]) keep_single(i);
}

void Membrane::keep_single(std::size_t i) {
    const auto begin = neighbours_.begin() + first_neighbour_[i];
    const auto end = neighbours_.begin() + end_neighbour_[i];
    std::sort(begin, end);
    auto kept = begin;
    for (auto at = begin; at != end;) {
        const auto next = std::upper_bound(at, end, *at);
        if (next - at == 1) *kept++ = *at;
        at = next;
    }
    end_neighbour_[i] = static_cast<std::uint32_t>(kept - neighbours_.begin());
}

template <typename Work>
void Membrane::for_each_moving(const Work& work) const {
    const std::size_t num_slices = (num_moving() + kSlice - 1) / kSlice;
    base::for_each_index(num_threads_, num_slices, [&](std::size_t slice) {
        const std::size_t end = std::min(num_moving(), (slice + 1) * kSlice);
        for (std::size_t i = slice * kSlice; i < end; ++i) work(i);
    });
}

Points Membrane::smoothed(const Points& values) const {
    Points now = values;
    Points before = values;
    constexpr float kRadius = 1.0F / (1.0F + 1.0F / (kMaxReach * kMaxReach));
    float acceleration = 1.0F;
    for (int iteration = 0; iteration < kNumIterations; ++iteration) {
        if (iteration == 1) acceleration = 1.0F / (1.0F - 0.5F * kRadius * kRadius);
        if (iteration > 1) acceleration = 1.0F / (1.0F - 0.25F * kRadius * kRadius * acceleration);
        for_each_moving([&](std::size_t i) {
            const std::uint32_t begin = first_neighbour_[i], end = end_neighbour_[i];
            if (begin == end) return;
            Eigen::Vector4f mean = Eigen::Vector4f::Zero();
            for (std::uint32_t k = begin; k < end; ++k) mean += now[neighbours_[k]];
            mean /= static_cast<float>(end - begin);
            const Eigen::Vector4f step = values[i] + pulls_[i] * (mean - values[i]);
            before[i] += acceleration * (step - before[i]);
        });
        before.swap(now);
    }
    return now;
}

// Returns the area-weighted normal of each vertex, not of unit length.
std::vector<Eigen::Vector3f> normals_by_area(const types::Mesh& mesh) {
    std::vector<Eigen::Vector3f> sums(mesh.vertices.size(), Eigen::Vector3f::Zero());
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3f normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                           .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        for (const std::uint32_t vertex : t) sums[vertex] += normal;
    }
    return sums;
}

Points smoothed_twice(const Membrane& membrane, const Points& measured) {
    Points places = membrane.smoothed(measured);
    Points rest(measured.size());
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = measured[i] - places[i];
    rest = membrane.smoothed(rest);
    for (std::size_t i = 0; i < places.size(); ++i) places[i] += rest[i];
    return places;
}

}  // namespace

void smooth_membrane(types::Mesh& mesh, int num_threads) {
    if (mesh.sigma_m.empty() || mesh.voxel_m.empty()) return;
    const Membrane membrane(mesh, num_threads);
    const auto& vertices = membrane.vertices();
    Points measured;
    measured.reserve(vertices.size());
    for (const std::uint32_t vertex : vertices)
        measured.emplace_back(mesh.vertices[vertex].homogeneous()).w() = 0.0F;
    const Points places = smoothed_twice(membrane, measured);
    for (std::size_t i = 0; i < membrane.num_moving(); ++i)
        mesh.vertices[vertices[i]] = places[i].head<3>();
    const auto normals = normals_by_area(mesh);
    for (std::size_t i = 0; i < membrane.num_moving(); ++i) {
        const std::uint32_t vertex = vertices[i];
        const Eigen::Vector3f normal = normals[vertex].stableNormalized();
        Eigen::Vector3f shift = (places[i] - measured[i]).head<3>();
        if (membrane.on_border(i)) shift = normal * normal.dot(shift);
        const float farthest = kMaxMove_sigmas * mesh.sigma_m[vertex];
        if (shift.norm() > farthest) shift *= farthest / shift.norm();
        mesh.vertices[vertex] = measured[i].head<3>() + shift;
        if (!mesh.normals.empty() && normal.norm() > 0.5F) mesh.normals[vertex] = normal;
    }
}

}  // namespace divemesh::mesh
