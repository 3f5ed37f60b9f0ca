#include <cmath>
#include <string>

#include "common/config/section.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "sim/address.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  using fuzz::require;
  static fuzz::Reached addresses("an address");
  try {
    const auto address = sim::Address::parse({reinterpret_cast<const char*>(data), size});
    require(!address.rate || (*address.rate > 0 && std::isfinite(*address.rate)), "a rate is positive");
    require(!address.seconds || (*address.seconds > 0 && std::isfinite(*address.seconds)),
            "a length is positive");
    require(std::isfinite(address.from_s), "the start is a number");
    addresses.count();
  } catch (const ConfigError& error) {
    require(error.what()[0] != 0, "an error says something");
  }
  return 0;
}
