#include "common/command_line/bus_url.hpp"

#include <CLI/CLI.hpp>

#include "common/bus/bus.hpp"

namespace roadbalance {

CLI::Option* add_bus_url(CLI::App& app, std::string& url, const std::string& description) {
  url = default_bus_url();
  // The manual is written where the programs are built: it must not contain that computer's address.
  return app.add_option("--url", url, description)
      ->default_str(std::string("$") + kBusUrlVariable + ", or " + bus_url_on_port(BusAddress{}.port));
}

}  // namespace roadbalance
