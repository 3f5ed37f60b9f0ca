#include "common/record/test/simulated_folder.hpp"

#include <utility>

namespace roadbalance::test {

SimulatedFolder::Node SimulatedFolder::find(const std::string& name) const {
  const auto found = now_.find(name);
  return found == now_.end() ? nullptr : found->second;
}

void SimulatedFolder::add(const std::string& name, Node node) {
  change({.removed = {}, .added = name, .node = std::move(node)});
}

void SimulatedFolder::remove(const std::string& name) {
  change({.removed = name, .added = {}, .node = nullptr});
}

void SimulatedFolder::rename(const std::string& from, const std::string& to) {
  change({.removed = from, .added = to, .node = find(from)});
}

void SimulatedFolder::apply(const Change& change, Entries& entries) {
  if (!change.removed.empty()) entries.erase(change.removed);
  if (!change.added.empty()) entries[change.added] = change.node;
}

void SimulatedFolder::change(Change change) {
  apply(change, now_);
  unsynced_.push_back(std::move(change));
}

void SimulatedFolder::sync() {
  for (const Change& change : unsynced_) apply(change, platter_);
  unsynced_.clear();
}

std::int64_t SimulatedFolder::lose_power(std::mt19937_64& random) {
  const bool in_order = (random() >> 40 & 1) != 0;
  for (const Change& change : unsynced_) {
    const bool kept = (random() >> 40 & 1) != 0;
    if (in_order && !kept) break;
    if (kept) apply(change, platter_);
  }
  unsynced_.clear();
  now_ = platter_;
  std::int64_t torn = 0;
  for (const auto& [name, node] : now_) {
    node->locked_by = -1;
    if (node->folder) torn += node->folder->lose_power(random);
    if (node->file) torn += node->file->lose_power(random);
  }
  return torn;
}

SimulatedFolder::Node new_folder() {
  auto node = std::make_shared<SimulatedNode>();
  node->folder = std::make_unique<SimulatedFolder>();
  return node;
}

SimulatedFolder::Node copy_of(const SimulatedNode& node, std::shared_ptr<std::int64_t> used_bytes) {
  if (node.folder) {
    auto copy = new_folder();
    for (const auto& [name, entry] : node.folder->entries())
      copy->folder->add(name, copy_of(*entry, used_bytes));
    copy->folder->sync();
    return copy;
  }
  auto copy = std::make_shared<SimulatedNode>();
  copy->file = std::make_unique<SimulatedFile>(used_bytes);
  std::vector<std::uint8_t> content(node.file->size());
  (void)node.file->read(0, content);
  copy->file->write(0, content);
  copy->file->sync();
  return copy;
}

}  // namespace roadbalance::test
