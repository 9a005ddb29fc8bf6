#pragma once

#include <string>
#include <utility>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh {

// One fault of an input, and where it is: a JSON pointer (RFC 6901), or a query parameter.
struct Fault {
    std::string detail;
    std::string pointer;
    std::string parameter;
};

// All faults of an input that can be found at once.
class InvalidInput : public Error {
public:
    explicit InvalidInput(std::vector<Fault> faults)
        : Error(ErrorCode::InvalidArgument, joined(faults)), faults_(std::move(faults)) {}

    const std::vector<Fault>& faults() const { return faults_; }
    // Returns the same faults for a document that holds the input under `pointer`.
    InvalidInput below(const std::string& pointer) const {
        std::vector<Fault> faults = faults_;
        for (Fault& fault : faults) fault.pointer.insert(0, pointer);
        return InvalidInput(std::move(faults));
    }

private:
    static std::string joined(const std::vector<Fault>& faults) {
        std::string text;
        for (const Fault& fault : faults)
            text.append(text.empty() ? "" : "; ").append(fault.detail);
        return text;
    }

    std::vector<Fault> faults_;
};

}  // namespace divemesh
