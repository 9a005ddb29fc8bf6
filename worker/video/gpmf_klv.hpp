#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

// The keys and values of which GPMF is made.
namespace divemesh::video {

// A key with its value.
struct Klv {
    std::string_view key;
    char type = '\0';  // '\0': the value is a list of such keys; '?': of what TYPE before it states
    std::size_t sample_bytes = 0;
    std::size_t num_samples = 0;
    std::string_view value;
};

// Takes keys from the front of a list.
class KlvList {
public:
    explicit KlvList(std::string_view bytes) : bytes_(bytes) {}

    // Returns the next key; nullopt at the end, or where a length contradicts the bytes there are.
    std::optional<Klv> next();
    bool is_damaged() const { return is_damaged_; }

private:
    std::string_view bytes_;
    bool is_damaged_ = false;
};

// How deep lists are in each other at most: DEVC, STRM and what they hold.
inline constexpr int kMaxKlvDepth = 8;

std::uint64_t big_endian(std::string_view bytes);

// Returns the size of a number of a type; 0 for a type that is no number.
std::size_t size_of_type(char type);

// Returns all numbers of a value, whatever its samples; none for a type that is no number.
std::vector<double> numbers_of(const Klv& klv);

// Returns the numbers of a sample for each sample, of types in order, such as "lllS"; none if those
// are not the size of a sample, or one is no number.
std::vector<std::vector<double>> samples_of(const Klv& klv, std::string_view types);

}  // namespace divemesh::video
