#include "worker/evaluation/surface_index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <embree3/rtcore.h>
#include <limits>
#include <memory>
#include <new>

#include "schemas/error.hpp"

namespace divemesh::evaluation {
namespace {

// Points whose search starts from the distance of the one before.
constexpr std::size_t kRun = 64;
constexpr float kMargin_m = 1e-3F;  // of rounding errors

bool find_nearest(RTCPointQueryFunctionArguments* arguments) {
    const auto& mesh = *static_cast<const types::Mesh*>(arguments->userPtr);
    const auto& triangle = mesh.triangles[arguments->primID];
    const Eigen::Vector3f point(arguments->query->x, arguments->query->y, arguments->query->z);
    const float distance = std::sqrt(squared_distance_to_triangle(
        point, mesh.vertices[triangle[0]], mesh.vertices[triangle[1]], mesh.vertices[triangle[2]]));
    if (distance >= arguments->query->radius) return false;
    arguments->query->radius = distance;
    return true;  // the radius shrank
}

}  // namespace

// Embree's handles and the mesh they index.
struct SurfaceIndex::Implementation {
    const types::Mesh& mesh;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
};

SurfaceIndex::SurfaceIndex(const types::Mesh& mesh, bool is_compact)
    : implementation_(std::make_unique<Implementation>(Implementation{mesh})) {
    auto& [source, device, scene] = *implementation_;
    device = rtcNewDevice(nullptr);
    if (device == nullptr) {
        if (rtcGetDeviceError(nullptr) == RTC_ERROR_UNSUPPORTED_CPU)
            throw Error(ErrorCode::Unavailable, "Embree cannot start on this processor");
        throw std::bad_alloc();
    }
    scene = rtcNewScene(device);
    rtcSetSceneFlags(
        scene, is_compact ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_ROBUST);
    if (!mesh.triangles.empty()) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        void* vertices = rtcSetNewGeometryBuffer(geometry,
                                                 RTC_BUFFER_TYPE_VERTEX,
                                                 0,
                                                 RTC_FORMAT_FLOAT3,
                                                 sizeof(Eigen::Vector3f),
                                                 mesh.vertices.size());
        void* triangles = rtcSetNewGeometryBuffer(geometry,
                                                  RTC_BUFFER_TYPE_INDEX,
                                                  0,
                                                  RTC_FORMAT_UINT3,
                                                  sizeof mesh.triangles[0],
                                                  mesh.triangles.size());
        std::uninitialized_copy(
            mesh.vertices.begin(), mesh.vertices.end(), static_cast<Eigen::Vector3f*>(vertices));
        std::memcpy(
            triangles, mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);
}

SurfaceIndex::~SurfaceIndex() {
    if (implementation_->scene != nullptr) rtcReleaseScene(implementation_->scene);
    if (implementation_->device != nullptr) rtcReleaseDevice(implementation_->device);
}

float SurfaceIndex::distance_m(const Eigen::Vector3f& point, float max_m) const {
    RTCPointQuery query{};
    query.x = point.x();
    query.y = point.y();
    query.z = point.z();
    query.radius = max_m;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(implementation_->scene,
                  &query,
                  &context,
                  find_nearest,
                  const_cast<types::Mesh*>(&implementation_->mesh));  // not modified
    return query.radius;
}

std::vector<double> SurfaceIndex::distances_m(const std::vector<Eigen::Vector3f>& points,
                                              int num_threads,
                                              const base::ProgressShare& progress) const {
    std::vector<double> distances(points.size());
    const std::size_t num_runs = (points.size() + kRun - 1) / kRun;
    base::for_each_index(num_threads, num_runs, progress, [&](std::size_t run) {
        const std::size_t end = std::min(points.size(), (run + 1) * kRun);
        float max_m = std::numeric_limits<float>::infinity();
        for (std::size_t i = run * kRun; i < end; ++i) {
            const float found_m = distance_m(points[i], max_m);
            distances[i] = static_cast<double>(found_m);
            // The next point is at most as much farther as it is away from this one.
            if (i + 1 < end) max_m = found_m + (points[i + 1] - points[i]).norm() + kMargin_m;
        }
    });
    return distances;
}

std::optional<float> SurfaceIndex::first_hit_m(const Eigen::Vector3f& origin,
                                               const Eigen::Vector3f& direction) const {
    RTCRayHit ray{};
    ray.ray.org_x = origin.x();
    ray.ray.org_y = origin.y();
    ray.ray.org_z = origin.z();
    ray.ray.dir_x = direction.x();
    ray.ray.dir_y = direction.y();
    ray.ray.dir_z = direction.z();
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = ~0U;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(implementation_->scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return ray.ray.tfar;
}

namespace {

types::Mesh as_triangles(const types::Mesh& cloud) {
    types::Mesh points;
    points.vertices = cloud.vertices;
    for (std::uint32_t i = 0; i < cloud.vertices.size(); ++i) points.triangles.push_back({i, i, i});
    return points;
}

}  // namespace

PointIndex::PointIndex(const types::Mesh& cloud) : points_(as_triangles(cloud)), index_(points_) {}

float squared_distance_to_triangle(const Eigen::Vector3f& point,
                                   const Eigen::Vector3f& a,
                                   const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c) {
    const Eigen::Vector3f ab = b - a;
    const Eigen::Vector3f ac = c - a;
    const Eigen::Vector3f ap = point - a;
    const float d1 = ab.dot(ap);
    const float d2 = ac.dot(ap);
    if (d1 <= 0.0F && d2 <= 0.0F) return ap.squaredNorm();  // corner a
    const Eigen::Vector3f bp = point - b;
    const float d3 = ab.dot(bp);
    const float d4 = ac.dot(bp);
    if (d3 >= 0.0F && d4 <= d3) return bp.squaredNorm();  // corner b
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F && d1 - d3 > 0.0F)  // edge ab
        return (ap - d1 / (d1 - d3) * ab).squaredNorm();
    const Eigen::Vector3f cp = point - c;
    const float d5 = ab.dot(cp);
    const float d6 = ac.dot(cp);
    if (d6 >= 0.0F && d5 <= d6) return cp.squaredNorm();  // corner c
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F && d2 - d6 > 0.0F)  // edge ac
        return (ap - d2 / (d2 - d6) * ac).squaredNorm();
    const float va = d3 * d6 - d5 * d4;
    const float along = d4 - d3;
    const float back = d5 - d6;
    if (va <= 0.0F && along >= 0.0F && back >= 0.0F && along + back > 0.0F)  // edge bc
        return (bp - along / (along + back) * (c - b)).squaredNorm();
    const float denominator = va + vb + vc;
    if (denominator <= 0.0F) return ap.squaredNorm();  // no area
    return (ap - vb / denominator * ab - vc / denominator * ac).squaredNorm();
}

}  // namespace divemesh::evaluation
