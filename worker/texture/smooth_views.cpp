#include "worker/texture/smooth_views.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

namespace divemesh::texture {
namespace {

constexpr int kNumSweeps = 40;
constexpr int kMaxDescents = 20;
constexpr std::size_t kSlice = 2048;  // triangles

using FaceGroups = std::vector<std::vector<std::uint32_t>>;
using Energies = std::array<float, FaceCandidates::kMaxViews>;  // one per candidate

// Calls work(face) for a group of triangles, none the neighbour of another.
template <typename Work>
void for_each_face(int num_threads, const std::vector<std::uint32_t>& group, const Work& work) {
    base::for_each_index(num_threads, (group.size() + kSlice - 1) / kSlice, [&](std::size_t slice) {
        const std::size_t end = std::min(group.size(), (slice + 1) * kSlice);
        for (std::size_t i = slice * kSlice; i < end; ++i) work(group[i]);
    });
}

// What neighbours tell each other: what each view of the receiver would add to the energy of the
// sender's side. That lies between nothing and a seam, of which it is stored as a share.
class Messages {
public:
    explicit Messages(const ViewField& field) : field_(field), begin_(field.graph.num_faces() + 1) {
        for (std::size_t face = 0; face < field.graph.num_faces(); ++face)
            begin_[face + 1] =
                begin_[face] + field.graph.links(face).size() * field.candidates.of(face).size();
        shares_.assign(begin_.back(), 0);
        is_news_.assign(field.graph.num_links(), 1);
    }

    // Returns the energy of each candidate of a triangle with all that its neighbours told it.
    Energies energies(std::size_t face) const {
        Energies energies;
        std::size_t num = 0;
        field_.for_each_view(face, [&](std::uint16_t, float cost) { energies[num++] = cost; });
        const auto links = field_.graph.links(face);
        for (std::size_t k = 0; k < links.size(); ++k)
            for (std::size_t i = 0; i < num; ++i)
                energies[i] += received(face, k)[i] * scale(links[k]);
        return energies;
    }

    // Tells the neighbours of a triangle what it knows, to each without what came from there. Does
    // nothing if they told it no news since: most of a mesh is settled after a few sweeps.
    void send(std::size_t face) {
        if (!take_news(face)) return;
        const Energies all = energies(face);
        const auto links = field_.graph.links(face);
        const std::size_t num = field_.candidates.of(face).size();
        for (std::size_t k = 0; k < links.size() && num > 0; ++k) {
            Energies without = all;
            for (std::size_t i = 0; i < num; ++i)
                without[i] -= received(face, k)[i] * scale(links[k]);
            tell(face, links[k], without);
        }
    }

private:
    static constexpr float kWhole = 65535.0F;
    static constexpr int kNews = 64;  // 0.1 % of a seam

    // Returns true for a triangle with news, which is none any more.
    bool take_news(std::size_t face) {
        const std::size_t num = field_.graph.links(face).size();
        const auto first = is_news_.begin() + field_.graph.first_link(face);
        const bool has_news = std::find(first, first + num, 1) != first + num;
        std::fill(first, first + num, std::uint8_t{0});
        return has_news;
    }

    float scale(const FaceLink& link) const { return field_.seam_cost(link) / kWhole; }
    const std::uint16_t* received(std::size_t face, std::size_t link) const {
        return shares_.data() + begin_[face] + link * field_.candidates.of(face).size();
    }

    void tell(std::size_t face, const FaceLink& link, const Energies& energies) {
        const std::span<const Candidate> own = field_.candidates.of(face);
        const std::span<const Candidate> theirs = field_.candidates.of(link.face);
        const float least = *std::min_element(energies.begin(), energies.begin() + own.size());
        const float seam = field_.seam_cost(link);
        std::uint16_t* shares = shares_.data() + begin_[link.face] +
                                (link.back - field_.graph.first_link(link.face)) * theirs.size();
        std::size_t i = 0;
        for (std::size_t j = 0; j < theirs.size(); ++j) {  // both in ascending order of the views
            while (i < own.size() && own[i].view < theirs[j].view) ++i;
            const bool is_common = i < own.size() && own[i].view == theirs[j].view;
            const float excess = is_common ? energies[i] - least : seam;
            const auto share = excess < seam
                                   ? static_cast<std::uint16_t>(kWhole * excess / seam + 0.5F)
                                   : std::uint16_t{0xffff};
            if (std::abs(share - shares[j]) > kNews) is_news_[link.back] = 1;
            shares[j] = share;
        }
    }

    const ViewField& field_;
    std::vector<std::size_t> begin_;  // of what each triangle receives, link by link
    std::vector<std::uint16_t> shares_;
    std::vector<std::uint8_t> is_news_;  // for each link of a triangle, what came over it
};

// Returns the view of a triangle with the least energy, the first of equals.
std::int32_t best_view(std::span<const Candidate> candidates, const Energies& energies) {
    if (candidates.empty()) return kNoView;
    const auto best = std::min_element(energies.begin(), energies.begin() + candidates.size());
    return candidates[static_cast<std::size_t>(best - energies.begin())].view;
}

// Returns the energy of each candidate of a triangle beside the views of its neighbours.
Energies energies_beside(const ViewField& field, const FaceViews& views, std::size_t face) {
    Energies energies;
    std::size_t num = 0;
    field.for_each_view(face, [&](std::uint16_t view, float cost) {
        for (const FaceLink& link : field.graph.links(face))
            if (views[link.face] != view && views[link.face] != kNoView)
                cost += field.seam_cost(link);
        energies[num++] = cost;
    });
    return energies;
}

}  // namespace

void descend(const ViewField& field, int num_threads, FaceViews& views) {
    const FaceGroups groups = independent_faces(field.graph);
    for (int i = 0; i < kMaxDescents; ++i) {
        const FaceViews before = views;
        for (const auto& group : groups)
            for_each_face(num_threads, group, [&](std::uint32_t face) {
                views[face] =
                    best_view(field.candidates.of(face), energies_beside(field, views, face));
            });
        if (views == before) return;
    }
}

FaceViews smooth_views(const ViewField& field,
                       int num_threads,
                       const base::ProgressShare& progress) {
    const FaceGroups groups = independent_faces(field.graph);
    Messages messages(field);
    for (int sweep = 0; sweep < kNumSweeps; ++sweep)
        for (std::size_t i = 0; i < groups.size(); ++i) {
            progress.at((sweep + static_cast<double>(i) / static_cast<double>(groups.size())) /
                        kNumSweeps);
            const std::size_t group = sweep % 2 == 0 ? i : groups.size() - 1 - i;  // there and back
            for_each_face(
                num_threads, groups[group], [&](std::uint32_t face) { messages.send(face); });
        }
    FaceViews views(field.graph.num_faces(), kNoView);
    for (const auto& group : groups)
        for_each_face(num_threads, group, [&](std::uint32_t face) {
            views[face] = best_view(field.candidates.of(face), messages.energies(face));
        });
    descend(field, num_threads, views);
    return views;
}

}  // namespace divemesh::texture
