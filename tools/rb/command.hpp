#pragma once

#include "common/command_line/exit_code.hpp"

namespace CLI {
class App;
}

namespace roadbalance {

/// Each adds its subcommand to `app`.  When it is chosen it runs and puts its exit code into `code`; it
/// throws ConfigError (kUsage) or another std::exception (kCannotAccess), which main prints.
void add_balance(CLI::App& app, int& code);
void add_calibrate(CLI::App& app, int& code);
void add_demo(CLI::App& app, int& code);
void add_watch(CLI::App& app, int& code);
void add_datum(CLI::App& app, int& code);
void add_doctor(CLI::App& app, int& code);
void add_distance(CLI::App& app, int& code);
void add_identify(CLI::App& app, int& code);
void add_verify(CLI::App& app, int& code);
void add_recover(CLI::App& app, int& code);
void add_info(CLI::App& app, int& code);
void add_levels(CLI::App& app, int& code);
void add_model(CLI::App& app, int& code);
void add_orders(CLI::App& app, int& code);
void add_spectrum(CLI::App& app, int& code);
void add_report(CLI::App& app, int& code);
void add_response(CLI::App& app, int& code);
void add_replay(CLI::App& app, int& code);
void add_select(CLI::App& app, int& code);
void add_reduce(CLI::App& app, int& code);
void add_export(CLI::App& app, int& code);
void add_transfer(CLI::App& app, int& code);
void add_twin(CLI::App& app, int& code);
void add_import(CLI::App& app, int& code);
void add_supervise(CLI::App& app, int& code);
void add_wiring(CLI::App& app, int& code);
void add_start(CLI::App& app, int& code);
void add_stop(CLI::App& app, int& code);
void add_mark(CLI::App& app, int& code);
void add_configure(CLI::App& app, int& code);
void add_zero(CLI::App& app, int& code);
void add_vehicle(CLI::App& app, int& code);

}  // namespace roadbalance
