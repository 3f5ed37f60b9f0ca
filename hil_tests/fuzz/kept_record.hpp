#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "common/record/test/simulated_disk.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/true_node.hpp"

namespace roadbalance::fuzz {

/// Blocks of honest nodes, by node and epoch.
using Sequences = std::map<std::pair<std::int32_t, std::int64_t>, std::set<std::int64_t>>;

/// A record as the recorder makes it: segments with their indexes, notes, clocks, journal, commits and
/// manifest, of two nodes that come to their ends or do not, with kills and power cuts in between.
struct KeptRecord {
  Sequences durable;     ///< by its recorder
  bool has_all = false;  ///< each node that began came to its end
  bool closed = false;   ///< else its recorder was killed in the end, or the power went

  static constexpr const char* kFolder = "/record";
  /// As the fuzzer chooses; a few bytes are a whole one.
  static KeptRecord make(ByteReader& in, test::SimulatedDisk& disk);
};

/// The block of that number of one of its nodes; nullptr: no node sealed it.
const SealedBlock* kept_block(const BlockHeader& header);

/// Bits, lengths and stretches of any file of the folder, and files that are gone.  Returns how often.
int damage_files(const char* folder, ByteReader& in, test::SimulatedDisk& disk);

}  // namespace roadbalance::fuzz
