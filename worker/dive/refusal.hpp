#pragma once

#include <string>
#include <utility>

#include "schemas/error.hpp"
#include "schemas/finding.hpp"

namespace divemesh::dive {

// Error{BadData} for input that is not a dive at all, with the finding that describes it.
class Refusal : public Error {
public:
    Refusal(std::string code, std::string where, const std::string& message, std::string remedy)
        : Error(ErrorCode::BadData, message + "; " + remedy),
          finding_{Severity::Error, std::move(code), std::move(where), message, std::move(remedy)} {
    }

    const Finding& finding() const { return finding_; }

private:
    Finding finding_;
};

}  // namespace divemesh::dive
