#include "common/command_line/manual.hpp"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "common/command_line/commands.hpp"
#include "common/command_line/completion.hpp"
#include "common/command_line/manual_page.hpp"

namespace roadbalance {
namespace {

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  if (!(file << text << std::flush))
    throw CLI::FileError("cannot write " + path.string() + ": " + std::generic_category().message(errno));
}

void write_pages(const CLI::App& command, const std::filesystem::path& folder) {
  write_file(folder / (page_name(command) + ".1"), manual_page(command));
  for (const CLI::App* one : commands_of(command)) write_pages(*one, folder);
}

}  // namespace

void add_manual(CLI::App& app) {
  const auto write = [&app](const std::string& name) {
    const std::filesystem::path folder(name);
    std::error_code trouble;
    std::filesystem::create_directories(folder, trouble);  // what is in the way shows when a file is written
    write_pages(app, folder);
    write_file(folder / (app.get_name() + ".bash"), bash_completion(app));
    throw CLI::Success();
  };
  app.add_option_function<std::string>("--write-manual", write)->trigger_on_parse()->group("");
}

}  // namespace roadbalance
