#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "schemas/finding.hpp"

namespace divemesh::dive {

// Collects findings. It keeps the first ten of each code and one more that counts the rest, so that
// the list stays short for a dive of a million broken images. For one thread at a time.
class FindingLog {
public:
    void error(std::string code, std::string where, std::string message, std::string remedy);
    void warning(std::string code, std::string where, std::string message, std::string remedy);
    void info(std::string code, std::string where, std::string message);
    void add(Finding finding);

    const std::vector<Finding>& all() const { return findings_; }

private:
    std::vector<Finding> findings_;
    std::map<std::string, std::int64_t> num_seen_;
    std::map<std::string, std::size_t> summary_index_;
};

}  // namespace divemesh::dive
