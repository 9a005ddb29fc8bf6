#pragma once

namespace divemesh::stereo {

// The min sigma of a measured disparity, px: errors of calibration, interpolation and slant.
inline constexpr float kMinSigma_px = 0.15F;

}  // namespace divemesh::stereo
