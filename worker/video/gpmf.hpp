#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// GoPro's metadata format: keys of four characters with typed values, nested, big-endian, each
// filled up to 4 bytes. Written after its description at github.com/gopro/gpmf-parser.
namespace divemesh::video {

// A packet of a video's telemetry.
struct GpmfPayload {
    std::int64_t stamp_ns = 0;
    std::int64_t duration_ns = 0;
    std::string bytes;
};

// The samples of a sensor with three axes in one payload, scaled, in the camera's axes X, Y, Z.
struct GpmfSamples {
    std::vector<Eigen::Vector3d> values;
    std::optional<std::int64_t> num_until_here;  // TSMP: since the recording began
};

// The motion sensors of a payload.
struct GpmfMotion {
    GpmfSamples gyroscope;      // rad/s
    GpmfSamples accelerometer;  // m/s^2, specific force
    bool is_damaged = false;    // a length contradicts the bytes there are; what is before is used
};

GpmfMotion parse_gpmf(std::string_view bytes);

}  // namespace divemesh::video
