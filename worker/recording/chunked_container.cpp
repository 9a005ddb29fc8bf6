#include "worker/recording/chunked_container.hpp"

#include <utility>

namespace divemesh::recording {

BlockContents ChunkedContainer::read(const Block& block) const {
    return parse(open(file_.read(block.begin, block.size())).bytes);
}

void ChunkedContainer::add(const Block& block, dive::FindingLog& findings) {
    if (block.size() > kMaxBlock_bytes)
        return report_damage(block.begin,
                             "a record states " + std::to_string(block.size()) +
                                 " bytes, more than are read at once",
                             findings);
    OpenedBlock opened = open(file_.read(block.begin, block.size()));
    if (!opened.problem.empty()) return report_damage(block.begin, opened.problem, findings);
    count_unpacked(std::ssize(opened.bytes));
    learn(opened.bytes);
    add_block(block, parse(std::move(opened.bytes)));
}

}  // namespace divemesh::recording
