#include "worker/optimisation/sliding_window.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "worker/stats/median.hpp"

namespace divemesh::optimisation {
namespace {

constexpr std::size_t kNumApart = 7;             // keyframes with motion between them
constexpr std::size_t kMaxWindowKeyframes = 12;  // including those where the camera stood still
constexpr int kMaxIterations = 6;
constexpr double kOutlier = 5.0;              // in sigmas, per measurement
constexpr double kExact = 0.0;                // sigma of a scale that so short a time cannot tell
constexpr double kVelocityAtRest_m_s = 0.01;  // sigma; a rest may hide so slow a motion
constexpr double kMinShift = 0.002;  // of the image width, median; below it the camera stands still
const Eigen::Vector3d kLandmarkSigma_px = 0.5 * types::kFeatureSigma_px;  // of an adjusted landmark

bool seen_at(const types::LandmarkObservation& seen, std::size_t keyframe) {
    return static_cast<std::size_t>(seen.keyframe) == keyframe;
}

bool fits(const types::RectifiedRig& rig,
          const Eigen::Isometry3d& T_cam_world,
          const types::Landmark& landmark,
          const types::LandmarkObservation& seen) {
    const Eigen::Vector3d p_cam = T_cam_world * landmark.p_world;
    if (p_cam.z() < 0.02) return false;
    Eigen::Vector3d error = types::project_px(rig, p_cam) - types::measurement_px(seen);
    if (seen.disparity_px <= 0.0F) error.z() = 0.0;
    return error.cwiseQuotient(types::kFeatureSigma_px).cwiseAbs().maxCoeff() < kOutlier;
}

}  // namespace

void SlidingWindow::add_keyframe(const types::Keyframe& keyframe,
                                 const types::Features& features,
                                 const imu::SensorReadings& readings,
                                 const std::optional<types::MotionSigma>& at_rest) {
    const auto index = static_cast<std::int32_t>(keyframes_.size());
    if (entries_.empty()) reference_->depth_offset_m = readings.depth_m.value_or(0.0);
    Entry entry;
    entry.state = first_state(keyframe, readings);
    entry.readings = readings;
    if (at_rest)
        entry.motion_at_rest = {rig_.T_imu_cam * keyframes_.back().T_world_cam.inverse() *
                                    keyframe.T_world_cam * rig_.T_imu_cam.inverse(),
                                *at_rest};
    for (const types::Feature& feature : features) {
        if (!types::has_depth(feature) && !landmark_of_feature_.contains(feature.id)) continue;
        const std::size_t landmark = landmark_of(feature, keyframe);
        landmarks_[landmark].whole.observations.push_back(
            {index,
             static_cast<float>(feature.pixel.x()),
             static_cast<float>(feature.pixel.y()),
             static_cast<float>(feature.disparity_px)});
        entry.landmarks.push_back(landmark);
    }
    entry.moved = has_moved(entry);
    entries_.push_back(std::move(entry));
    keyframes_.push_back(keyframe);
    // The first state starts with the mean velocity over the first interval.
    if (index == 1) entries_[0].state.velocity_world = entries_[1].state.velocity_world;
}

BodyState SlidingWindow::first_state(const types::Keyframe& keyframe,
                                     const imu::SensorReadings& readings) const {
    BodyState state = BodyState::at(keyframe.T_world_cam * rig_.T_imu_cam.inverse(), {});
    if (entries_.empty()) return state;
    const BodyState& before = entries_.back().state;
    state.bias = before.bias;
    if (readings.motion && chained(entries_.size() - 1))
        state.velocity_world =
            before.velocity_world +
            imu::kGravity_m_s2 * readings.interval_s * reference_->gravity_direction_world +
            before.q_world_imu * readings.motion->delta_velocity;
    else if (readings.interval_s > 0.0)
        state.velocity_world = (state.p_world_imu - before.p_world_imu) / readings.interval_s;
    return state;
}

bool SlidingWindow::has_moved(const Entry& entry) const {
    std::vector<double> shifts;
    for (const std::size_t index : entry.landmarks) {
        const auto& seen = landmarks_[index].whole.observations;
        if (seen.size() < 2 || seen[seen.size() - 2].keyframe + 1 != seen.back().keyframe) continue;
        shifts.push_back(std::hypot(seen.back().u_px - seen[seen.size() - 2].u_px,
                                    seen.back().v_px - seen[seen.size() - 2].v_px));
    }
    if (shifts.empty()) return true;
    return stats::upper_median(std::move(shifts)) > kMinShift * rig_.width_px;
}

std::size_t SlidingWindow::landmark_of(const types::Feature& feature,
                                       const types::Keyframe& keyframe) {
    const auto [known, fresh] = landmark_of_feature_.try_emplace(feature.id, landmarks_.size());
    if (fresh)
        landmarks_.push_back({{keyframe.T_world_cam * types::point_cam(rig_, feature), {}}, 0});
    return known->second;
}

types::SolverOutcome SlidingWindow::adjust() {
    const std::size_t num = keyframes_.size();
    while (oldest_ < first_in_window()) marginalise_oldest();

    BundleAdjustment bundle_adjustment(rig_);
    add_states(bundle_adjustment);
    add_landmarks(bundle_adjustment);
    add_readings(bundle_adjustment);
    types::SolverOutcome outcome = bundle_adjustment.solve_dense(kMaxIterations);
    for (std::size_t k = oldest_; k < num; ++k)
        move_keyframe(k, entries_[k].state.T_world_imu() * rig_.T_imu_cam);
    drop_outliers();
    return outcome;
}

// Gives a keyframe its adjusted pose. A landmark that it alone has seen stays where the keyframe
// saw it, so that the next one finds it there.
void SlidingWindow::move_keyframe(std::size_t k, const Eigen::Isometry3d& T_world_cam) {
    const Eigen::Isometry3d correction = T_world_cam * keyframes_[k].T_world_cam.inverse();
    for (const std::size_t index : entries_[k].landmarks) {
        types::Landmark& landmark = landmarks_[index].whole;
        if (landmark.observations.size() == 1 && seen_at(landmark.observations.front(), k))
            landmark.p_world = correction * landmark.p_world;
    }
    keyframes_[k].T_world_cam = T_world_cam;
}

// Returns the first keyframe of the window. Keyframes without motion do not push out those with
// motion.
std::size_t SlidingWindow::first_in_window() const {
    std::size_t first = entries_.size();
    std::size_t num_apart = 0;
    while (first > oldest_ && num_apart < kNumApart &&
           entries_.size() - first < kMaxWindowKeyframes)
        if (entries_[--first].moved) ++num_apart;
    return first;
}

bool SlidingWindow::chained(std::size_t k) const {
    return k > 0 && (entries_[k].readings.motion || entries_[k].readings.rotation);
}

// Turns the factors that leave with the oldest keyframe into a prior of the remaining blocks. The
// landmarks that it observed leave too. A landmark that the last keyframe still observes is split:
// later observations belong to a new landmark. So no measurement counts twice, and no landmark
// enters the prior.
void SlidingWindow::marginalise_oldest() {
    BundleAdjustment leaving(rig_);
    add_states(leaving);
    BodyState& from = entries_[oldest_].state;
    for (const std::size_t index : entries_[oldest_].landmarks) marginalise_oldest(leaving, index);
    const imu::SensorReadings& readings = entries_[oldest_ + 1].readings;
    add_absolute_factors(leaving, entries_[oldest_].readings, from, *reference_);
    if (oldest_ == 0) add_gravity_prior(leaving, readings, *reference_);
    if (!chained(oldest_)) add_bias_priors(leaving, readings, from);
    add_relative_factors(leaving, readings, noise_, from, entries_[oldest_ + 1].state, *reference_);
    add_zero_velocity(leaving, oldest_);
    add_motion_at_rest(leaving, oldest_ + 1);
    leaving.add_prior(prior_);
    leaving.add_depth_scale(reference_->depth_scale, kExact);
    prior_ = leaving.marginalise({from.q_world_imu.coeffs().data(),
                                  from.p_world_imu.data(),
                                  from.velocity_world.data(),
                                  from.bias.gyroscope.data(),
                                  from.bias.accelerometer.data()});
    ++oldest_;
}

void SlidingWindow::marginalise_oldest(BundleAdjustment& leaving, std::size_t index) {
    types::Landmark& landmark = landmarks_[index].whole;
    std::size_t& first = landmarks_[index].first_in_window;
    const std::size_t num = landmark.observations.size();
    if (first >= num || !seen_at(landmark.observations[first], oldest_)) return;
    const bool goes_on = seen_at(landmark.observations.back(), entries_.size() - 1);
    const std::size_t end = goes_on ? num - 1 : num;
    if (end - first >= 2) add_observations(leaving, landmark, first, end);
    first = end;
}

void SlidingWindow::add_states(BundleAdjustment& bundle_adjustment) {
    for (std::size_t k = oldest_; k < entries_.size(); ++k)
        bundle_adjustment.add_state(entries_[k].state, k == 0);
}

void SlidingWindow::add_observations(BundleAdjustment& bundle_adjustment,
                                     types::Landmark& landmark,
                                     std::size_t first,
                                     std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
        const types::LandmarkObservation& seen = landmark.observations[i];
        bundle_adjustment.add_observation(entries_[static_cast<std::size_t>(seen.keyframe)].state,
                                          landmark.p_world,
                                          types::measurement_px(seen),
                                          types::kFeatureSigma_px);
    }
}

std::vector<std::size_t> SlidingWindow::landmarks_in_window() const {
    std::set<std::size_t> seen;
    for (std::size_t k = oldest_; k < entries_.size(); ++k)
        seen.insert(entries_[k].landmarks.begin(), entries_[k].landmarks.end());
    return {seen.begin(), seen.end()};
}

void SlidingWindow::add_landmarks(BundleAdjustment& bundle_adjustment) {
    for (const std::size_t index : landmarks_in_window()) {
        auto& [landmark, first] = landmarks_[index];
        if (landmark.observations.size() >= first + 2)
            add_observations(bundle_adjustment, landmark, first, landmark.observations.size());
    }
}

void SlidingWindow::add_readings(BundleAdjustment& bundle_adjustment) {
    bundle_adjustment.add_prior(prior_);
    for (std::size_t k = oldest_; k < entries_.size(); ++k) {
        const imu::SensorReadings& readings = entries_[k].readings;
        add_absolute_factors(bundle_adjustment, readings, entries_[k].state, *reference_);
        add_zero_velocity(bundle_adjustment, k);
        if (k == oldest_) continue;  // the factors that lead to it are in the prior
        BodyState& from = entries_[k - 1].state;
        if (k == 1) add_gravity_prior(bundle_adjustment, readings, *reference_);
        if (!chained(k - 1)) add_bias_priors(bundle_adjustment, readings, from);
        add_relative_factors(
            bundle_adjustment, readings, noise_, from, entries_[k].state, *reference_);
        add_motion_at_rest(bundle_adjustment, k);
    }
    bundle_adjustment.add_depth_scale(reference_->depth_scale, kExact);
}

// Only the factors of the accelerometer contain a velocity.
void SlidingWindow::add_zero_velocity(BundleAdjustment& bundle_adjustment, std::size_t k) {
    const bool has_velocity =
        entries_[k].readings.motion || (k + 1 < entries_.size() && entries_[k + 1].readings.motion);
    if (entries_[k].at_rest && has_velocity)
        bundle_adjustment.add_velocity(
            entries_[k].state, Eigen::Vector3d::Zero(), kVelocityAtRest_m_s);
}

void SlidingWindow::add_motion_at_rest(BundleAdjustment& bundle_adjustment, std::size_t k) {
    if (const auto& motion = entries_[k].motion_at_rest)
        bundle_adjustment.add_motion(entries_[k - 1].state,
                                     entries_[k].state,
                                     motion->T_before_imu,
                                     motion->sigma.position_m,
                                     motion->sigma.rotation_rad);
}

void SlidingWindow::drop_outliers() {
    for (const std::size_t index : landmarks_in_window()) {
        auto& [landmark, first] = landmarks_[index];
        auto& seen = landmark.observations;
        const auto in_window = seen.begin() + static_cast<std::ptrdiff_t>(first);
        seen.erase(std::remove_if(
                       in_window,
                       seen.end(),
                       [this, &landmark = landmark](const types::LandmarkObservation& observation) {
                           const auto k = static_cast<std::size_t>(observation.keyframe);
                           return !fits(
                               rig_, keyframes_[k].T_world_cam.inverse(), landmark, observation);
                       }),
                   seen.end());
    }
}

void SlidingWindow::use_landmarks(const Eigen::Isometry3d& T_world_previous,
                                  odometry::PointPairs& pairs) const {
    const Eigen::Isometry3d T_previous_world = T_world_previous.inverse();
    for (odometry::PointPair& pair : pairs) {
        const auto known = landmark_of_feature_.find(pair.id);
        if (known == landmark_of_feature_.end()) continue;
        const types::Landmark& landmark = landmarks_[known->second].whole;
        if (landmark.observations.size() < 2) continue;
        const Eigen::Vector3d p_previous = T_previous_world * landmark.p_world;
        if (p_previous.z() < 0.02) continue;
        pair.p_previous = p_previous;
        pair.previous_px = types::project_px(rig_, p_previous);
        pair.previous_sigma_px = kLandmarkSigma_px;
    }
}

std::vector<types::Landmark> SlidingWindow::landmarks() const {
    std::vector<types::Landmark> result;
    for (const auto& [landmark, first] : landmarks_)
        if (landmark.observations.size() >= 2) result.push_back(landmark);
    return result;
}

}  // namespace divemesh::optimisation
