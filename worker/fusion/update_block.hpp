#pragma once

#include <Eigen/Core>

#include "worker/base/instructions.hpp"
#include "worker/fusion/depth_ranges.hpp"
#include "worker/fusion/tsdf_block.hpp"
#include "worker/fusion/tsdf_view.hpp"

namespace divemesh::fusion {

// Where a block is: where the view saw a surface, or all of it before what the view saw.
enum class BlockPlace { Near, Before };

// Moves the samples of the block that begins at lattice point `first` toward what the view saw.
// What lies before all surfaces can only be carved: what is free in it already is left alone.
// `ranges` are those of the view. Every instruction set gives the same bytes.
void update_block(const TsdfView& view,
                  const DepthRanges& ranges,
                  const Eigen::Vector3i& first,
                  BlockPlace place,
                  TsdfBlock& block,
                  base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::fusion
