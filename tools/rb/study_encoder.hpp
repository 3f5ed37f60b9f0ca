#pragma once

namespace roadbalance {

/// `rb study encoder`: every pulse train of encoder_rows() through the live encoder and the offline one;
/// prints a table or, with `json`, {"rows": [...], "met"} on one line.  Exit code kAnswerIsNo if a row is not
/// met.
int study_encoder(bool json);

}  // namespace roadbalance
