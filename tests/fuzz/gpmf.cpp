#include "tests/fuzz/input.hpp"
#include "worker/video/gpmf_gps.hpp"
#include "worker/video/gpmf_imu.hpp"

// Fuzzes the telemetry of a video: two payloads of the same bytes, at times that do not rise.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    const auto duration_ns = static_cast<std::int64_t>(input.choice(3)) * 1'000'000'000;
    const std::string bytes(input.rest());
    const auto imu =
        divemesh::video::imu_of({{2'000'000'000, duration_ns, bytes}, {0, duration_ns, bytes}});
    for (std::size_t i = 0; i < imu.samples.size(); ++i)
        if (!imu.samples[i].angular_velocity_imu.allFinite() ||
            (i > 0 && imu.samples[i].timestamp_ns < imu.samples[i - 1].timestamp_ns))
            __builtin_trap();
    const auto position = divemesh::video::gps_position_of({{0, duration_ns, bytes}});
    if (position && !position->position.is_valid()) __builtin_trap();
    return 0;
}
