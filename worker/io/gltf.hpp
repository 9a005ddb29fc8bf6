#pragma once

// Constants of glTF 2.0 that reader and writer share.
namespace divemesh::io {

// componentType of an accessor
inline constexpr int kGltfByte = 5120;
inline constexpr int kGltfUnsignedByte = 5121;
inline constexpr int kGltfShort = 5122;
inline constexpr int kGltfUnsignedShort = 5123;
inline constexpr int kGltfUnsignedInt = 5125;
inline constexpr int kGltfFloat = 5126;

inline constexpr int kGltfTriangles = 4;  // mode of a primitive

inline constexpr const char* kGltfMeshopt = "EXT_meshopt_compression";

}  // namespace divemesh::io
