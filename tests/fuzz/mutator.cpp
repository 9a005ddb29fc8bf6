#include "tests/fuzz/mutator.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace divemesh::fuzz {
namespace {

constexpr std::size_t kMaxChanges = 4;
constexpr std::size_t kMaxChunkBytes = 64;

// Where signs, widths and sizes turn over.
constexpr std::array kIntegers{std::int64_t{0},
                               std::int64_t{-1},
                               std::int64_t{1},
                               std::int64_t{0x7f},
                               std::int64_t{0x80},
                               std::int64_t{0xff},
                               std::int64_t{0x7fff},
                               std::int64_t{0x8000},
                               std::int64_t{0xffff},
                               std::int64_t{0x10000},
                               std::int64_t{0x7fffffff},
                               std::int64_t{0x80000000},
                               std::int64_t{0xffffffff},
                               std::numeric_limits<std::int64_t>::max(),
                               std::numeric_limits<std::int64_t>::min()};

// What text holds in the place of a number.
constexpr std::array kNumbers{
    "nan", "inf", "-0", "1e308", "1e-320", "0x10", "18446744073709551616", "", "-", "1e", "+1"};

bool is_of_number(char c) { return (c >= '0' && c <= '9') || c == '.'; }

}  // namespace

Mutator::Mutator(std::vector<std::string> corpus, std::uint64_t seed, std::size_t max_bytes)
    : corpus_(std::move(corpus)), random_(seed), max_bytes_(max_bytes) {
    if (corpus_.empty()) corpus_.emplace_back();
}

std::string Mutator::next() {
    std::string input = any_of_corpus();
    for (std::size_t changes = 1 + below(kMaxChanges); changes > 0; --changes) change(input);
    input.resize(std::min(input.size(), max_bytes_));
    return input;
}

void Mutator::change(std::string& input) {
    switch (below(8)) {
        case 0: return flip_bit(input);
        case 1: return replace_byte(input);
        case 2: return insert_bytes(input);
        case 3: return remove_bytes(input);
        case 4: return repeat_bytes(input);
        case 5: return write_integer(input);
        case 6: return write_number(input);
        default: return splice(input);
    }
}

void Mutator::flip_bit(std::string& input) {
    if (!input.empty()) input[below(input.size())] ^= static_cast<char>(1U << below(8));
}

void Mutator::replace_byte(std::string& input) {
    if (!input.empty()) input[below(input.size())] = static_cast<char>(below(256));
}

void Mutator::insert_bytes(std::string& input) {
    const auto byte = static_cast<char>(below(256));
    input.insert(below(input.size() + 1), 1 + below(kMaxChunkBytes), byte);
}

void Mutator::remove_bytes(std::string& input) {
    input.erase(below(input.size() + 1), 1 + below(kMaxChunkBytes));
}

void Mutator::repeat_bytes(std::string& input) {
    const auto piece = input.substr(below(input.size() + 1), 1 + below(kMaxChunkBytes));
    input.insert(below(input.size() + 1), piece);
}

// In 1, 2, 4 or 8 bytes, of either byte order.
void Mutator::write_integer(std::string& input) {
    const auto value = static_cast<std::uint64_t>(kIntegers[below(kIntegers.size())]);
    std::string bytes;
    for (std::size_t n = std::size_t{1} << below(4); bytes.size() < n;)
        bytes += static_cast<char>(value >> (8 * bytes.size()));
    if (below(2) == 0) std::reverse(bytes.begin(), bytes.end());
    const auto at = below(input.size() + 1);
    input.replace(at, bytes.size(), bytes);
}

void Mutator::write_number(std::string& input) {
    const auto from =
        std::find_if(input.begin() + static_cast<std::ptrdiff_t>(below(input.size() + 1)),
                     input.end(),
                     is_of_number);
    const auto to = std::find_if_not(from, input.end(), is_of_number);
    const auto integer = kIntegers[below(kIntegers.size())];
    const std::string number =
        below(2) == 0 ? std::to_string(integer) : kNumbers[below(kNumbers.size())];
    input.replace(from, to, number);
}

void Mutator::splice(std::string& input) {
    const std::string& other = any_of_corpus();
    input.erase(below(input.size() + 1));
    input += other.substr(below(other.size() + 1));
}

}  // namespace divemesh::fuzz
