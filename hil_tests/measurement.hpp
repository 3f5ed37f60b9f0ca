#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/test/temporary_directory.hpp"
#include "hil_tests/bus_watch.hpp"
#include "hil_tests/program.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance::test {

/// A measurement by real programs on a bus and in a folder of their own, and an observer of that bus.
class Measurement : public ::testing::Test {
 protected:
  static constexpr std::int32_t kFront = 1;  ///< numbers of the demonstration vehicle's nodes
  static constexpr std::int32_t kRear = 2;

  Measurement();
  explicit Measurement(const std::string& bus_url);

  Program recorder(const std::filesystem::path& folder, const std::vector<std::string>& more = {}) const;
  Program recorder(const std::vector<std::string>& more = {}) const { return recorder(record, more); }
  /// @param drive  more of the simulator's address, e.g. "rate=20&seconds=30"
  Program node(const std::string& name, const std::string& drive,
               const std::vector<std::string>& more = {}) const;
  Program analyser(const std::vector<std::string>& more = {}) const;

  /// Waits until the node has the acknowledgement that `blocks` more of its blocks are on the disk.
  bool more_are_durable(std::int32_t node, std::int64_t blocks);
  /// Waits until the node keeps next to nothing back.
  bool backlog_is_gone(std::int32_t node);

  /// Asks the recorder to end, which ends the nodes; all must end well.
  void end_well(Program& recorder, std::vector<Program*> nodes) const;
  /// The record must be complete by every judge: the product's own and the independent checker.
  void expect_complete(std::size_t epochs) const { expect_complete(record, epochs); }
  void expect_complete(const std::filesystem::path& folder, std::size_t epochs) const;
  /// Each acceleration and each edge of the node is the simulated car's.
  /// @param drive  of node(), but for its rate
  void expect_as_simulated(const std::string& node, const std::string& drive) const {
    expect_as_simulated(record, node, drive);
  }
  void expect_as_simulated(const std::filesystem::path& folder, const std::string& node,
                           const std::string& drive) const;
  /// By the product's own judge only: in an emulated machine the other takes a minute.
  void expect_verified(const std::filesystem::path& folder, std::size_t epochs) const;

  const TemporaryDirectory work;
  const std::filesystem::path record = work.path() / "record";
  const std::string url;
  BusWatch bus;
};

/// Exit code of the independent checker (tools/check_record.py).
int check_record(const std::filesystem::path& folder);

}  // namespace roadbalance::test
