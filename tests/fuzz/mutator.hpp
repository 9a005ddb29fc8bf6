#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace divemesh::fuzz {

// Makes new inputs from a corpus, the same ones for the same seed.
class Mutator {
public:
    Mutator(std::vector<std::string> corpus, std::uint64_t seed, std::size_t max_bytes);

    // Returns an entry of the corpus, changed in a few places and cut to max_bytes.
    std::string next();

private:
    std::size_t below(std::size_t bound) { return bound == 0 ? 0 : random_() % bound; }
    const std::string& any_of_corpus() { return corpus_[below(corpus_.size())]; }
    void change(std::string& input);
    void flip_bit(std::string& input);
    void replace_byte(std::string& input);
    void insert_bytes(std::string& input);
    void remove_bytes(std::string& input);
    void repeat_bytes(std::string& input);
    void write_integer(std::string& input);
    void write_number(std::string& input);
    void splice(std::string& input);

    std::vector<std::string> corpus_;
    std::mt19937_64 random_;
    std::size_t max_bytes_;
};

}  // namespace divemesh::fuzz
