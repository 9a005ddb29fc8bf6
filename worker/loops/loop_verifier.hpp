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

// Whether two keyframes show the same place, by geometry: descriptors agree on one rigid motion,
// and with it landmarks of each are found again in the other, all over the picture.
class LoopVerifier {
public:
    // Refers to all of them.
    LoopVerifier(const types::RectifiedRig& rig,
                 const std::vector<types::Keyframe>& keyframes,
                 const std::vector<types::Landmark>& landmarks,
                 const keyframes::KeyframeStore& store);

    // From nothing but what the two look like.
    std::optional<Loop> verify(std::size_t from, std::size_t to, std::uint64_t seed);
    // From a guess of the motion between them, to some pixels, as they are when the pictures have
    // been halved `num_halvings` times.
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
    std::vector<std::vector<Seen>> seen_;    // by each keyframe
    std::map<std::size_t, cv::Mat> images_;  // the last ones used
};

}  // namespace divemesh::loops
