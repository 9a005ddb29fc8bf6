#include "worker/simulator/path_time.hpp"

#include "schemas/error.hpp"

namespace divemesh::simulator {

PathTime::PathTime(const std::vector<Rest>& rests) {
    for (const Rest& here : rests) rest(here);
    add(0.0, 1.0, 1.0);
}

void PathTime::add(double duration_s, double rate_begin, double rate_end) {
    segments_.push_back({end_s_, path_end_s_, duration_s, rate_begin, rate_end});
    end_s_ += duration_s;
    path_end_s_ += 0.5 * (rate_begin + rate_end) * duration_s;
}

void PathTime::rest(const Rest& rest) {
    const double swum_s = rest.path_s - 0.5 * kRamp_s - path_end_s_;
    const bool begins_at_rest = segments_.empty() && rest.path_s <= 0.0;
    if (!begins_at_rest) {
        if (swum_s < 0.0)
            throw Error(ErrorCode::InvalidArgument,
                        "two pauses follow each other within a second: choose other places");
        add(swum_s, 1.0, 1.0);
        add(kRamp_s, 1.0, 0.0);
    }
    add(rest.duration_s, 0.0, 0.0);
    add(kRamp_s, 0.0, 1.0);
}

Jet PathTime::at(double t_s) const {
    const Segment* segment = segments_.data();
    for (const Segment& next : segments_)
        if (next.begin_s <= t_s) segment = &next;
    const double since_s = t_s - segment->begin_s;
    const double change = segment->rate_end - segment->rate_begin;
    if (change == 0.0)
        return {segment->path_begin_s + segment->rate_begin * since_s, segment->rate_begin, 0.0};
    const double u = since_s / segment->duration_s;
    return {segment->path_begin_s + segment->rate_begin * since_s +
                change * segment->duration_s * u * u * u * (1.0 - 0.5 * u),
            segment->rate_begin + change * u * u * (3.0 - 2.0 * u),
            change * 6.0 * u * (1.0 - u) / segment->duration_s};
}

double PathTime::end_of(double path_s) const {
    return path_s < path_end_s_ ? end_s_ - kRamp_s : end_s_ + path_s - path_end_s_;
}

}  // namespace divemesh::simulator
