#include "sim/address.hpp"

#include "common/config/address_query.hpp"

namespace roadbalance::sim {

Address Address::parse(const std::string& text) {
  AddressQuery query("sim", text);
  Address address;
  address.scenario_path = query.path();
  address.seed = query.number<std::uint64_t>("seed", 0, INT64_MAX);
  address.rate = query.rate();
  address.seconds = query.number("seconds", 1.0, 1e6);
  address.start_ns = query.number<std::int64_t>("start_ns", 0, INT64_MAX);
  address.from_s = query.number("from", 0.0, 1e6).value_or(0.0);
  address.clock_offset_s = query.number("clock_offset_s", -1e6, 1e6).value_or(0.0);
  address.clock_ppm = query.number("clock_ppm", -500.0, 500.0).value_or(0.0);
  address.converter_ppm = query.number("converter_ppm", -500.0, 500.0).value_or(0.0);
  query.finish();
  const bool own_clock = address.clock_offset_s != 0.0 || address.clock_ppm != 0.0;
  if (own_clock && address.rate != 1.0)
    query.fail(std::string(address.clock_ppm != 0.0 ? "clock_ppm" : "clock_offset_s") +
               ": allowed only with rate=1: at any other rate all nodes have bus time in common");
  return address;
}

}  // namespace roadbalance::sim
