#include "worker/simulator/ray_caster.hpp"

#include <cstring>
#include <memory>

#include "schemas/error.hpp"

namespace divemesh::simulator {
namespace {

constexpr float kNear = 1e-3F;
constexpr float kFar = 1e4F;

}  // namespace

RayCaster::RayCaster(const std::vector<Eigen::Vector3f>& vertices,
                     const std::vector<std::array<std::uint32_t, 3>>& triangles)
    // Uses all threads: a device's limit would apply to every parallel loop of the process. The
    // tree, and so the result of ties on shared edges, does not depend on their number.
    : device_(rtcNewDevice(nullptr)), scene_(device_ ? rtcNewScene(device_.get()) : nullptr) {
    if (!scene_) throw Error(ErrorCode::Unavailable, "Embree does not start: is memory exhausted?");
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    void* points = rtcSetNewGeometryBuffer(geometry,
                                           RTC_BUFFER_TYPE_VERTEX,
                                           0,
                                           RTC_FORMAT_FLOAT3,
                                           sizeof(Eigen::Vector3f),
                                           vertices.size());
    void* indices = rtcSetNewGeometryBuffer(geometry,
                                            RTC_BUFFER_TYPE_INDEX,
                                            0,
                                            RTC_FORMAT_UINT3,
                                            sizeof(std::array<std::uint32_t, 3>),
                                            triangles.size());
    if (!points || !indices)
        throw Error(ErrorCode::Unavailable, "not enough memory for the scene's triangles");
    std::uninitialized_copy(
        vertices.begin(), vertices.end(), static_cast<Eigen::Vector3f*>(points));
    std::memcpy(indices, triangles.data(), triangles.size() * sizeof(triangles[0]));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene_.get());
}

RayHit RayCaster::cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
    RTCRayHit query{};
    query.ray.org_x = origin.x();
    query.ray.org_y = origin.y();
    query.ray.org_z = origin.z();
    query.ray.dir_x = direction.x();
    query.ray.dir_y = direction.y();
    query.ray.dir_z = direction.z();
    query.ray.tnear = kNear;
    query.ray.tfar = kFar;
    query.ray.mask = 0xffffffffU;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_.get(), &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return {query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID};
}

std::array<RayHit, 4> RayCaster::cast4(const Rays4& rays) const {
    alignas(16) static constexpr std::array<int, 4> kAll = {-1, -1, -1, -1};
    RTCRayHit4 query{};
    for (std::size_t i = 0; i < 4; ++i) {
        const auto& [origin, direction] = rays[i];
        query.ray.org_x[i] = origin.x();
        query.ray.org_y[i] = origin.y();
        query.ray.org_z[i] = origin.z();
        query.ray.dir_x[i] = direction.x();
        query.ray.dir_y[i] = direction.y();
        query.ray.dir_z[i] = direction.z();
        query.ray.tnear[i] = kNear;
        query.ray.tfar[i] = kFar;
        query.ray.mask[i] = 0xffffffffU;
        query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect4(kAll.data(), scene_.get(), &context, &query);
    std::array<RayHit, 4> hits;
    for (std::size_t i = 0; i < 4; ++i)
        if (query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
            hits[i] = {query.ray.tfar[i], query.hit.u[i], query.hit.v[i], query.hit.primID[i]};
    return hits;
}

bool RayCaster::is_blocked(const Eigen::Vector3f& origin,
                           const Eigen::Vector3f& direction,
                           float far) const {
    RTCRay ray{};
    ray.org_x = origin.x();
    ray.org_y = origin.y();
    ray.org_z = origin.z();
    ray.dir_x = direction.x();
    ray.dir_y = direction.y();
    ray.dir_z = direction.z();
    ray.tnear = kNear;
    ray.tfar = far;
    ray.mask = 0xffffffffU;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_.get(), &context, &ray);
    return ray.tfar < 0.0F;
}

}  // namespace divemesh::simulator
