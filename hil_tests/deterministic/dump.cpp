#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "hil_tests/deterministic/world.hpp"

namespace roadbalance::test {
namespace {

void write_file(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes, static_cast<std::streamsize>(size));
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + path.string());
}

// What an epoch's nodes and recorders said and did, for tools/record_check/truth.py to judge.
nlohmann::json deeds_of(const EpochTruth& epoch, const RecordCheck::Said& said) {
  nlohmann::json declared = nlohmann::json::array();
  for (const auto& [sequence, then] : said.declared)
    declared.push_back({{"sequence", sequence},
                        {"promised", then.promised},
                        {"released", then.released},
                        {"may_lack_more", then.may_lack_more}});
  return {{"node", epoch.node},    {"epoch", epoch.epoch},      {"openings", epoch.openings},
          {"scans", epoch.scans},  {"promised", said.promised}, {"declared", declared},
          {"obeyed", epoch.obeyed}};
}

// Of several recorders only the one that saw the end of an epoch must have it.
std::string truth_of(const Truth& truth, const RecordCheck& check, bool only_recorder) {
  nlohmann::json epochs = nlohmann::json::array();
  for (const auto& [key, epoch] : truth.epochs()) {
    const bool must_end = only_recorder || check.is_closed(epoch.node, epoch.epoch);
    const RecordCheck::Said* said = check.said(epoch.node, epoch.epoch);
    epochs.push_back(deeds_of(epoch, said ? *said : RecordCheck::Said()));
    epochs.back()["ended"] = epoch.ended && must_end;
    epochs.back()["killed"] = epoch.killed && must_end;
  }
  return nlohmann::json{{"hashed", true}, {"epochs", epochs}}.dump(2) + "\n";
}

}  // namespace

// Folder N of recorder N: everything its disk holds, of two folders what rb recover made of them.
void World::dump(const std::string& folder) {
  for (std::size_t h = 0; h < hosts_.size(); ++h) {
    const auto into = std::filesystem::path(folder) / std::to_string(h + 1);
    std::filesystem::remove_all(into);
    std::filesystem::create_directories(into);
    SimulatedDisk& disk = hosts_[h].machine->disk();
    const std::string from = hosts_[h].machine->record_folder();
    const auto names = disk.list(from.c_str());
    for (const std::string& name : names ? *names : std::vector<std::string>()) {
      const auto bytes = disk.content(from + "/" + name);
      write_file(into / name, reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    const std::string truth = truth_of(truth_, hosts_[h].machine->check(), hosts_.size() == 1);
    write_file(into / "truth.json", truth.data(), truth.size());
  }
}

}  // namespace roadbalance::test
