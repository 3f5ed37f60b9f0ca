#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "hil_tests/deterministic/random.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// A person who makes one request after the other, each repeated until it has its final answer, as
/// tools/rb/asking does; also requests that may not be answered then and there.
class Asker {
 public:
  struct Asked {
    Request request;
    std::int64_t at_ns = 0;
    int unsure_deaths = 0;           ///< of the recorder, until then
    std::optional<Answer> answer{};  ///< the last word
    bool is_unsure = false;   ///< before it a recorder died with a session state that its disk had not taken
    std::string under_way{};  ///< the text of the answer before it
  };

  Asker(std::int64_t number, std::uint64_t seed, Truth& truth)
      : number_(number), random_(seed, 0), truth_(truth) {}

  /// Its request now; nothing: it waits.
  /// @param drive_is_over  it asks for nothing new but a stop, if that is wanted
  /// @param unsure_deaths  of the recorder until now, with a session state that its disk had not taken
  std::optional<Request> turn(std::int64_t now_ns, bool drive_is_over, bool wants_stop, int unsure_deaths);
  void take(const Answer& answer, int unsure_deaths);

  bool waits() const { return !asked_.empty() && !asked_.back().answer && !gave_up_; }
  const std::vector<Asked>& asked() const { return asked_; }

 private:
  Request invent();

  const std::int64_t number_;
  Random random_;
  Truth& truth_;
  std::vector<Asked> asked_;
  bool gave_up_ = false;
  std::int64_t next_ns_ = 0;   // it asks for something new
  std::int64_t again_ns_ = 0;  // it repeats what it waits for
};

}  // namespace roadbalance::test
