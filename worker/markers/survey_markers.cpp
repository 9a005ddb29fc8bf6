#include "worker/markers/survey_markers.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "worker/base/text.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/markers/find_tags.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::markers {
namespace {

// Disparity error between a tag's edges, left against right, beyond their noise: rectification and
// lenses are not known better. All lengths of a reconstruction share it.
constexpr double kDisparityBias_px = 0.05;
constexpr std::size_t kPairsAtOnce = 16;
constexpr double kMaxRightDelay_s = 0.001;  // a diver moves by less than half a millimetre

struct KeyframePair {
    std::size_t keyframe = 0;
    types::StereoFrame frame;
    std::vector<TagView> views;
};

void look_at(const camera::Rectifier& rectifier,
             dive::MarkerFamily family,
             const camera::Rerectifier* refined,
             KeyframePair& pair) {
    const types::RectifiedFrame rectified = rectifier.rectify(pair.frame);
    pair.frame = {};
    for (const bool is_right : {false, true}) {
        // The keyframe's pose is not that of a right image which was exposed at another time.
        if (is_right && std::abs(rectified.right_delay_s) > kMaxRightDelay_s) continue;
        for (const Tag& tag : find_tags(is_right ? rectified.right : rectified.left, family)) {
            TagView view{tag.id, pair.keyframe, is_right, tag.corners_px};
            if (refined != nullptr)
                for (Eigen::Vector2d& corner : view.corners_px)
                    corner = refined->forward(is_right ? 1 : 0, corner);
            pair.views.push_back(view);
        }
    }
}

class FindingWriter {
public:
    FindingWriter(const std::vector<TagView>& views,
                  const dive::MarkerPlan& plan,
                  const MarkerWorld& world,
                  MarkerMetrics& metrics)
        : plan_(plan), metrics_(metrics) {
        for (const TagView& view : views)
            keyframes_of_[view.id].insert({world.keyframes[view.keyframe].segment, view.keyframe});
    }

    void write() {
        find_too_few();
        find_rejected();
        find_unmeasured();
        find_inconsistent();
        find_scale_error();
    }

private:
    bool is_located(int id) const {
        return std::any_of(metrics_.markers.begin(),
                           metrics_.markers.end(),
                           [id](const Marker& marker) { return marker.id == id; });
    }

    void warn(const std::string& code, const std::string& message, const std::string& remedy) {
        metrics_.findings.push_back({Severity::Warning, code, "markers.json", message, remedy});
    }

    // Reports tags with too few keyframes. A tag that the plan does not name and that was read only
    // once is probably not a tag, so it is not reported.
    void find_too_few() {
        std::set<int> ids;
        for (const auto& [id, keyframes] : keyframes_of_)
            if (keyframes.size() > 1) ids.insert(id);
        for (const auto& [id, size_m] : plan_.sizes_m) ids.insert(id);
        for (const dive::ScaleBar& bar : plan_.scale_bars) ids.insert({bar.from.id, bar.to.id});
        for (const int id : ids) {
            if (is_located(id)) continue;
            const auto seen = keyframes_of_.find(id);
            const auto num = seen == keyframes_of_.end() ? 0 : seen->second.size();
            warn("marker_seen_too_few",
                 "tag " + std::to_string(id) + " was read in " + std::to_string(num) +
                     " keyframes and is not measured: at least " +
                     std::to_string(kMinMarkerKeyframes) + " must agree on its position",
                 "swim over it slowly and close enough that one cell of the tag covers at least 3 "
                 "pixels");
        }
    }

    void find_rejected() {
        for (const Marker& marker : metrics_.markers)
            if (2 * marker.num_rejected_views > marker.num_views)
                warn("marker_in_two_places",
                     "tag " + std::to_string(marker.id) + " was read in " +
                         std::to_string(marker.num_rejected_views) +
                         " images at another place than in the " +
                         std::to_string(marker.num_views) + " in which it was measured",
                     "check that no tag was moved and that each id is used only once");
    }

    void find_unmeasured() {
        for (const BarMetrics& bar : metrics_.bars)
            if (!bar.measured_m && is_located(bar.from.id) && is_located(bar.to.id))
                warn("scale_bar_in_two_pieces",
                     "scale bar '" + bar.name +
                         "' is not measured: its ends are in segments of the dive that are not "
                         "connected",
                     "keep the scene in view while you swim from one end to the other");
            else if (!bar.measured_m)
                warn("scale_bar_not_measured",
                     "scale bar '" + bar.name + "' is not measured: one of its ends was not found",
                     "see the findings on its tags");
    }

    void find_inconsistent() {
        for (const BarMetrics& bar : metrics_.bars) {
            if (bar.leave_one_out_sigmas() <= 3.0) continue;
            warn("scale_bar_inconsistent",
                 "'" + bar.name + "', stated as " + base::fixed(1e3 * bar.known_m, 1) +
                     " mm, is off by " + base::fixed(1e3 * *bar.leave_one_out_error_m, 1) +
                     " mm when the other known distances set the scale (standard deviation " +
                     base::fixed(1e3 * bar.leave_one_out_sigma_m, 1) + " mm)",
                 "measure it again, and the printed sizes, and state the uncertainty of the "
                 "distances as sigma_m");
        }
    }

    void find_scale_error() {
        if (!metrics_.scale) return;
        const double error = 1.0 / metrics_.scale->factor - 1.0;
        const double sigma = std::hypot(metrics_.scale->sigma, metrics_.systematic_scale_sigma);
        if (std::abs(error) <= 3.0 * sigma) return;
        warn("scale_off",
             "compared with the known distances, measured lengths are " +
                 base::fixed(100.0 * std::abs(error), 2) + " % too " +
                 (error > 0.0 ? "long" : "short") + " (standard deviation " +
                 base::fixed(100.0 * sigma, 2) + " %)",
             "calibrate the rig again in water, above all its baseline, or use --set "
             "correct_scale=on to scale the result by the known distances");
    }

    const dive::MarkerPlan& plan_;
    MarkerMetrics& metrics_;
    std::map<int, std::set<std::pair<std::int32_t, std::size_t>>> keyframes_of_;
};

}  // namespace

std::vector<TagView> find_tags_in(types::Recording& recording,
                                  const std::vector<types::Keyframe>& keyframes,
                                  dive::MarkerFamily family,
                                  const camera::Rerectifier* refined,
                                  const base::ProgressShare& progress,
                                  int num_threads) {
    const camera::Rectifier rectifier(recording, num_threads);
    std::vector<TagView> views;
    std::vector<KeyframePair> pairs;
    const auto search = [&] {
        base::for_each_index(num_threads, pairs.size(), [&](std::size_t i) {
            look_at(rectifier, family, refined, pairs[i]);
        });
        for (const KeyframePair& pair : pairs)
            views.insert(views.end(), pair.views.begin(), pair.views.end());
        pairs.clear();
    };
    recording.rewind();
    std::size_t next = 0;
    while (next < keyframes.size()) {
        progress.at(static_cast<double>(next) / static_cast<double>(keyframes.size()));
        auto frame = recording.next_frame();
        if (!frame) break;
        while (next < keyframes.size() && keyframes[next].frame_index < frame->index) ++next;
        if (next == keyframes.size() || keyframes[next].frame_index != frame->index) continue;
        pairs.push_back({next++, std::move(*frame), {}});
        if (pairs.size() == kPairsAtOnce) search();
    }
    search();
    return views;
}

MarkerMetrics measure_markers(const std::vector<TagView>& views,
                              const dive::MarkerPlan& plan,
                              const MarkerWorld& world) {
    MarkerMetrics metrics;
    metrics.family = plan.family;
    metrics.markers = locate_markers(views, world);
    std::vector<double> ranges_m;
    for (const Marker& marker : metrics.markers) ranges_m.push_back(marker.range_m);
    if (!ranges_m.empty())
        metrics.systematic_scale_sigma =
            kDisparityBias_px / world.rig.disparity_px(stats::upper_median(std::move(ranges_m)));
    metrics.bars =
        measure_bars(metrics.markers, plan, {drift_rate(world), metrics.systematic_scale_sigma});
    metrics.scale = scale_of(metrics.bars);
    metrics.trusted_scale = trusted_scale(metrics.bars);
    FindingWriter(views, plan, world, metrics).write();
    return metrics;
}

}  // namespace divemesh::markers
