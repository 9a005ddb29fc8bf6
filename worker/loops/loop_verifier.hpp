#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "worker/keyframes/keyframe_store.hpp"
#include "worker/loops/loop.hpp"
#include "worker/loops/search_by_projection.hpp"
#include "worker/loops/stored_keypoints.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"

namespace divemesh::loops {

// The verification by geometry that two keyframes show the same place: their descriptors agree on
// one rigid motion, and with it landmarks of each are found again in the other, spread over the
// image.
class LoopVerifier {
public:
    // Keeps references to all arguments.
    LoopVerifier(const types::RectifiedRig& rig,
                 const std::vector<types::Keyframe>& keyframes,
                 const std::vector<types::Landmark>& landmarks,
                 const keyframes::KeyframeStore& store);

    // Returns the loop found from the appearance alone; nullopt if the places differ.
    std::optional<Loop> verify(std::size_t from, std::size_t to, std::uint64_t seed);
    // Returns the loop found from a guess of the relative pose that is accurate to some pixels in
    // images halved `num_halvings` times; nullopt if it is not confirmed.
    std::optional<Loop> measure(std::size_t from,
                                std::size_t to,
                                const Eigen::Isometry3d& T_to_from,
                                int num_halvings = 0);

private:
    struct Seen {
        std::size_t landmark = 0;
        types::LandmarkObservation observation;
    };
    cv::Mat image(std::size_t keyframe);
    std::vector<KnownPoint> known_points(std::size_t keyframe) const;
    std::vector<Reobservation> reobservations(const types::Features& found,
                                              std::size_t of,
                                              std::size_t in) const;

    const types::RectifiedRig& rig_;
    const std::vector<types::Keyframe>& keyframes_;
    const std::vector<types::Landmark>& landmarks_;
    const keyframes::KeyframeStore& store_;
    StoredKeypoints views_;
    std::vector<std::vector<Seen>> seen_;    // landmarks by keyframe
    std::map<std::size_t, cv::Mat> images_;  // most recently used images
};

}  // namespace divemesh::loops
