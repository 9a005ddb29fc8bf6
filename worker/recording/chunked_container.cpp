#include "worker/recording/chunked_container.hpp"

#include <utility>

namespace divemesh::recording {

BlockContents ChunkedContainer::read(const Block& block) const {
    return parse(open(file_.read(block.offset_bytes, block.size_bytes)).bytes);
}

void ChunkedContainer::add(const Block& block, dive::FindingLog& findings) {
    if (block.size_bytes > kMaxBlock_bytes)
        return report_damage(block.offset_bytes,
                             "a record states " + std::to_string(block.size_bytes) +
                                 " bytes, more than are read at once",
                             findings);
    OpenedBlock opened = open(file_.read(block.offset_bytes, block.size_bytes));
    if (!opened.problem.empty()) return report_damage(block.offset_bytes, opened.problem, findings);
    count_unpacked(std::ssize(opened.bytes));
    learn(opened.bytes);
    add_block(block, parse(std::move(opened.bytes)));
}

}  // namespace divemesh::recording
