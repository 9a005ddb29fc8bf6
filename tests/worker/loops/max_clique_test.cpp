#include "worker/loops/max_clique.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace divemesh::loops {
namespace {

using Graph = std::vector<std::vector<bool>>;

Graph random_graph(std::size_t num_vertices, double density, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::bernoulli_distribution is_joined(density);
    Graph joined(num_vertices, std::vector<bool>(num_vertices, false));
    for (std::size_t i = 0; i < num_vertices; ++i)
        for (std::size_t j = i + 1; j < num_vertices; ++j)
            joined[i][j] = joined[j][i] = is_joined(random);
    return joined;
}

bool is_clique(const Graph& joined, const std::vector<std::size_t>& set) {
    for (const std::size_t a : set)
        for (const std::size_t b : set)
            if (a != b && !joined[a][b]) return false;
    return true;
}

std::size_t max_by_trying_all(const Graph& joined) {
    std::size_t largest = 0;
    for (unsigned bits = 0; bits < 1U << joined.size(); ++bits) {
        std::vector<std::size_t> set;
        for (std::size_t i = 0; i < joined.size(); ++i)
            if (bits >> i & 1U) set.push_back(i);
        if (set.size() > largest && is_clique(joined, set)) largest = set.size();
    }
    return largest;
}

TEST(MaxCliqueTest, IsAsLargeAsTryingAllSetsFinds) {
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const Graph joined = random_graph(12, 0.1 * (1 + seed), seed);
        const auto clique = max_clique(joined);
        EXPECT_TRUE(is_clique(joined, clique)) << "seed " << seed;
        EXPECT_EQ(clique.size(), max_by_trying_all(joined)) << "seed " << seed;
    }
}

TEST(MaxCliqueTest, FindsSixtyThatAgreeAmongTwoHundredThatDoNot) {
    Graph joined = random_graph(260, 0.2, 5);
    std::vector<std::size_t> planted;
    for (std::size_t i = 3; planted.size() < 60; i += 4) planted.push_back(i);
    for (const std::size_t a : planted)
        for (const std::size_t b : planted) joined[a][b] = a != b;
    EXPECT_EQ(max_clique(joined), planted);
}

TEST(MaxCliqueTest, AnEmptyGraphHasAnEmptyClique) { EXPECT_TRUE(max_clique({}).empty()); }

}  // namespace
}  // namespace divemesh::loops
