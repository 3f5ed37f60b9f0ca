#pragma once

#include <nlohmann/json.hpp>

#include "host/recorder/verify.hpp"

namespace roadbalance {

/// What rb verify and rb recover say of a record: for programs, and for people on standard output.
nlohmann::ordered_json verification_json(const Verification& result);
void print_verification(const Verification& result);

}  // namespace roadbalance
