#include "cli/scratch.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "schemas/error.hpp"

namespace divemesh::cli {

ScratchFolder::ScratchFolder(const std::filesystem::path& parent) {
    std::string name = (parent / "divemesh-scratch.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        throw Error(ErrorCode::OutOfSpace,
                    "cannot create a folder in " + parent.string() + ": " + strerror(errno));
    path_ = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

}  // namespace divemesh::cli
