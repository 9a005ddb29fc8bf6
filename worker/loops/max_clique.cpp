#include "worker/loops/max_clique.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace divemesh::loops {
namespace {

constexpr std::int64_t kMaxBranches = 250'000;

class Search {
public:
    explicit Search(const std::vector<std::vector<bool>>& joined) : joined_(joined) {}

    std::vector<std::size_t> run() {
        std::vector<std::size_t> all(joined_.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        std::vector<std::ptrdiff_t> degree(joined_.size());
        for (const std::size_t i : all)
            degree[i] = std::count(joined_[i].begin(), joined_[i].end(), true);
        std::stable_sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) {
            return degree[a] > degree[b];
        });
        expand(all);
        std::sort(best_.begin(), best_.end());
        return best_;
    }

private:
    struct Coloured {
        std::size_t vertex = 0;
        // From 1: an upper bound on the size of a clique among this and earlier vertices.
        std::size_t colour = 0;
    };

    // Colours the candidates. Vertices of one colour are not joined, so a clique has at most one of
    // each colour.
    std::vector<Coloured> coloured(const std::vector<std::size_t>& candidates) const {
        std::vector<std::vector<std::size_t>> classes;
        for (const std::size_t vertex : candidates) {
            const auto fits = [&](const std::vector<std::size_t>& members) {
                return std::none_of(members.begin(), members.end(), [&](std::size_t member) {
                    return joined_[vertex][member];
                });
            };
            auto own = std::find_if(classes.begin(), classes.end(), fits);
            if (own == classes.end()) own = classes.emplace(classes.end());
            own->push_back(vertex);
        }
        std::vector<Coloured> result;
        for (std::size_t i = 0; i < classes.size(); ++i)
            for (const std::size_t vertex : classes[i]) result.push_back({vertex, i + 1});
        return result;
    }

    void expand(const std::vector<std::size_t>& candidates) {
        if (current_.size() > best_.size()) best_ = current_;
        std::vector<Coloured> order = coloured(candidates);
        while (!order.empty() && num_branches_ < kMaxBranches) {
            const Coloured last = order.back();
            if (current_.size() + last.colour <= best_.size()) return;
            order.pop_back();
            ++num_branches_;
            std::vector<std::size_t> rest;
            for (const Coloured& other : order)
                if (joined_[last.vertex][other.vertex]) rest.push_back(other.vertex);
            current_.push_back(last.vertex);
            expand(rest);
            current_.pop_back();
        }
    }

    const std::vector<std::vector<bool>>& joined_;
    std::vector<std::size_t> current_;
    std::vector<std::size_t> best_;
    std::int64_t num_branches_ = 0;
};

}  // namespace

std::vector<std::size_t> max_clique(const std::vector<std::vector<bool>>& joined) {
    return Search(joined).run();
}

}  // namespace divemesh::loops
