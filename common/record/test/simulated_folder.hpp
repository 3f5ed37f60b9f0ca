#pragma once

#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/record/test/simulated_file.hpp"

namespace roadbalance::test {

class SimulatedFolder;

/// A file or a folder.
struct SimulatedNode {
  std::unique_ptr<SimulatedFile> file;  ///< or
  std::unique_ptr<SimulatedFolder> folder;
  int locked_by = -1;  ///< descriptor
};

/// The names in one folder of a SimulatedDisk, as the page cache has them and as the platter has them.
///
/// A power cut undoes changes that were not synced: all after one instant, or any of them, for POSIX promises
/// nothing of their order.  A rename happens as a whole or not at all.
class SimulatedFolder {
 public:
  using Node = std::shared_ptr<SimulatedNode>;

  const std::map<std::string, Node>& entries() const { return now_; }
  Node find(const std::string& name) const;
  void add(const std::string& name, Node node);
  void remove(const std::string& name);
  void rename(const std::string& from, const std::string& to);

  void sync();
  /// With all that is in it.  @return torn sectors of its files
  std::int64_t lose_power(std::mt19937_64& random);

 private:
  using Entries = std::map<std::string, Node>;
  struct Change {
    std::string removed;  // name, or empty
    std::string added;    // name, or empty
    Node node;
  };
  static void apply(const Change& change, Entries& entries);
  void change(Change change);

  Entries now_;
  Entries platter_;
  std::vector<Change> unsynced_;
};

SimulatedFolder::Node new_folder();
/// Its own, all of it synced.
SimulatedFolder::Node copy_of(const SimulatedNode& node, std::shared_ptr<std::int64_t> used_bytes);

}  // namespace roadbalance::test
