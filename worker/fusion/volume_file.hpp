#pragma once

#include <cstdint>

#include "worker/base/binary_file.hpp"
#include "worker/fusion/tsdf_volume.hpp"

namespace divemesh::fusion {

// The first bytes of a saved volume: its kind and version; its settings follow.
inline constexpr std::uint32_t kTsdfMagic = 0x33545344;    // "DST3"
inline constexpr std::uint32_t kOctreeMagic = 0x32434f44;  // "DOC2"

inline void put_volume_header(base::BinaryWriter& file,
                              std::uint32_t magic,
                              const VolumeSettings& settings) {
    const types::RectifiedRig& rig = settings.rig;
    file.put(magic);
    file.put(rig.width_px);
    file.put(rig.height_px);
    for (const double value : {rig.focal_px,
                               rig.cx_px,
                               rig.cy_px,
                               rig.baseline_m,
                               settings.voxel_m,
                               settings.max_depth_m})
        file.put(value);
    file.put_raw(rig.T_imu_cam.matrix());
}

// Reads what follows the magic number.
inline VolumeSettings get_volume_settings(base::BinaryReader& file) {
    VolumeSettings settings;
    types::RectifiedRig& rig = settings.rig;
    rig.width_px = file.get<int>();
    rig.height_px = file.get<int>();
    for (double* value : {&rig.focal_px,
                          &rig.cx_px,
                          &rig.cy_px,
                          &rig.baseline_m,
                          &settings.voxel_m,
                          &settings.max_depth_m})
        *value = file.get<double>();
    rig.T_imu_cam.matrix() = file.get<Eigen::Matrix4d>();
    return settings;
}

}  // namespace divemesh::fusion
