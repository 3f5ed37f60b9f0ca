#pragma once

#include <cstdint>
#include <optional>

namespace roadbalance {

struct EncoderStudyOptions {
  bool json = false, markdown = false;
  int runs = 1;                       ///< of each row, with other noise
  std::optional<std::uint64_t> seed;  ///< of the first run; unset: the rows' own
};

/// `rb study encoder`: every pulse train of encoder_rows() through the live encoder and the offline one, and
/// phases injected into the chain from edges and conversions to blocks (phase_injection_rows()); prints a
/// table, with `markdown` one in Markdown or, with `json`, {"rows": [...], "met"} on one line.  Exit code
/// kAnswerIsNo if a row is not met.
int study_encoder(const EncoderStudyOptions& options);

}  // namespace roadbalance
