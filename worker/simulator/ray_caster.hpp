#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <embree3/rtcore.h>
#include <memory>
#include <vector>

namespace divemesh::simulator {

// The first intersection of a ray with the surface, at origin + t * direction.
struct RayHit {
    static constexpr std::uint32_t kNone = 0xffffffffU;
    float t = 0.0F;
    float u = 0.0F;  // weights of the triangle's second and third corner
    float v = 0.0F;
    std::uint32_t triangle = kNone;

    bool valid() const { return triangle != kNone; }
};

// Intersects rays with triangles, by Embree, which keeps a copy. Thread-safe.
class RayCaster {
public:
    struct Ray {
        Eigen::Vector3f origin;
        Eigen::Vector3f direction;
    };
    using Rays4 = std::array<Ray, 4>;

    RayCaster(const std::vector<Eigen::Vector3f>& vertices,
              const std::vector<std::array<std::uint32_t, 3>>& triangles);

    RayHit cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
    // Casts four neighbouring rays at once, which is twice as fast.
    std::array<RayHit, 4> cast4(const Rays4& rays) const;
    bool is_blocked(const Eigen::Vector3f& origin,
                    const Eigen::Vector3f& direction,
                    float far) const;

private:
    struct Release {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    std::unique_ptr<RTCDeviceTy, Release> device_;
    std::unique_ptr<RTCSceneTy, Release> scene_;
};

}  // namespace divemesh::simulator
