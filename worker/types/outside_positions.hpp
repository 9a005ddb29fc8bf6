#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/enum_text.hpp"

namespace divemesh::types {

// How a position of the rig was measured.
enum class PositionKind : std::uint8_t {
    GpsFloat,   // GPS of a float at the surface that the diver tows
    Usbl,       // acoustic positioning from a ship
    SurfaceFix  // GPS while the rig is at the surface
};

inline constexpr EnumText<PositionKind> kPositionKindTexts[] = {
    {PositionKind::GpsFloat, "gps_float"},
    {PositionKind::Usbl, "usbl"},
    {PositionKind::SurfaceFix, "surface_fix"}};

// One measured position. `utm_m` is easting, northing and height above the datum of the source.
struct PositionSample {
    std::int64_t timestamp_ns = 0;
    Eigen::Vector3d utm_m = Eigen::Vector3d::Zero();
    double sigma_h_m = 0.0;  // of easting and northing, each
    double sigma_v_m = 0.0;  // of the height; 0: it was not measured
};

// The positions of one instrument.
struct PositionSource {
    std::string name;  // of its folder: position0
    PositionKind kind = PositionKind::Usbl;
    int epsg = 0;                                                // in which it was stated
    Eigen::Vector3d p_imu_instrument = Eigen::Vector3d::Zero();  // m
    double offset_sigma_m = 0.0;          // of a horizontal offset that all of its rows share
    std::vector<PositionSample> samples;  // ascending
};

// One velocity over ground (DVL), in the axes of the instrument.
struct VelocitySample {
    std::int64_t timestamp_ns = 0;
    Eigen::Vector3d velocity_instrument = Eigen::Vector3d::Zero();  // m/s
    double sigma_m_s = 0.0;                                         // of each axis
};

// A marker whose position is known.
struct ControlPoint {
    std::string name;
    int marker_id = 0;                                // at its centre
    Eigen::Vector3d utm_m = Eigen::Vector3d::Zero();  // as PositionSample::utm_m
    double sigma_h_m = 0.0;
    double sigma_v_m = 0.0;  // 0: the height was not measured
};

// What other instruments than the cameras tell of where the dive took place.
struct OutsidePositions {
    int utm_epsg = 0;  // of all `utm_m`; 0: there are none
    std::vector<PositionSource> sources;
    std::vector<ControlPoint> control_points;
    int control_points_epsg = 0;             // in which they were stated
    std::vector<VelocitySample> velocities;  // ascending
    Eigen::Isometry3d T_imu_dvl = Eigen::Isometry3d::Identity();

    bool empty() const { return sources.empty() && control_points.empty() && velocities.empty(); }
};

}  // namespace divemesh::types
