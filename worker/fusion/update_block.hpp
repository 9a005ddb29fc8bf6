#pragma once

#include <Eigen/Core>

#include "worker/base/instructions.hpp"
#include "worker/fusion/depth_ranges.hpp"
#include "worker/fusion/tsdf_block.hpp"
#include "worker/fusion/tsdf_view.hpp"

namespace divemesh::fusion {

// The place of a block in a view: near a surface that the view saw, or all of it in front of it.
enum class BlockPlace { Near, Before };

// Integrates the view into the samples of the block that begins at lattice point `first`. A block
// in front of all surfaces can only be carved: samples that are free already are left alone.
// `ranges` are those of the view. Every instruction set gives the same bytes.
void update_block(const TsdfView& view,
                  const DepthRanges& ranges,
                  const Eigen::Vector3i& first,
                  BlockPlace place,
                  TsdfBlock& block,
                  base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::fusion
