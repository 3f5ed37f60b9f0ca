#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "host/recorder/control/session_state.hpp"

namespace roadbalance {

// Answers as messages: they bear the request's numbers, by which the asker recognises them.

RequestKey key_of(const Request& request);
/// False: no answer is waited for, the recorder began by itself.
bool was_asked(const RequestKey& key);

Answer done(const RequestKey& key, Operation operation, std::string text, std::int64_t utc_us);
/// Under way: it is not durable yet.
Answer answer_about(const Mark& mark, std::int64_t utc_us);

/// The recording has ended: the last word about a mark that was under way.
Answer at_the_end(Answer mark, bool is_durable);

/// As far as it has come.
Answer answer_about(const AskedSetUp& set_up, std::int64_t utc_us);

/// For people: "1, 2".
std::string listed(const std::vector<std::int32_t>& nodes);

/// For people, behind a sentence: the nodes that lack an end, or whose end contradicts; empty: none.
std::string what_is_wrong(const std::vector<Receipt>& receipts);

}  // namespace roadbalance
